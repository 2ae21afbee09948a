// One function per kind of Bullet shape.
#include "bullet/shape_conversion.h"

#include <BulletCollision/CollisionShapes/btBox2dShape.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvex2dShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include <cmath>

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

// Directions for the support points of a convex shape without vertices. A sphere's hull is then
// within 0.5 % of its radius.
constexpr int kSupportDirections = 1000;

// The frame whose z axis is the Bullet shape's axis `up`.
Pose alongAxis(int up) {
  Vec3 axis = Vec3::Zero();
  axis[up] = 1;
  return {shortestTurn(Vec3::UnitZ(), axis), Vec3::Zero()};
}

PlacedSolid fromPlane(const btStaticPlaneShape& plane) {
  const Vec3 normal = toVec3(plane.getPlaneNormal());
  return {HalfSpace{normal.normalized(), plane.getPlaneConstant() / normal.norm()}, {}};
}

PlacedSolid fromCapsule(const btCapsuleShape& capsule) {
  return {Capsule{capsule.getRadius(), capsule.getHalfHeight()}, alongAxis(capsule.getUpAxis())};
}

PlacedSolid fromCylinder(const btCylinderShape& cylinder) {
  const btVector3 half = cylinder.getHalfExtentsWithMargin();
  const int up = cylinder.getUpAxis();
  // Bullet's radius is the extent along x, or along y where x is the axis.
  return {Cylinder{half[up == 0 ? 1 : 0], half[up]}, alongAxis(up)};
}

PlacedSolid fromCone(const btConeShape& cone) {
  return {Cone{cone.getRadius(), cone.getHeight() / 2, cone.getMargin()},
          alongAxis(cone.getConeUpIndex())};
}

std::optional<PlacedSolid> fromBox2d(const btBox2dShape& box) {
  const Vec3 half = toVec3(box.getHalfExtentsWithMargin());
  if (!(half.z() > 0)) return std::nullopt;
  return PlacedSolid{Box{half}, {}};
}

// The plane of a face of a computed hull, by Newell's sum over its corners. Empty for a sliver.
std::optional<HalfSpace> planeOfFace(const btConvexHullComputer& hull, int face) {
  const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[face]];
  const Vec3 origin = toVec3(hull.vertices[first->getSourceVertex()]);
  Vec3 normal = Vec3::Zero(), mean = Vec3::Zero();
  double longest = 0;
  int corners = 0;
  const auto* edge = first;
  do {
    const Vec3 from = toVec3(hull.vertices[edge->getSourceVertex()]) - origin;
    const Vec3 to = toVec3(hull.vertices[edge->getTargetVertex()]) - origin;
    normal += from.cross(to);
    mean += from;
    longest = std::max(longest, (to - from).squaredNorm());
    ++corners;
    edge = edge->getNextEdgeOfFace();
  } while (edge != first);
  if (normal.norm() <= 1e-7 * longest) return std::nullopt;
  normal.normalize();
  return HalfSpace{normal, normal.dot(origin + mean / corners)};
}

std::optional<PlacedSolid> hullOf(const std::vector<double>& coordinates, double margin) {
  btConvexHullComputer computer;
  computer.compute(coordinates.data(), 3 * sizeof(double), static_cast<int>(coordinates.size() / 3),
                   0, 0);
  Hull hull;
  hull.margin = margin;
  for (int i = 0; i < computer.vertices.size(); ++i)
    hull.corners.push_back(toVec3(computer.vertices[i]));
  for (int face = 0; face < computer.faces.size(); ++face)
    if (const auto plane = planeOfFace(computer, face)) hull.planes.push_back(*plane);
  for (int i = 0; i < computer.edges.size(); ++i) {
    const int from = computer.edges[i].getSourceVertex(), to = computer.edges[i].getTargetVertex();
    if (from < to) hull.edges.emplace_back(from, to);
  }
  // A flat or straight body has planes that face one another across nothing.
  if (hull.planes.size() < 4) return std::nullopt;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& corner : hull.corners) middle += corner / double(hull.corners.size());
  for (const HalfSpace& plane : hull.planes)
    if (plane.offset - plane.normal.dot(middle) <= 0) return std::nullopt;
  return PlacedSolid{std::move(hull), {}};
}

