// The prisms over a surface's faces, in which a face is surely the nearest, and the cells that tell
// which face to try: most look-ups need no search of the tree.
#include "law/triangle_surface.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr double kPrism =
    0.7;  // of a face's longest edge: room over it beyond which none is looked for
constexpr double kSure = 1e-6;  // of the height: nearer to the room is not sure
// Of the room: nearer to a side is not sure. Larger than the root of `kOnSurface`, by which corners
// may rise unseen.
constexpr double kSureAside = 1e-3;
constexpr double kLeastRoom = 0.01;  // of `kPrism`: lower prisms hold nothing
// Meshes of more faces are too fine for prisms: most would be lower than the samples are deep.
constexpr std::size_t kMostPrisms = 4000;
constexpr int kHops = 8;  // from one face to the next
// Of a length, for what is computed in single precision: 32 roundings.
constexpr double kRounding = 2e-6;
constexpr double kCellsAFace = 8;  // at most

// How steeply a triangle rises beyond a line: the greatest slope to one of its corners, which are
// `beyond` the line and `z` above the face, times `up`. Negative where one is on this side of it.
double riseBeyond(const double (&beyond)[3], const double (&z)[3], double up, double tolerance) {
  double slope = 0;
  for (int i = 0; i < 3; ++i) {
    if (beyond[i] < -tolerance) return -1;
    const double rise = up * z[i];
    if (rise > tolerance && rise > slope * beyond[i])
      slope = beyond[i] > 0 ? rise / beyond[i] : std::numeric_limits<double>::infinity();
  }
  return slope;
}

// The tangent of half the rise.
double halfRise(double slope) {
  return slope < 1e9 ? slope / (1 + std::sqrt(1 + slope * slope)) : 1;
}

}  // namespace

// What may limit the room in a face's prism is in this box.
Eigen::AlignedBox3d TriangleSurface::Triangle::around() const {
  const double reach = kPrism * longest();
  const Eigen::AlignedBox3d own = box();
  return {Vec3(own.min().array() - reach), Vec3(own.max().array() + reach)};
}

void TriangleSurface::visitAround(std::uint32_t face,
                                  const std::function<void(const Triangle&)>& visit) const {
  const Eigen::AlignedBox3d around = triangles_[place_[face]].around();
  std::uint32_t stack[kDeepest];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[stack[--depth]];
    if (!node.box.intersects(around)) continue;
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = node.first + 1;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (triangles_[i].face != face) visit(triangles_[i]);
  }
}

// What another triangle leaves of a prism. It lies in a wedge: beyond a line in the face's plane, a
// side or one through a corner across its bisector, and below a plane that rises from that line. A
// ball about a point of the prism touches the face at the point's foot; it stays out of the wedge
// where the foot is farther from the line than the height times the tangent of half the rise. A
// triangle that lies beyond no such line limits the height to half of its own, unless it is on the
// other side of the face.
struct TriangleSurface::Room {
  std::array<Vec3, 3> inward;  // unit, in the face's plane
  std::array<double, 3> from;  // inward.dot(x) on the edge
  std::array<double, 6> sum;   // lengths of the lines' ways inward, before they are unit
  std::array<std::array<double, 6>, 2> share{};
  std::array<double, 2> height;  // [m]

