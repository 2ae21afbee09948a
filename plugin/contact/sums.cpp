// Sums of hits, four numbers at a time: nearly all of them are a weight times the vector (1, x, y,
// z). In double, which costs no more than float here, and in lengths of the hits' own size.
#include "sums.h"

#include "simd.h"

#include <algorithm>

namespace cloudcontact {

namespace {

// Made from numbers in registers; Eigen's go through memory, which costs 40 % of the whole.
typedef double Four __attribute__((vector_size(32)));

Vec3 tail(const Four& v) {
  return {v[1], v[2], v[3]};
}

// Three rows n_j (1, x, y, z).
struct Rows {
  Four row[3] = {};

  void add(double nx, double ny, double nz, const Four& v) {
    row[0] += nx * v;
    row[1] += ny * v;
    row[2] += nz * v;
  }
  Vec3 plain() const { return Vec3(row[0][0], row[1][0], row[2][0]); }
  Eigen::Matrix3d byPlace() const {
    Eigen::Matrix3d m;
    for (int j = 0; j < 3; ++j) m.row(j) = tail(row[j]).transpose();
    return m;
  }
};

// The vector that belongs to a matrix n x^T: sum of x cross n.
Vec3 crossOf(const Eigen::Matrix3d& nx) {
  return {nx(2, 1) - nx(1, 2), nx(0, 2) - nx(2, 0), nx(1, 0) - nx(0, 1)};
}

// Sums of hits of one body, lengths in units; `own` and `other`: by whose normals.
struct Part {
  Four area = {}, faced = {};  // times (1, x, y, z)
  Rows second, normalOwn, normalOther, apart, pushOwn, pushOther;
  Four powers = {};                   // pressed, squares, cubes, areas of whole samples
  Four wallOwn = {}, wallOther = {};  // (0, x, y, z)
  double middle = 0;
  float deepest = -1e30f;

  template <bool Both>
  void add(const HitColumns::Columns<const float>& c, std::size_t i, double gate,
           const double* origin, double perUnit) {
    const double whole = c.area[i] * perUnit * perUnit, pressed = whole * (c.depth1[i] * perUnit);
    const double w = gate * whole * c.share[i], f = gate * pressed, blind = pressed - f;
    const double weighed = gate * whole * perUnit * perUnit;
    const double x = (c.x[i] - origin[0]) * perUnit, y = (c.y[i] - origin[1]) * perUnit,
                 z = (c.z[i] - origin[2]) * perUnit;
    const Four v = {1, x, y, z};
    const double nx = c.ownX[i], ny = c.ownY[i], nz = c.ownZ[i];
    const double mx = c.otherX[i], my = c.otherY[i], mz = c.otherZ[i];
    area += w * v;
    faced += f * v;
    second.add(w * x, w * y, w * z, v);
    normalOwn.add(w * nx, w * ny, w * nz, v);
    normalOther.add(w * mx, w * my, w * mz, v);
    apart.add(f * (nx + mx), f * (ny + my), f * (nz + mz), v);
    pushOwn.add(pressed * nx, pressed * ny, pressed * nz, v);
    wallOwn += blind * Four{0, nx, ny, nz};
    if (Both) {
      pushOther.add(pressed * mx, pressed * my, pressed * mz, v);
      wallOther += blind * Four{0, mx, my, mz};
    }
    powers += Four{pressed, weighed * c.depth2[i], weighed * perUnit * c.depth3[i], w * whole};
    middle += f * (c.depth[i] * perUnit);
    deepest = std::max(deepest, c.depth[i]);
  }

  void give(Sums& sums, int hits, bool oneSided, Side side, double unit) const {
    const double u2 = unit * unit, u3 = u2 * unit, u4 = u2 * u2;
    sums.area += u2 * area[0];
    sums.first += u3 * tail(area);
    sums.facing += u3 * faced[0];
    sums.place += u4 * tail(faced);
    sums.second += u4 * second.byPlace();
    for (const bool own : {true, false}) {
      const int s = own ? side : 1 - side;
      const Rows &normal = own ? normalOwn : normalOther, &push = own ? pushOwn : pushOther;
      sums.normal[s] += u2 * normal.plain();
      sums.normalBy[s] += u3 * normal.byPlace();
      if (!own && !oneSided) continue;
      SideSums& to = sums.side[s];
      to.push += u3 * push.plain();
      to.moment += u4 * crossOf(push.byPlace());
      to.wall += u3 * tail(own ? wallOwn : wallOther);
      to.size += u3 * powers[0];
      to.depth[0] += u3 * faced[0];
      to.depth[1] += u4 * powers[1];
      to.depth[2] += u4 * unit * powers[2];
    }
    sums.apart += u3 * apart.plain();
    sums.opening += u4 * apart.byPlace().trace();
    sums.width += u4 * powers[3];
    sums.middle += u4 * middle;
    sums.deepest = std::max(sums.deepest, static_cast<double>(deepest));
    sums.hits += hits;
  }
};

}  // namespace

CC_LANES void addHits(const HitColumns& hits, const float* gate, const std::uint32_t* first,
                      const std::uint32_t* last, bool oneSided, double unit, Sums& sums) {
  const HitColumns::Columns<const float> c = hits.columns();
  const Vec3 origin = sums.origin;
  const double perUnit = 1 / unit;
  while (first != last) {
    Part part;
    const Side side = hits.side(*first);
    const std::uint32_t* end = first;
    for (; end != last && hits.side(*end) == side; ++end) {
      if (oneSided)
        part.add<true>(c, *end, gate[*end], origin.data(), perUnit);
      else
        part.add<false>(c, *end, gate[*end], origin.data(), perUnit);
      if (hits.deep(*end)) sums.deep += static_cast<double>(c.area[*end]) * c.depth1[*end];
    }
    part.give(sums, static_cast<int>(end - first), oneSided, side, unit);
    first = end;
  }
}

void Sums::add(const Sums& other) {
  const Vec3 shift = other.origin - origin;
  for (int s = 0; s < 2; ++s) {
    side[s].push += other.side[s].push;
    side[s].moment += other.side[s].moment + shift.cross(other.side[s].push);
    side[s].wall += other.side[s].wall;
    side[s].size += other.side[s].size;
    for (int k = 0; k < 3; ++k) side[s].depth[k] += other.side[s].depth[k];
    normal[s] += other.normal[s];
    normalBy[s] += other.normalBy[s] + other.normal[s] * shift.transpose();
  }
  second += other.second + other.first * shift.transpose() + shift * other.first.transpose() +
            other.area * shift * shift.transpose();
  first += other.first + other.area * shift;
  area += other.area;
  width += other.width;
  facing += other.facing;
  place += other.place + other.facing * shift;
  middle += other.middle;
  apart += other.apart;
  opening += other.opening + shift.dot(other.apart);
  deep += other.deep;
  deepest = std::max(deepest, other.deepest);
  hits += other.hits;
}

}  // namespace cloudcontact
