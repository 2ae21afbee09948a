// The nearest point of the difference B - A to the origin, by a simplex of its points that moves
// toward the origin. Simplices are solved face by face (Ericson, Real-Time Collision
// Detection, 5.1).
#include "contact/core_distance.h"

#include <cmath>

namespace cloudcontact {

namespace {

constexpr double kFlat = 1e-9;
constexpr int kRounds = 40;  // of a curved pair; boxes take four to eight

struct Simplex {
  std::array<Vec3, 4> points{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int count = 0;
};

// The point of the segment nearest to the origin; keeps the corners that hold it.
Vec3 nearestOn2(Simplex& s) {
  const Vec3 a = s.points[0], b = s.points[1], ab = b - a;
  const double t = -a.dot(ab), whole = ab.squaredNorm();
  if (t <= 0 || whole <= 0) {
    s.count = 1;
    return a;
  }
  if (t >= whole) {
    s.points[0] = b;
    s.count = 1;
    return b;
  }
  return a + t / whole * ab;
}

Vec3 keep(Simplex& s, const Vec3& a, const Vec3& b, double share) {
  s.points[0] = a;
  s.points[1] = b;
  s.count = 2;
  return a + share * (b - a);
}

Vec3 keep(Simplex& s, const Vec3& a) {
  s.points[0] = a;
  s.count = 1;
  return a;
}

Vec3 nearestOn3(Simplex& s) {
  const Vec3 a = s.points[0], b = s.points[1], c = s.points[2], ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0 && d2 <= 0) return keep(s, a);
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) return keep(s, b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return keep(s, a, b, d1 / (d1 - d3));
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0 && d5 <= d6) return keep(s, c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return keep(s, a, c, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return keep(s, b, c, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double all = va + vb + vc;
  return a + vb / all * ab + vc / all * ac;
}

// False if the origin is inside.
bool nearestOn4(Simplex& s, Vec3& nearest) {
  static constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  double best = -1;
  Simplex kept;
  for (const auto& face : kFaces) {
    const Vec3 &a = s.points[face[0]], &b = s.points[face[1]], &c = s.points[face[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double inner = n.dot(s.points[face[3]] - a), outer = -n.dot(a);
    // The origin is on the inner side, unless the simplex is flat.
    if (inner * outer > 0 && std::abs(inner) > kFlat * n.norm() * (b - a).norm()) continue;
    Simplex triangle{{a, b, c, Vec3::Zero()}, 3};
    const Vec3 at = nearestOn3(triangle);
    if (best >= 0 && at.squaredNorm() >= best) continue;
    best = at.squaredNorm();
    nearest = at;
    kept = triangle;
  }
  if (best < 0) return false;
  s = kept;
  return true;
}

}  // namespace

std::optional<Vec3> wayBetween(const PlacedConvex& a, const PlacedConvex& b, double precision) {
  Vec3 nearest = b.at - a.at;
  if (nearest.squaredNorm() == 0) nearest = Vec3::UnitX();
  Simplex s;
  s.points[s.count++] = b.support(-nearest) - a.support(nearest);
  nearest = s.points[0];
  for (int round = 0; round < kRounds; ++round) {
    const double distance = nearest.norm();
    if (!(distance > 1000 * precision)) return std::nullopt;
    const Vec3 next = b.support(-nearest) - a.support(nearest);
    if (distance - next.dot(nearest) / distance <= precision) break;
    s.points[s.count++] = next;
    if (s.count == 2)
      nearest = nearestOn2(s);
    else if (s.count == 3)
      nearest = nearestOn3(s);
    else if (!nearestOn4(s, nearest))
      return std::nullopt;
    if (nearest.norm() >= distance) break;  // rounding
  }
  return nearest.normalized();
}

}  // namespace cloudcontact
