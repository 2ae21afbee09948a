// The plain solids' text is kernels/base/plain_solid.h. Outside a hull, the nearest point is found
// by the planes that it lies on.
//
// A sphere that is an area has a formula of its own, without its orientation, which costs time.
#include <cloudcontact/law/solid.h>
#include <cloudcontact/voxels/cloud.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/grid_index.h"
#include "kernels/base/plain_solid.h"
#include "law/triangle_surface.h"

namespace cloudcontact {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The unit vector along `v`, or `fallback` where v is zero: any direction is right there.
Vec3 direction(const Vec3& v, const Vec3& fallback) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : fallback;
}

CcVec vecOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
SolidPoint pointOf(const CcSolidPoint& p) {
  return {p.depth, Vec3(p.normal.x, p.normal.y, p.normal.z)};
}
SolidPoint pointOf(const HalfSpace& plane, const Vec3& x) {
  return pointOf(ccInHalfSpace(vecOf(plane.normal), plane.offset, vecOf(x)));
}
SolidPoint pointOf(const Sphere& sphere, const Vec3& x) {
  return pointOf(ccInSphere(sphere.radius, vecOf(x)));
}
SolidPoint pointOf(const Box& box, const Vec3& x) {
  return pointOf(ccInBox(vecOf(box.halfExtents), vecOf(x)));
}
SolidPoint pointOf(const Ellipsoid& ellipsoid, const Vec3& x) {
  return pointOf(ccInEllipsoid(vecOf(ellipsoid.semiAxes), vecOf(x)));
}
SolidPoint pointOf(const Capsule& capsule, const Vec3& x) {
  return pointOf(ccInCapsule(capsule.radius, capsule.halfHeight, vecOf(x)));
}
SolidPoint pointOf(const Cylinder& cylinder, const Vec3& x) {
  return pointOf(ccInCylinder(cylinder.radius, cylinder.halfHeight, vecOf(x)));
}
SolidPoint pointOf(const Cone& cone, const Vec3& x) {
  return pointOf(ccInCone(cone.radius, cone.halfHeight, cone.margin, vecOf(x)));
}

// Planes that hold the nearest point of a hull: at most three, in three dimensions.
struct Basis {
  std::array<const HalfSpace*, 3> planes{};
  int size = 0;
};

// The point nearest to x on all planes of the basis at once. False where the planes are parallel or
// one of them would have to pull: then fewer planes hold the nearest point.
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

const HalfSpace& mostViolated(const Hull& hull, const Vec3& x) {
  return *std::max_element(hull.planes.begin(), hull.planes.end(),
                           [&x](const HalfSpace& a, const HalfSpace& b) {
                             return a.normal.dot(x) - a.offset < b.normal.dot(x) - b.offset;
                           });
}

SolidPoint sharpPoint(const Hull& hull, const Vec3& x) {
  const HalfSpace* worst = &mostViolated(hull, x);
  const double excess = worst->normal.dot(x) - worst->offset;
  if (excess <= 0) return {-excess, worst->normal};
  // Outside: an LP-type search. Each round adds the plane that the foot violates most to the basis.
  // The distance grows each time, so no basis repeats and the last foot is the nearest point.
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
  return distance > 0 ? SolidPoint{-distance, out / distance} : SolidPoint{-excess, worst->normal};
}

SolidPoint pointOf(const Hull& hull, const Vec3& x) {
  SolidPoint point = sharpPoint(hull, x);
  point.depth += hull.margin;
  return point;
}

Eigen::AlignedBox3d symmetric(double x, double y, double z) {
  return {Vec3(-x, -y, -z), Vec3(x, y, z)};
}

