// One function per kind and question.
#include "law/convex_solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloudcontact {

namespace {

constexpr double kCore = 0.5;  // a core's share of the solid's least half-width
// Of a corner's distance to the center: it lies on a plane. Bullet computes hulls of floats, and
// may split a face in two.
constexpr double kOnPlane = 3e-6;

// The unit direction of a vector across the z axis; x where it has none.
Vec3 radial(const Vec3& v) {
  const double length = std::hypot(v.x(), v.y());
  return length > 0 ? Vec3(v.x() / length, v.y() / length, 0) : Vec3::UnitX();
}

double signOf(double x) {
  return x < 0 ? -1 : 1;
}

Vec3 support(const Sphere& ball, const Vec3& d) {
  return ball.radius * d.normalized();
}
Vec3 support(const Box& box, const Vec3& d) {
  return {signOf(d.x()) * box.halfExtents.x(), signOf(d.y()) * box.halfExtents.y(),
          signOf(d.z()) * box.halfExtents.z()};
}
Vec3 support(const Capsule& capsule, const Vec3& d) {
  Vec3 point = Vec3(0, 0, signOf(d.z()) * capsule.halfHeight);
  if (capsule.radius > 0) point += capsule.radius * d.normalized();
  return point;
}
Vec3 support(const Cylinder& cylinder, const Vec3& d) {
  Vec3 point = cylinder.radius * radial(d);
  point.z() = signOf(d.z()) * cylinder.halfHeight;
  return point;
}
Vec3 support(const Cone& cone, const Vec3& d) {
  const double rim = cone.radius * std::hypot(d.x(), d.y()) - cone.halfHeight * d.z();
  if (cone.halfHeight * d.z() >= rim) return {0, 0, cone.halfHeight};
  Vec3 point = cone.radius * radial(d);
  point.z() = -cone.halfHeight;
  return point;
}

Vec3 support(const Hull& hull, const Vec3& d) {
  const Vec3* farthest = &hull.corners.front();
  double most = farthest->dot(d);
  for (const Vec3& corner : hull.corners)
    if (const double along = corner.dot(d); along > most) {
      most = along;
      farthest = &corner;
    }
  return *farthest;
}

// How far a solid reaches along a direction (unit) from its center.
double reach(const Sphere& ball, const Vec3&) {
  return ball.radius;
}
double reach(const Box& box, const Vec3& d) {
  return d.cwiseAbs().dot(box.halfExtents);
}
double reach(const Capsule& capsule, const Vec3& d) {
  return capsule.radius + capsule.halfHeight * std::abs(d.z());
}
double reach(const Cylinder& cylinder, const Vec3& d) {
  return cylinder.radius * std::sqrt(d.x() * d.x() + d.y() * d.y()) +
         cylinder.halfHeight * std::abs(d.z());
}
double reach(const Cone& cone, const Vec3& d) {
  return std::max(cone.halfHeight * d.z(),
                  cone.radius * std::sqrt(d.x() * d.x() + d.y() * d.y()) - cone.halfHeight * d.z());
}
double reach(const Hull& hull, const Vec3& d) {
  return support(hull, d).dot(d);
}

// The corners of a disc of radius 1.
const std::array<Eigen::Vector2d, Feature::kMost>& unitDisc() {
  static const auto corners = [] {
    std::array<Eigen::Vector2d, Feature::kMost> c;
    for (int i = 0; i < Feature::kMost; ++i) {
      const double angle = 2 * std::numbers::pi * i / Feature::kMost;
      c[static_cast<std::size_t>(i)] = {std::cos(angle), std::sin(angle)};
    }
    return c;
  }();
  return corners;
}

Feature pointFeature(const Vec3& at) {
  Feature f;
  f.count = 1;
  f.corners[0] = at;
  return f;
}

Feature lineFeature(const Vec3& from, const Vec3& to, double radius) {
  Feature f;
  f.kind = Feature::Kind::Line;
  f.count = 2;
  f.corners[0] = from;
  f.corners[1] = to;
  f.radius = radius;
  return f;
}

// A corner of the polygon is where the direction leans to, since a tilted disc touches there.
Feature discFeature(double radius, double z, const Vec3& direction) {
  Feature f;
  f.kind = Feature::Kind::Face;
  f.count = Feature::kMost;
  f.radius = radius;
  const Vec3 u = radial(direction), v(-u.y(), u.x(), 0);
  const Vec3 out = radius * u, aside = signOf(z) * radius * v, middle = z * Vec3::UnitZ();
  const auto& unit = unitDisc();
  for (std::size_t i = 0; i < unit.size(); ++i)
    f.corners[i] = unit[i].x() * out + unit[i].y() * aside + middle;
  return f;
}

Feature feature(const Box& box, const Vec3& d) {
  Feature f;
  f.kind = Feature::Kind::Face;
  f.count = 4;
  int axis;
  d.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const double side = signOf(d[axis]);
  for (int i = 0; i < 4; ++i) {
    Vec3& corner = f.corners[static_cast<std::size_t>(i)];
    corner[axis] = side * box.halfExtents[axis];
    corner[u] = side * (i == 0 || i == 3 ? 1 : -1) * box.halfExtents[u];
    corner[v] = (i < 2 ? 1 : -1) * box.halfExtents[v];
  }
  return f;
}

Feature feature(const Capsule& capsule, const Vec3& d) {
  const Vec3 out = capsule.radius * d, half(0, 0, capsule.halfHeight);
  return lineFeature(out - half, out + half, capsule.radius);
}

Feature feature(const Cylinder& cylinder, const Vec3& d) {
  if (2 * d.z() * d.z() > 1)
    return discFeature(cylinder.radius, signOf(d.z()) * cylinder.halfHeight, d);
  const Vec3 out = cylinder.radius * radial(d), half(0, 0, cylinder.halfHeight);
  return lineFeature(out - half, out + half, cylinder.radius);
}

Feature feature(const Cone& cone, const Vec3& d) {
  const double slope = std::hypot(2 * cone.halfHeight, cone.radius);
  const double sideways =
      (2 * cone.halfHeight * std::hypot(d.x(), d.y()) + cone.radius * d.z()) / slope;
  if (-d.z() > sideways) return discFeature(cone.radius, -cone.halfHeight, d);
  const Vec3 rim = cone.radius * radial(d) - cone.halfHeight * Vec3::UnitZ();
  // The middle of the line curves as the cone does there.
  return lineFeature(rim, {0, 0, cone.halfHeight}, cone.radius / 2 * slope / (2 * cone.halfHeight));
}

// A hull's face, seen along its normal: u and v are across it.
struct HullFace {
  const Hull& hull;
  const HalfSpace& plane;
  Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  bool has(const Vec3& corner) const {
    return plane.offset - plane.normal.dot(corner) <= kOnPlane * corner.norm();
  }
};

// The corners of a face in the order of their angles about their middle; false if there are too
// many.
bool allCorners(const HullFace& face, Feature& f) {
  Vec3 middle = Vec3::Zero();
  int all = 0;
  for (const Vec3& corner : face.hull.corners)
    if (face.has(corner)) middle += corner, ++all;
  if (all > Feature::kMost) return false;
  middle /= all;
  std::array<double, Feature::kMost> angles;
  for (const Vec3& corner : face.hull.corners) {
    if (!face.has(corner)) continue;
    const Vec3 out = corner - middle;
    const double angle = std::atan2(out.dot(face.v), out.dot(face.u));
    std::size_t at = static_cast<std::size_t>(f.count++);
    for (; at > 0 && angles[at - 1] > angle; --at) {
      angles[at] = angles[at - 1];
      f.corners[at] = f.corners[at - 1];
    }
    angles[at] = angle;
    f.corners[at] = corner;
  }
  return true;
}

// Of a face with more corners than a feature has: the farthest ones in as many directions.
void farCorners(const HullFace& face, Feature& f) {
  const Vec3* last = nullptr;
  for (const Eigen::Vector2d& way : unitDisc()) {
    const Vec3 along = way.x() * face.u + way.y() * face.v;
    const Vec3* best = nullptr;
    for (const Vec3& corner : face.hull.corners)
      if (face.has(corner) && (!best || corner.dot(along) > best->dot(along))) best = &corner;
    if (best == last) continue;
    f.corners[static_cast<std::size_t>(f.count++)] = *best;
    last = best;
  }
}

Feature feature(const Hull& hull, const Vec3& d) {
  const HalfSpace& plane = *std::max_element(hull.planes.begin(), hull.planes.end(),
                                             [&d](const HalfSpace& one, const HalfSpace& other) {
                                               return one.normal.dot(d) < other.normal.dot(d);
                                             });
  const HullFace face{hull, plane};
  Feature f;
  f.kind = Feature::Kind::Face;
  if (!allCorners(face, f)) farCorners(face, f);
  return f.count > 0 ? f : pointFeature(support(hull, d));
}

// Of the nearest plane.
double innerRadius(const Hull& hull) {
  double least = hull.planes.front().offset;
  for (const HalfSpace& plane : hull.planes) least = std::min(least, plane.offset);
  return least;
}

Box core(const Box& box, double skin) {
  const double off = std::min(skin, kCore * box.halfExtents.minCoeff());
  return Box{(box.halfExtents.array() - off).matrix()};
}
Cylinder core(const Cylinder& cylinder, double skin) {
  const double off = std::min(skin, kCore * std::min(cylinder.radius, cylinder.halfHeight));
  return {cylinder.radius - off, cylinder.halfHeight - off};
}
// Similar about the center of the ball inside that touches base and sides, so it sinks. `radius` of
// that ball.
Cone core(const Cone& cone, double skin, double& sinks) {
  const double height = 2 * cone.halfHeight;
  const double radius = height / (1 + std::hypot(height, cone.radius) / cone.radius);
  const double share = std::min(skin / radius, kCore);
  sinks = share * (cone.halfHeight - radius);
  return {(1 - share) * cone.radius, (1 - share) * cone.halfHeight, 0};
}

// Calls `use` with what the solid is.
template <typename Use>
auto withConvex(const Solid& solid, Use&& use) {
  if (const auto* box = std::get_if<Box>(&solid)) return use(*box);
  if (const auto* cylinder = std::get_if<Cylinder>(&solid)) return use(*cylinder);
  if (const auto* capsule = std::get_if<Capsule>(&solid)) return use(*capsule);
  if (const auto* ball = std::get_if<Sphere>(&solid)) return use(*ball);
  if (const auto* hull = std::get_if<Hull>(&solid)) return use(*hull);
  return use(std::get<Cone>(solid));
}

}  // namespace

