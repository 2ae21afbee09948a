// Signed depth and normal of the convex bodies that are known by a formula, exact inside and out.
// Bodies of revolution are solved in the half-plane (r, z) through their axis; a hull outside by
// the plane triples that its nearest point lies on.
#include <cloudcontact/law/solid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The unit vector along `v`, or `fallback` where v has no direction: a point on an axis or a
// centre is equally near to many surface points, and any of them is a true answer.
Vec3 direction(const Vec3& v, const Vec3& fallback) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : fallback;
}

ShapePoint pointOf(const HalfSpace& plane, const Vec3& x) {
  return {plane.offset - plane.normal.dot(x), plane.normal};
}

ShapePoint pointOf(const SphereShape& sphere, const Vec3& x) {
  return {sphere.radius - x.norm(), direction(x, Vec3::UnitZ())};
}

ShapePoint pointOf(const CapsuleShape& capsule, const Vec3& x) {
  const Vec3 foot(0, 0, std::clamp(x.z(), -capsule.halfHeight, capsule.halfHeight));
  const Vec3 out = x - foot;
  return {capsule.radius - out.norm(), direction(out, Vec3::UnitX())};
}

ShapePoint pointOf(const BoxShape& box, const Vec3& x) {
  const Vec3 beyond = x.cwiseAbs() - box.halfExtents;
  const auto side = [&x](int axis) { return x[axis] < 0 ? -1.0 : 1.0; };
  Vec3 normal = Vec3::Zero();
  if (beyond.maxCoeff() <= 0) {
    int axis;
    const double depth = -beyond.maxCoeff(&axis);
    normal[axis] = side(axis);
    return {depth, normal};
  }
  for (int axis = 0; axis < 3; ++axis) normal[axis] = side(axis) * std::max(beyond[axis], 0.0);
  const double distance = normal.norm();
  return {-distance, normal / distance};
}

// A body of revolution seen in the half-plane through its axis.
struct Profile {
  Eigen::Vector2d point;  // (r, z)
  Vec3 radial;            // unit, across the axis

  explicit Profile(const Vec3& x)
      : point(std::hypot(x.x(), x.y()), x.z()),
        radial(direction(Vec3(x.x(), x.y(), 0), Vec3::UnitX())) {}
  Vec3 lift(const Eigen::Vector2d& v) const { return v.x() * radial + v.y() * Vec3::UnitZ(); }
};

ShapePoint pointOf(const CylinderShape& cylinder, const Vec3& x) {
  const Profile profile(x);
  const double side = profile.point.y() < 0 ? -1 : 1;
  const Eigen::Vector2d beyond(profile.point.x() - cylinder.radius,
                               std::abs(profile.point.y()) - cylinder.halfHeight);
  if (beyond.maxCoeff() <= 0) {
    if (beyond.x() >= beyond.y()) return {-beyond.x(), profile.radial};
    return {-beyond.y(), side * Vec3::UnitZ()};
  }
  const Eigen::Vector2d out = beyond.cwiseMax(0.0);
  const double distance = out.norm();
  return {-distance, profile.lift({out.x() / distance, side * out.y() / distance})};
}

// Nearest point of a segment in the plane.
Eigen::Vector2d onSegment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                          const Eigen::Vector2d& x) {
  const Eigen::Vector2d along = b - a;
  const double t = (x - a).dot(along) / along.squaredNorm();
  return a + std::clamp(t, 0.0, 1.0) * along;
}

ShapePoint sharpPoint(const ConeShape& cone, const Vec3& x) {
  const Profile profile(x);
  const Eigen::Vector2d rim(cone.radius, -cone.halfHeight), tip(0, cone.halfHeight);
  const Eigen::Vector2d slope = Eigen::Vector2d(2 * cone.halfHeight, cone.radius).normalized();
  const double aboveSlope = slope.dot(profile.point - tip);
  const double belowBase = -cone.halfHeight - profile.point.y();
  if (aboveSlope <= 0 && belowBase <= 0) {
    if (aboveSlope >= belowBase) return {-aboveSlope, profile.lift(slope)};
    return {-belowBase, -Vec3::UnitZ()};
  }
  const Eigen::Vector2d onSlope = onSegment(tip, rim, profile.point);
  const Eigen::Vector2d onBase = onSegment({0, -cone.halfHeight}, rim, profile.point);
  const Eigen::Vector2d fromSlope = profile.point - onSlope, fromBase = profile.point - onBase;
  const Eigen::Vector2d out =
      fromSlope.squaredNorm() < fromBase.squaredNorm() ? fromSlope : fromBase;
  const double distance = out.norm();
  return {-distance, profile.lift(out / distance)};
}

// Planes that hold the nearest point of a hull: at most three, in three dimensions.
struct Basis {
  std::array<const HalfSpace*, 3> planes{};
  int size = 0;
};