  explicit Room(const Triangle& own, double reach) : height{reach / 2, reach / 2} {
    const Vec3* const corner[] = {&own.a, &own.b, &own.c};
    for (std::size_t k = 0; k < 3; ++k) {
      inward[k] = own.normal.cross(*corner[(k + 1) % 3] - *corner[k]).normalized();
      from[k] = inward[k].dot(*corner[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] = 1;
      sum[3 + k] = (inward[k] + inward[(k + 2) % 3]).norm();
    }
  }

  void narrow(const Triangle& other, const Triangle& own, double tolerance) {
    double z[3], beyond[6][3];
    for (int i = 0; i < 3; ++i) {
      const Vec3& corner = i == 0 ? other.a : i == 1 ? other.b : other.c;
      z[i] = own.normal.dot(corner - own.a);
      for (std::size_t k = 0; k < 3; ++k) beyond[k][i] = from[k] - inward[k].dot(corner);
      // The sum of two sides' distances is the distance along the bisector, times `sum`.
      for (std::size_t k = 0; k < 3; ++k) beyond[3 + k][i] = beyond[k][i] + beyond[(k + 2) % 3][i];
    }
    const auto [low, high] = std::minmax({z[0], z[1], z[2]});
    for (const std::size_t under : {0u, 1u}) {
      double least = -1;
      std::size_t line = 0;
      for (std::size_t k = 0; k < 6 && least != 0; ++k) {
        const double slope = sum[k] * riseBeyond(beyond[k], z, under ? -1 : 1, tolerance);
        if (slope < 0 || (least >= 0 && slope >= least)) continue;
        least = slope;
        line = k;
      }
      const double lowest = under ? -high : low, highest = under ? -low : high;
      if (least >= 0)
        share[under][line] = std::max(share[under][line], sum[line] * halfRise(least));
      else if (highest > -tolerance)
        height[under] = std::min(height[under], std::max(lowest, 0.0) / 2);
    }
  }
};

// Prisms without any room, but with their sides, by which a place is found.
void TriangleSurface::addPrisms() {
  origin_ = bounds_.isEmpty() ? Vec3::Zero() : Vec3(bounds_.center());
  const std::size_t count = faces_.size() > kMostPrisms ? 0 : faces_.size();
  prisms_.resize(count);
  known_.assign(count, Known::Not);
  for (std::uint32_t f = 0; f < count; ++f) {
    const Triangle& t = triangles_[place_[f]];
    const Room room(t, 0);
    Prism& prism = prisms_[f];
    for (int k = 0; k < 4; ++k) {
      const Vec3& way = k < 3 ? room.inward[static_cast<std::size_t>(k)] : t.normal;
      const Vec3& on = k == 0 ? t.a : k == 1 ? t.b : t.c;
      prism.x[k] = static_cast<float>(way.x());
      prism.y[k] = static_cast<float>(way.y());
      prism.z[k] = static_cast<float>(way.z());
      prism.from[k] = static_cast<float>(way.dot(on - origin_));
    }
    for (const int under : {0, 1}) prism.side[under].setZero(), prism.corner[under].setZero();
  }
}

// Of what is computed in single precision of the face, and of places that are asked [m].
double TriangleSurface::roundingOf(const Triangle& face) const {
  const double asked = within_.diagonal().norm();
  return kRounding *
         ((face.a - origin_).norm() + face.longest() + (std::isfinite(asked) ? asked : 0));
}

// As a body moves on, the surface is built again from mostly the same triangles. A face keeps its
// measured prism where nothing around it has changed.
void TriangleSurface::keepRooms(const TriangleSurface& before) {
  if (prisms_.empty() || before.prisms_.empty() || !agreesWith(before) || !before.agreesWith(*this))
    return;
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const Triangle& own = triangles_[place_[f]];
    const Eigen::AlignedBox3d around = own.around();
    if (!within_.contains(around) || !before.within_.contains(around)) continue;
    const std::uint32_t was = before.faceLike(own);
    if (was == kNone || !before.isMeasured(was)) continue;
    const Triangle& old = before.triangles_[before.place_[was]];
    if (old.a != own.a || old.b != own.b) continue;  // its sides are in another order
    const auto more = static_cast<float>(roundingOf(own) - before.roundingOf(own));
    for (const int under : {0, 1}) {
      prisms_[f].side[under] = before.prisms_[was].side[under];
      prisms_[f].corner[under] = before.prisms_[was].corner[under];
      prisms_[f].side[under][3] += more;
      prisms_[f].corner[under][3] -= more;
    }
    known_[f] = Known::Yes;
  }
}

// Whether the other has each of these faces that lies where it was read.
bool TriangleSurface::agreesWith(const TriangleSurface& other) const {
  return std::all_of(triangles_.begin(), triangles_.end(), [&other](const Triangle& t) {
    return !other.within_.intersects(t.box()) || other.faceLike(t) != kNone;
  });
}

// Finds the room in a prism.
void TriangleSurface::measure(std::uint32_t face, Prism& prism) const {
  const Triangle& own = triangles_[place_[face]];
  const double longest = own.longest(), reach = kPrism * longest;
  Room room(own, reach);
  visitAround(face, [&](const Triangle& other) { room.narrow(other, own, kOnSurface * longest); });
  const double rounding = roundingOf(own);
  for (const std::size_t under : {0u, 1u}) {
    if (room.height[under] < kLeastRoom * reach) room.height[under] = 0;
    const auto& share = room.share[under];
    const double least = kSureAside * room.height[under] + rounding;
    const double most = room.height[under] * (1 - kSure) - rounding;
    prism.side[under] = Eigen::Array4d(share[0], share[1], share[2], least).cast<float>();
    prism.corner[under] = Eigen::Array4d(share[3], share[4], share[5], most).cast<float>();
  }
}

// Whether the place is in the prism and no other face can be nearer to it. Without branches, which
// a processor cannot predict.
inline bool TriangleSurface::Prism::holds(const Eigen::Vector3f& place) const {
  float ahead[4];
  for (int k = 0; k < 4; ++k)
    ahead[k] = x[k] * place.x() + y[k] * place.y() + z[k] * place.z() - from[k];
  const int under = ahead[3] < 0;
  const float* const sides = side[under].data();
  const float* const corners = corner[under].data();
  const float height = std::abs(ahead[3]), least = sides[3];
  bool all = height < corners[3];
  for (int k = 0; k < 3; ++k) {
    all &= ahead[k] - height * sides[k] > least;
    all &= ahead[k] + ahead[(k + 2) % 3] - height * corners[k] > least;
  }
  return all;
}

bool TriangleSurface::isMeasured(std::uint32_t face) const {
  return std::atomic_ref(known_[face]).load(std::memory_order_acquire) == Known::Yes;
}