bool isSimple(const Solid& solid) {
  if (const auto* cone = std::get_if<Cone>(&solid)) return cone->margin == 0;
  if (const auto* hull = std::get_if<Hull>(&solid))
    return hull->margin == 0 && !hull->edges.empty() && hull->planes.size() <= kMostFaces &&
           innerRadius(*hull) > 0;
  return std::holds_alternative<HalfSpace>(solid) || std::holds_alternative<Sphere>(solid) ||
         std::holds_alternative<Box>(solid) || std::holds_alternative<Capsule>(solid) ||
         std::holds_alternative<Cylinder>(solid);
}

Vec3 supportOf(const Solid& solid, const Vec3& direction) {
  return withConvex(solid, [&](const auto& convex) -> Vec3 { return support(convex, direction); });
}

double reachOf(const Solid& solid, const Vec3& direction) {
  return withConvex(solid, [&](const auto& convex) { return reach(convex, direction); });
}

PlacedCore coreOf(const Solid& solid, double skin) {
  if (const auto* box = std::get_if<Box>(&solid)) return {core(*box, skin)};
  if (const auto* cylinder = std::get_if<Cylinder>(&solid)) return {core(*cylinder, skin)};
  if (const auto* capsule = std::get_if<Capsule>(&solid)) return {Capsule{0, capsule->halfHeight}};
  if (std::holds_alternative<Sphere>(solid)) return {Capsule{0, 0}};
  if (const auto* hull = std::get_if<Hull>(&solid))
    return {std::nullopt, 1 - std::min(skin / innerRadius(*hull), kCore)};
  PlacedCore placed;
  placed.solid = core(std::get<Cone>(solid), skin, placed.sinks);
  return placed;
}

Feature featureOf(const Solid& solid, const Vec3& direction) {
  if (const auto* box = std::get_if<Box>(&solid)) return feature(*box, direction);
  if (const auto* cylinder = std::get_if<Cylinder>(&solid)) return feature(*cylinder, direction);
  if (const auto* capsule = std::get_if<Capsule>(&solid)) return feature(*capsule, direction);
  if (const auto* ball = std::get_if<Sphere>(&solid)) return pointFeature(ball->radius * direction);
  if (const auto* hull = std::get_if<Hull>(&solid)) return feature(*hull, direction);
  return feature(std::get<Cone>(solid), direction);
}

}  // namespace cloudcontact