Eigen::AlignedBox3d localBounds(const HalfSpace&) {
  return symmetric(kInfinity, kInfinity, kInfinity);
}
Eigen::AlignedBox3d localBounds(const Sphere& s) {
  return symmetric(s.radius, s.radius, s.radius);
}
Eigen::AlignedBox3d localBounds(const Box& b) {
  return {Vec3(-b.halfExtents), b.halfExtents};
}
Eigen::AlignedBox3d localBounds(const Ellipsoid& e) {
  return {Vec3(-e.semiAxes), e.semiAxes};
}
Eigen::AlignedBox3d localBounds(const Capsule& c) {
  return symmetric(c.radius, c.radius, c.halfHeight + c.radius);
}
Eigen::AlignedBox3d localBounds(const Cylinder& c) {
  return symmetric(c.radius, c.radius, c.halfHeight);
}
Eigen::AlignedBox3d localBounds(const Cone& c) {
  return symmetric(c.radius + c.margin, c.radius + c.margin, c.halfHeight + c.margin);
}
Eigen::AlignedBox3d localBounds(const Hull& hull) {
  Eigen::AlignedBox3d box;
  for (const Vec3& corner : hull.corners) box.extend(corner);
  return {Vec3(box.min().array() - hull.margin), Vec3(box.max().array() + hull.margin)};
}
Eigen::AlignedBox3d localBounds(const CloudSolid& cloud) {
  return cloud.matter;
}
Eigen::AlignedBox3d localBounds(const SurfaceSolid& solid) {
  return solid.surface->bounds();
}

// Linear between the voxels' centers; outside the grid, the depth of the grid's nearest place less
// the way there.
double depthIn(const CloudSolid& solid, const Vec3& p) {
  const Cloud& cloud = *solid.cloud;
  const std::vector<float>& depth = *solid.depth;
  const Eigen::Vector3i n = cloud.size();
  const Vec3 g = (p - cloud.origin()) / cloud.voxelSize() - Vec3::Constant(0.5);
  const Vec3 top = n.cast<double>() - Vec3::Ones();
  const Vec3 in = g.cwiseMax(0.0).cwiseMin(top);
  const Eigen::Vector3i low = in.cast<int>().cwiseMin(n - Eigen::Vector3i::Constant(2));
  const Vec3 f = in - low.cast<double>();
  const std::size_t nx = gridIndex(0, 1, 0, n), nxy = gridIndex(0, 0, 1, n);
  const std::size_t at = gridIndex(low, n);
  const auto row = [&](std::size_t k) {
    return (1 - f.x()) * static_cast<double>(depth[k]) + f.x() * static_cast<double>(depth[k + 1]);
  };
  const double bottom = (1 - f.y()) * row(at) + f.y() * row(at + nx);
  const double upper = (1 - f.y()) * row(at + nxy) + f.y() * row(at + nxy + nx);
  return (1 - f.z()) * bottom + f.z() * upper - cloud.voxelSize() * (g - in).norm();
}
Vec3 normalIn(const CloudSolid& solid, const Vec3& p) {
  const double half = 0.5 * solid.cloud->voxelSize();
  Vec3 n;
  for (int i = 0; i < 3; ++i)
    n[i] = depthIn(solid, p - half * Vec3::Unit(i)) - depthIn(solid, p + half * Vec3::Unit(i));
  return direction(n, Vec3::UnitZ());
}

SolidPoint pointOf(const CloudSolid& cloud, const Vec3& x) {
  return {depthIn(cloud, x), normalIn(cloud, x)};
}
SolidPoint pointOf(const SurfaceSolid& solid, const Vec3& x) {
  return solid.surface->at(x);
}

template <typename Kind>
double depthIn(const Kind& kind, const Vec3& p) {
  return pointOf(kind, p).depth;
}
template <typename Kind>
Vec3 normalIn(const Kind& kind, const Vec3& p) {
  return pointOf(kind, p).normal;
}

template <typename Kind>
double depthAt(const Kind& kind, const Pose& place, const Vec3& point) {
  return depthIn(kind, place.toLocal(point));
}
template <typename Kind>
Vec3 normalAt(const Kind& kind, const Pose& place, const Vec3& point) {
  return place.orientation * normalIn(kind, place.toLocal(point));
}
// A sphere looks the same from all sides: its orientation costs nothing.
double depthAt(const Sphere& sphere, const Pose& place, const Vec3& point) {
  return sphere.radius - (point - place.position).norm();
}
Vec3 normalAt(const Sphere&, const Pose& place, const Vec3& point) {
  const Vec3 from = point - place.position;
  const double length = from.norm();
  return length > 0 ? Vec3(from * (1 / length)) : Vec3::UnitZ();
}

template <typename Kind>
SolidPoint placedPoint(const Kind& kind, const Pose& place, const Vec3& point) {
  return {depthAt(kind, place, point), normalAt(kind, place, point)};
}
SolidPoint placedPoint(const Sphere& sphere, const Pose& place, const Vec3& point) {
  const Vec3 from = point - place.position;
  const double length = from.norm();
  return {sphere.radius - length, length > 0 ? Vec3(from * (1 / length)) : Vec3::UnitZ()};
}