int vertexCount(const btCollisionShape& shape) {
  return shape.isPolyhedral() ? static_cast<const btPolyhedralConvexShape&>(shape).getNumVertices()
                              : 0;
}

std::optional<PlacedSolid> fromVertices(const btPolyhedralConvexShape& shape) {
  std::vector<double> coordinates;
  for (int i = 0; i < shape.getNumVertices(); ++i) {
    btVector3 vertex;
    shape.getVertex(i, vertex);
    append(coordinates, vertex);
  }
  return hullOf(coordinates, shape.getMargin());
}

// Support points in directions spread evenly over the sphere (a golden spiral).
std::optional<PlacedSolid> fromSupport(const btConvexShape& shape) {
  const double turn = SIMD_PI * (3 - std::sqrt(5.0));
  std::vector<double> coordinates;
  for (int i = 0; i < kSupportDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kSupportDirections, r = std::sqrt(1 - z * z);
    const Vec3 direction(r * std::cos(turn * i), r * std::sin(turn * i), z);
    append(coordinates, shape.localGetSupportingVertex(toBullet(direction)));
  }
  std::optional<PlacedSolid> placed = hullOf(coordinates, 0);
  // Its facets are the sampling's, not the shape's.
  if (placed) std::get<Hull>(placed->solid).edges.clear();
  return placed;
}

}  // namespace

std::optional<PlacedSolid> toSolid(const btCollisionShape& shape) {
  switch (shape.getShapeType()) {
    case TRIANGLE_SHAPE_PROXYTYPE:
    case IMPLICIT_CONVEX_SHAPES_START_HERE:
      return std::nullopt;  // no volume
    case BOX_2D_SHAPE_PROXYTYPE:
      return fromBox2d(static_cast<const btBox2dShape&>(shape));
    case CONVEX_2D_SHAPE_PROXYTYPE:
      return toSolid(*static_cast<const btConvex2dShape&>(shape).getChildShape());
    case STATIC_PLANE_PROXYTYPE:
      return fromPlane(static_cast<const btStaticPlaneShape&>(shape));
    case BOX_SHAPE_PROXYTYPE:
      return PlacedSolid{
          Box{toVec3(static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin())}, {}};
    case SPHERE_SHAPE_PROXYTYPE:
      return PlacedSolid{Sphere{static_cast<const btSphereShape&>(shape).getRadius()}, {}};
    case CAPSULE_SHAPE_PROXYTYPE:
      return fromCapsule(static_cast<const btCapsuleShape&>(shape));
    case CYLINDER_SHAPE_PROXYTYPE:
      return fromCylinder(static_cast<const btCylinderShape&>(shape));
    case CONE_SHAPE_PROXYTYPE:
      return fromCone(static_cast<const btConeShape&>(shape));
    default:
      if (!shape.isConvex()) return std::nullopt;
      // btConvexTriangleMeshShape counts as polyhedral but keeps its vertices to itself.
      if (vertexCount(shape) > 0)
        return fromVertices(static_cast<const btPolyhedralConvexShape&>(shape));
      return fromSupport(static_cast<const btConvexShape&>(shape));
  }
}

const PlacedSolid* ConversionCache::of(const btCollisionShape& shape) {
  const btVector3 scaling = shape.getLocalScaling();
  const int vertices = vertexCount(shape);
  const bool same = source_ == &shape && scaling == scaling_ && shape.getMargin() == margin_ &&
                    vertices == vertices_;
  if (!same) {
    placed_ = toSolid(shape);
    source_ = &shape;
    scaling_ = scaling;
    margin_ = shape.getMargin();
    vertices_ = vertices;
    ++conversions_;
  }
  return placed_ ? &*placed_ : nullptr;
}

}  // namespace cloudcontact