// As Prism::holds(). Measures a prism that is not, and keeps that, unless another thread just does.
bool TriangleSurface::holdsNow(std::uint32_t face, const Eigen::Vector3f& place) const {
  if (isMeasured(face)) return prisms_[face].holds(place);
  const Prism& kept = prisms_[face];
  Prism found{kept.x, kept.y, kept.z, kept.from, {}, {}};
  measure(face, found);
  const std::atomic_ref known(known_[face]);
  Known expected = Known::Not;
  if (known.compare_exchange_strong(expected, Known::Soon, std::memory_order_relaxed)) {
    for (const int under : {0, 1}) {
      prisms_[face].side[under] = found.side[under];
      prisms_[face].corner[under] = found.corner[under];
    }
    known.store(Known::Yes, std::memory_order_release);
  }
  return found.holds(place);
}

// Whether a face near `face` is the nearest for sure. `face` becomes where the way led.
bool TriangleSurface::sureFace(const Eigen::Vector3f& place, std::uint32_t& face) const {
  if (prisms_.empty()) return false;
  for (int hop = 0; hop <= kHops; ++hop) {
    const Prism::Row ahead = prisms_[face].ahead(place);
    int nearest;
    if (ahead.head<3>().minCoeff(&nearest) > 0) return holdsNow(face, place);
    const Edge& edge = edges_[faces_[face].edge[static_cast<std::size_t>(nearest)]];
    if (!edge.joins()) return false;
    face = edge.face[edge.face[0] == face];
  }
  return false;
}

// Cells about half as wide as faces are.
void TriangleSurface::addCells() {
  double area = 0;
  for (const Triangle& t : triangles_) area += (t.b - t.a).cross(t.c - t.a).norm() / 2;
  const auto count = static_cast<double>(faces_.size());
  const Eigen::Array3d sizes = bounds_.isEmpty() ? Vec3::Zero() : Vec3(bounds_.sizes());
  double width = std::sqrt(area / std::max(count, 1.0)) / 2;
  Eigen::Array3d cells = Eigen::Array3d::Ones();
  for (; width > 0; width *= 1.25) {
    cells = (sizes / width).ceil().max(1.0);
    if (cells.prod() <= kCellsAFace * count) break;
  }
  cells_ = cells.cast<int>();
  cellsPerMeter_ = (cells / sizes.max(1e-30)).cast<float>();
  lastFrom_.assign(static_cast<std::size_t>(cells_.prod()), kNone);
  for (const Triangle& t : triangles_)
    lastFrom_[cellOf((t.middle / 3 - origin_).cast<float>())] = t.face;
  spreadCells();
}

// A cell without the middle of a face takes the face of a neighbor.
void TriangleSurface::spreadCells() {
  const auto copy = [this](std::size_t to, std::size_t from) {
    if (lastFrom_[to] == kNone) lastFrom_[to] = lastFrom_[from];
  };
  const std::size_t all = lastFrom_.size();
  std::size_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto length = static_cast<std::size_t>(cells_[axis]);
    for (std::size_t i = 0; i < all; ++i)
      if (i / stride % length > 0) copy(i, i - stride);
    for (std::size_t i = all; i-- > 0;)
      if (i / stride % length + 1 < length) copy(i, i + stride);
    stride *= length;
  }
}

std::size_t TriangleSurface::cellOf(const Eigen::Vector3f& place) const {
  const Eigen::Array3f at = place.array() * cellsPerMeter_ + cells_.cast<float>() / 2;
  const Eigen::Array3f last = (cells_ - 1).cast<float>();
  const Eigen::Array3i cell = (at > 0).select(at.min(last), 0.0f).cast<int>();  // NaN: 0
  return static_cast<std::size_t>((cell.z() * cells_.y() + cell.y()) * cells_.x() + cell.x());
}

// The face that was last found from a cell is mostly the nearest again, and its prism says so. If
// not, the search walks from face to face, and as a last resort through the tree. The result does
// not depend on where it began.
TriangleSurface::Point TriangleSurface::at(const Vec3& x) const {
  const Eigen::Vector3f place = (x - origin_).cast<float>();
  const std::atomic_ref last(lastFrom_[cellOf(place)]);
  const std::uint32_t before = last.load(std::memory_order_relaxed);
  if (!prisms_.empty() && isMeasured(before) && prisms_[before].holds(place)) {
    const Face& face = faces_[before];
    const Vec3 facing = sides_[face.sheet] * face.normal;
    return {{facing.dot(corners_[face.corner[0]] - x), facing}, false};
  }
  Nearest near;
  near.face = before;
  if (!sureFace(place, near.face)) near = nearest(x, near.face);
  if (near.face != before) last.store(near.face, std::memory_order_relaxed);
  return signedBy(near, x);
}

// If the face that was last found from there is within reach, no search is needed.
double TriangleSurface::beyond(const Vec3& x, double reach) const {
  const std::uint32_t face = std::atomic_ref(lastFrom_[cellOf((x - origin_).cast<float>())])
                                 .load(std::memory_order_relaxed);
  if (onTriangle(triangles_[place_[face]], x).square <= reach * reach) return 0;
  return std::max(0.0, -(at(x).depth + reach));
}

}  // namespace cloudcontact
