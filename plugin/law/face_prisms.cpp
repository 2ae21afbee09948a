// The prisms over a surface's faces, in which a face is surely the nearest: most look-ups need no
// search of the tree.
#include "law/triangle_surface.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr double kPrism =
    0.5;  // of a face's longest edge: room over it beyond which none is looked for
constexpr double kSure = 1e-6;  // of the height: nearer to the room is not sure
// Of the room: nearer to a side is not sure. Larger than the root of `kOnSurface`, by which corners
// may rise unseen.
constexpr double kSureAside = 1e-3;
constexpr double kLeastRoom = 0.01;  // of `kPrism`: lower prisms hold nothing
constexpr double kNoWedge = 2;       // more than any share: not beyond this side
// Meshes of more faces are too fine for prisms: most would be lower than the samples are deep.
constexpr std::size_t kMostPrisms = 4000;
constexpr int kHops = 8;  // from one face to the next

// The share of a height (TriangleSurface::Prism) that keeps a ball out of a triangle: of its
// corners `beyond` a line, in units of 1 / `unit`, and `z` above a face, times `up`. kNoWedge where
// a corner is on this side of the line.
double riseBeyond(const double (&beyond)[3], double unit, const double (&z)[3], double up,
                  double tolerance) {
  double share = 0;
  for (int i = 0; i < 3; ++i) {
    if (beyond[i] < -tolerance) return kNoWedge;
    if (up * z[i] <= tolerance) continue;
    const double away = std::max(beyond[i], 0.0) / unit;
    share = std::max(share, up * z[i] / (away + std::sqrt(away * away + z[i] * z[i])) * unit);
  }
  return share;
}

}  // namespace

// Triangles whose boxes are within `reach` of a face.
void TriangleSurface::visitAround(std::uint32_t face, double reach,
                                  const std::function<void(const Triangle&)>& visit) const {
  const Triangle& own = triangles_[place_[face]];
  Eigen::AlignedBox3d around;
  around.extend(own.a).extend(own.b).extend(own.c);
  around = {Vec3(around.min().array() - reach), Vec3(around.max().array() + reach)};
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
void TriangleSurface::narrow(const Triangle& other, const Triangle& own, double tolerance,
                             Prism& prism) {
  double z[3], beyond[6][3];
  for (int i = 0; i < 3; ++i) {
    const Vec3& corner = i == 0 ? other.a : i == 1 ? other.b : other.c;
    z[i] = own.normal.dot(corner - own.a);
    for (std::size_t k = 0; k < 3; ++k) beyond[k][i] = prism.from[k] - prism.inward[k].dot(corner);
    // The sum of two sides' distances is the distance along the bisector, times `sum`.
    for (std::size_t k = 0; k < 3; ++k) beyond[3 + k][i] = beyond[k][i] + beyond[(k + 2) % 3][i];
  }
  double sum[6] = {1, 1, 1};
  for (std::size_t k = 0; k < 3; ++k)
    sum[3 + k] = (prism.inward[k] + prism.inward[(k + 2) % 3]).norm();
  for (const std::size_t under : {0u, 1u}) {
    double least = kNoWedge;
    std::size_t line = 0;
    for (std::size_t k = 0; k < 6; ++k)
      if (const double share = riseBeyond(beyond[k], sum[k], z, under ? -1 : 1, tolerance);
          share < least) {
        least = share;
        line = k;
      }
    const auto [low, high] = std::minmax({z[0], z[1], z[2]});
    const double lowest = under ? -high : low, highest = under ? -low : high;
    if (least < kNoWedge)
      prism.share[under][line] = std::max(prism.share[under][line], least);
    else if (highest > -tolerance)
      prism.room[under] = std::min(prism.room[under], std::max(lowest, 0.0) / 2);
  }
}

TriangleSurface::Prism TriangleSurface::measured(std::uint32_t face) const {
  const Triangle& own = triangles_[place_[face]];
  const double longest =
      std::sqrt(std::max({(own.b - own.a).squaredNorm(), (own.c - own.b).squaredNorm(),
                          (own.a - own.c).squaredNorm()}));
  const double reach = kPrism * longest;
  Prism prism{prisms_[face].inward, prisms_[face].from, {}, {reach / 2, reach / 2}, Known::Not};
  visitAround(face, reach,
              [&](const Triangle& other) { narrow(other, own, kOnSurface * longest, prism); });
  for (double& room : prism.room)
    if (room < kLeastRoom * reach) room = 0;
  return prism;
}

// Measures a prism and keeps that, unless another thread just does.
TriangleSurface::Prism TriangleSurface::measuredNow(std::uint32_t face) const {
  const Prism found = measured(face);
  Prism& kept = prisms_[face];
  const std::atomic_ref<Known> known(kept.known);
  Known expected = Known::Not;
  if (known.compare_exchange_strong(expected, Known::Soon, std::memory_order_relaxed)) {
    kept.share = found.share;
    kept.room = found.room;
    known.store(Known::Yes, std::memory_order_release);
  }
  return found;
}

void TriangleSurface::addPrisms() {
  prisms_.resize(faces_.size() > kMostPrisms ? 0 : faces_.size());
  for (std::uint32_t f = 0; f < prisms_.size(); ++f) {
    const Triangle& t = triangles_[place_[f]];
    const Vec3* const corner[] = {&t.a, &t.b, &t.c};
    Prism& prism = prisms_[f];
    for (std::size_t k = 0; k < 3; ++k) {
      prism.inward[k] = t.normal.cross(*corner[(k + 1) % 3] - *corner[k]).normalized();
      prism.from[k] = prism.inward[k].dot(*corner[k]);
    }
    prism.share = {};
    prism.known = Known::Not;
  }
}

// Whether no other face can be nearer to a point of the prism, `over` the face and `aside` of its
// sides.
bool TriangleSurface::Prism::holds(double over, const double (&aside)[3]) const {
  const std::size_t under = over < 0;
  const double height = std::abs(over), least = kSureAside * room[under];
  if (!(height * (1 + kSure) < room[under])) return false;
  bool sure = true;
  for (std::size_t k = 0; k < 3; ++k) {
    sure &= aside[k] > height * share[under][k] + least;
    sure &= aside[k] + aside[(k + 2) % 3] > height * share[under][3 + k] + least;
  }
  return sure;
}

// A face near `hint` that is the nearest for sure; else none. It saves most searches: a cloud asks
// for places that are near each other and near the surface.
std::uint32_t TriangleSurface::sureFace(const Vec3& x, std::uint32_t hint) const {
  if (prisms_.empty()) return kNone;
  std::uint32_t at = hint < faces_.size() ? hint : 0;
  for (int hop = 0; hop <= kHops; ++hop) {
    const Prism& prism = prisms_[at];
    std::size_t nearest = 0;
    double aside[3];
    for (std::size_t k = 0; k < 3; ++k) {
      aside[k] = prism.inward[k].dot(x) - prism.from[k];
      if (aside[k] < aside[nearest]) nearest = k;
    }
    if (aside[nearest] > 0) {
      const double over = faces_[at].normal.dot(x - corners_[faces_[at].corner[0]]);
      const std::atomic_ref<Known> known(prisms_[at].known);
      const bool sure = known.load(std::memory_order_acquire) == Known::Yes
                            ? prism.holds(over, aside)
                            : measuredNow(at).holds(over, aside);
      return sure ? at : kNone;
    }
    const Edge& edge = edges_[faces_[at].edge[nearest]];
    if (!edge.joins()) return kNone;
    at = edge.face[edge.face[0] == at];
  }
  return kNone;
}

}  // namespace cloudcontact