template <typename Kind>
void depthsOfRow(const Kind& kind, const Pose& place, const Vec3& start, const Vec3& step,
                 int count, double* depth) {
  for (int i = 0; i < count; ++i) depth[i] = depthAt(kind, place, start + i * step);
}
// Plain numbers, so that the loop vectorizes.
void depthsOfRow(const Sphere& sphere, const Pose& place, const Vec3& start, const Vec3& step,
                 int count, double* depth) {
  const Vec3 from = start - place.position;
  const double x = from.x(), y = from.y(), z = from.z(), radius = sphere.radius;
  const double dx = step.x(), dy = step.y(), dz = step.z();
  for (int i = 0; i < count; ++i) {
    const double a = x + i * dx, b = y + i * dy, c = z + i * dz;
    depth[i] = a * a + b * b + c * c;
  }
  for (int i = 0; i < count; ++i) depth[i] = radius - std::sqrt(depth[i]);
}

// The axis-aligned box around a turned one.
Eigen::AlignedBox3d turned(const Pose& place, const Eigen::AlignedBox3d& box) {
  Eigen::AlignedBox3d bounds;
  for (int corner = 0; corner < 8; ++corner)
    bounds.extend(place.toWorld(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  return bounds;
}

struct PlacedBounds {
  const Pose& place;

  Eigen::AlignedBox3d operator()(const Sphere& s) const {
    return {place.position - Vec3::Constant(s.radius), place.position + Vec3::Constant(s.radius)};
  }
  Eigen::AlignedBox3d operator()(const Ellipsoid& e) const {
    const Eigen::Matrix3d axes = place.orientation.toRotationMatrix() * e.semiAxes.asDiagonal();
    const Vec3 reach = axes.rowwise().norm();
    return {place.position - reach, place.position + reach};
  }
  template <typename Kind>
  Eigen::AlignedBox3d operator()(const Kind& kind) const {
    return turned(place, localBounds(kind));
  }
};

}  // namespace

SolidPoint solidAt(const Solid& solid, const Vec3& local) {
  return std::visit([&local](const auto& kind) { return pointOf(kind, local); }, solid);
}

Eigen::AlignedBox3d boundsOf(const Solid& solid) {
  return std::visit([](const auto& kind) { return localBounds(kind); }, solid);
}

bool isDistance(const Solid& solid) {
  return !std::holds_alternative<Ellipsoid>(solid) && !std::holds_alternative<SurfaceSolid>(solid);
}

double depthOf(const PlacedSolid& area, const Vec3& point) {
  return std::visit([&](const auto& kind) { return depthAt(kind, area.place, point); }, area.solid);
}

Vec3 normalOf(const PlacedSolid& area, const Vec3& point) {
  return std::visit([&](const auto& kind) { return normalAt(kind, area.place, point); },
                    area.solid);
}

SolidPoint pointOf(const PlacedSolid& area, const Vec3& point) {
  return std::visit([&](const auto& kind) { return placedPoint(kind, area.place, point); },
                    area.solid);
}

void depthsAlong(const PlacedSolid& area, const Vec3& start, const Vec3& step, int count,
                 double* depth) {
  std::visit([&](const auto& kind) { depthsOfRow(kind, area.place, start, step, count, depth); },
             area.solid);
}

Eigen::AlignedBox3d boundsOf(const PlacedSolid& area) {
  return std::visit(PlacedBounds{area.place}, area.solid);
}

Vec3 centerOfGravity(const PlacedSolid& area) {
  const Pose& place = area.place;
  if (const auto* cloud = std::get_if<CloudSolid>(&area.solid))
    return place.toWorld(cloud->cloud->massProperties().centerOfMass);
  if (const auto* cone = std::get_if<Cone>(&area.solid); cone && cone->margin == 0)
    return place.toWorld({0, 0, -cone->halfHeight / 2});
  if (std::holds_alternative<HalfSpace>(area.solid) || std::holds_alternative<Hull>(area.solid) ||
      std::holds_alternative<Cone>(area.solid))
    throw std::invalid_argument(
        "centerOfGravity: not known of half-spaces, hulls and cones with a margin");
  return place.position;
}

Vec3 centerOfBounds(const PlacedSolid& area) {
  return boundsOf(area).center();
}

}  // namespace cloudcontact