// The point nearest to x on all planes of the basis at once. Nothing where the planes are parallel
// or one of them would have to pull: then fewer planes hold the nearest point.
bool project(const Basis& basis, const Vec3& x, Vec3& foot) {
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> normals(basis.size, 3);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> excess(basis.size);
  for (int i = 0; i < basis.size; ++i) {
    normals.row(i) = basis.planes[i]->normal;
    excess[i] = basis.planes[i]->normal.dot(x) - basis.planes[i]->offset;
  }
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> gram =
      normals * normals.transpose();
  if (std::abs(gram.determinant()) < 1e-12) return false;
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> push = gram.inverse() * excess;
  if (push.minCoeff() < 0) return false;
  foot = x - normals.transpose() * push;
  return true;
}

// The basis of `old` and `added`: of the subsets that hold `added`, the one whose nearest point
// violates none of the others.
bool enlarge(Basis& basis, const HalfSpace& added, const Vec3& x, double tolerance, Vec3& foot) {
  const Basis old = basis;
  for (int mask = 0; mask < (1 << old.size); ++mask) {
    if (mask == 7) continue;  // four planes at once
    Basis trial;
    trial.planes[trial.size++] = &added;
    for (int i = 0; i < old.size; ++i)
      if (mask >> i & 1) trial.planes[trial.size++] = old.planes[i];
    Vec3 candidate;
    if (!project(trial, x, candidate)) continue;
    bool holds = true;
    for (int i = 0; i < old.size; ++i)
      holds &= old.planes[i]->normal.dot(candidate) - old.planes[i]->offset <= tolerance;
    if (!holds) continue;
    basis = trial;
    foot = candidate;
    return true;
  }
  return false;
}

const HalfSpace& mostViolated(const HullShape& hull, const Vec3& x) {
  return *std::max_element(hull.planes.begin(), hull.planes.end(),
                           [&x](const HalfSpace& a, const HalfSpace& b) {
                             return a.normal.dot(x) - a.offset < b.normal.dot(x) - b.offset;
                           });
}

ShapePoint sharpPoint(const HullShape& hull, const Vec3& x) {
  const HalfSpace* worst = &mostViolated(hull, x);
  const double excess = worst->normal.dot(x) - worst->offset;
  if (excess <= 0) return {-excess, worst->normal};
  // Outside: an LP-type search. Each round takes the plane that the foot violates most into the
  // basis; the distance grows every time, so no basis comes back and the end is the nearest point.
  const double tolerance = 1e-12 * (x.norm() + std::abs(worst->offset));
  Basis basis;
  Vec3 foot = x;
  // The count only guards against rounding: real hulls take two to five rounds.
  for (std::size_t round = 0; round < 4 * hull.planes.size(); ++round) {
    if (worst->normal.dot(foot) - worst->offset <= tolerance) break;
    if (!enlarge(basis, *worst, x, tolerance, foot)) break;  // planes parallel to rounding
    worst = &mostViolated(hull, foot);
  }
  const Vec3 out = x - foot;
  const double distance = out.norm();
  return distance > 0 ? ShapePoint{-distance, out / distance} : ShapePoint{-excess, worst->normal};
}

// A margin moves every surface point out along its normal: it adds to the depth and turns nothing.
template <typename Sharp>
ShapePoint withMargin(const Sharp& shape, const Vec3& x) {
  ShapePoint point = sharpPoint(shape, x);
  point.depth += shape.margin;
  return point;
}
ShapePoint pointOf(const ConeShape& cone, const Vec3& x) {
  return withMargin(cone, x);
}
ShapePoint pointOf(const HullShape& hull, const Vec3& x) {
  return withMargin(hull, x);
}

Eigen::AlignedBox3d symmetric(double x, double y, double z) {
  return {Vec3(-x, -y, -z), Vec3(x, y, z)};
}

Eigen::AlignedBox3d boundsOf(const HalfSpace&) {
  return symmetric(kInfinity, kInfinity, kInfinity);
}
Eigen::AlignedBox3d boundsOf(const SphereShape& s) {
  return symmetric(s.radius, s.radius, s.radius);
}
Eigen::AlignedBox3d boundsOf(const BoxShape& b) {
  return {Vec3(-b.halfExtents), b.halfExtents};
}
Eigen::AlignedBox3d boundsOf(const CapsuleShape& c) {
  return symmetric(c.radius, c.radius, c.halfHeight + c.radius);
}
Eigen::AlignedBox3d boundsOf(const CylinderShape& c) {
  return symmetric(c.radius, c.radius, c.halfHeight);
}
Eigen::AlignedBox3d boundsOf(const ConeShape& c) {
  return symmetric(c.radius + c.margin, c.radius + c.margin, c.halfHeight + c.margin);
}
Eigen::AlignedBox3d boundsOf(const HullShape& hull) {
  Eigen::AlignedBox3d box;
  for (const Vec3& corner : hull.corners) box.extend(corner);
  return {Vec3(box.min().array() - hull.margin), Vec3(box.max().array() + hull.margin)};
}

}  // namespace

ShapePoint shapeAt(const AnalyticShape& shape, const Vec3& local) {
  return std::visit([&local](const auto& kind) { return pointOf(kind, local); }, shape);
}

Eigen::AlignedBox3d shapeBounds(const AnalyticShape& shape) {
  return std::visit([](const auto& kind) { return boundsOf(kind); }, shape);
}

}  // namespace cloudcontact
