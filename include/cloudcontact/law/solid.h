// Convex bodies known by a formula rather than by voxels: what a cloud meets when the other body
// is a plain Bullet shape. All in the body's own frame, metres, axes along z where there is one.
#pragma once

#include <cloudcontact/base/pose.h>

#include <utility>
#include <variant>
#include <vector>

namespace cloudcontact {

struct HalfSpace {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
};  // material where normal.x < offset
struct SphereShape {
  double radius = 0;
};
struct BoxShape {
  Vec3 halfExtents = Vec3::Zero();
};
struct CapsuleShape {
  double radius = 0, halfHeight = 0;
};  // segment of 2 halfHeight, without the caps
struct CylinderShape {
  double radius = 0, halfHeight = 0;
};
// Base at -halfHeight, tip at +halfHeight; the body is all within `margin` of that cone [m].
struct ConeShape {
  double radius = 0, halfHeight = 0, margin = 0;
};
// Outward planes normal.x <= offset, at least four, and the corners for bounds; the body is all
// within `margin` of that hull [m]. Edges are pairs of corners: without them the hull's corners are
// felt by a cloud's samples alone, which measure to its nearest face: too shallow.
struct HullShape {
  std::vector<HalfSpace> planes;
  std::vector<Vec3> corners;
  double margin = 0;
  std::vector<std::pair<int, int>> edges;
};

using AnalyticShape = std::variant<HalfSpace, SphereShape, BoxShape, CapsuleShape, CylinderShape,
                                   ConeShape, HullShape>;

// Signed depth (positive inside) [m] and outward unit normal of the nearest surface at a local
// point.
struct ShapePoint {
  double depth;
  Vec3 normal;
};
ShapePoint shapeAt(const AnalyticShape& shape, const Vec3& local);

// Lowest and highest corner in the body's frame; infinite for a half-space. [m]
Eigen::AlignedBox3d shapeBounds(const AnalyticShape& shape);

}  // namespace cloudcontact
