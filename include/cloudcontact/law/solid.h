// Bodies and areas given by a formula or by a cloud: how deep a point lies in them, the nearest way
// out, and their bounds. A cloud meets them in Bullet, a tool detects with them (the paper's
// collision detection area D, Fig. 6), and a voxel's window is one (the cuttable area C, Fig. 7).
// Lengths in meters, in the solid's own frame: centered on the origin, the axis along z.
#pragma once

#include <cloudcontact/law/solid_point.h>

#include <memory>
#include <utility>
#include <variant>
#include <vector>

namespace cloudcontact {

class Cloud;
class TriangleSurface;

// Material where normal.x < offset.
struct HalfSpace {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
};
// All within `radius` of the origin.
struct Sphere {
  double radius = 0;
};
// Edges along the axes.
struct Box {
  Vec3 halfExtents = Vec3::Zero();
};
// Axes along the frame's.
struct Ellipsoid {
  Vec3 semiAxes = Vec3::Zero();
};
// All within `radius` of a segment of length 2 halfHeight.
struct Capsule {
  double radius = 0, halfHeight = 0;
};
// Round about z.
struct Cylinder {
  double radius = 0, halfHeight = 0;
};
// All within `margin` of a cone with its base at -halfHeight and its tip at +halfHeight.
struct Cone {
  double radius = 0, halfHeight = 0, margin = 0;
};
// All within `margin` of a convex hull.
struct Hull {
  std::vector<HalfSpace> planes;  // outward, at least four
  std::vector<Vec3> corners;      // for bounds and edges
  double margin = 0;
  // Pairs of corners. Without them only a cloud's samples meet the hull, and they measure to its
  // nearest face, which is too shallow at corners and edges.
  std::vector<std::pair<int, int>> edges;
};
// The matter of a cloud. Made by cloudSolid() (workpiece/cloud_solid.h); copies share everything.
struct CloudSolid {
  std::shared_ptr<const Cloud> cloud;
  // Depth of each voxel's center below the cloud's surface, negative outside; x fastest [m].
  std::shared_ptr<const std::vector<float>> depth;
  Eigen::AlignedBox3d matter;  // bounds of the voxels with matter [m]
};

// The matter behind triangles, as those of a terrain (law/triangle_surface.h). Contacts take it;
// areas do not. Copies share the triangles.
struct SurfaceSolid {
  std::shared_ptr<const TriangleSurface> surface;
};

// A body or an area by its formula.
using Solid = std::variant<HalfSpace, Sphere, Box, Ellipsoid, Capsule, Cylinder, Cone, Hull,
                           CloudSolid, SurfaceSolid>;

// Depth is exact, but for an ellipsoid (first order near its surface) and a cloud (its surface is
// rounded at edges by up to a quarter of a voxel).
SolidPoint solidAt(const Solid& solid, const Vec3& local);

// Axis-aligned bounds in the solid's frame; infinite for a half-space [m].
Eigen::AlignedBox3d boundsOf(const Solid& solid);

// Whether depth changes by no more than the distance between two points: true of all but the
// ellipsoid and, behind the border of an open surface, triangles.
bool isDistance(const Solid& solid);

// A solid at a place in its owner's frame: a tool's or a voxel's area. It need not have the shape
// of a body.
struct PlacedSolid {
  Solid solid = Sphere{};
  Pose place = {};
};

// Throws std::invalid_argument, naming the length, where the solid has no volume, is a half-space,
// or is not finite.
void validate(const PlacedSolid& area);
// Of a body that touches: throws std::invalid_argument, naming the length, where one is negative or
// not finite. Half-spaces, triangles and points are bodies, too.
void validateBody(const Solid& body);

// Depth at a point of the owner's frame, as in SolidPoint.
double depthOf(const PlacedSolid& area, const Vec3& point);
// Normal there.
Vec3 normalOf(const PlacedSolid& area, const Vec3& point);
SolidPoint pointOf(const PlacedSolid& area, const Vec3& point);  // both
// Depth at start + i * step for all i < count.
void depthsAlong(const PlacedSolid& area, const Vec3& start, const Vec3& step, int count,
                 double* depth);
// Axis-aligned bounds in the owner's frame [m].
Eigen::AlignedBox3d boundsOf(const PlacedSolid& area);

// What a representative point may be matched with (paper, Fig. 8 a-c). Any other place is as good
// (d-f): it is a point, given by its coordinates. centerOfGravity(), of the area filled evenly,
// throws std::invalid_argument for a half-space, a hull and a cone with a margin.
Vec3 centerOfGravity(const PlacedSolid& area);
// The middle of boundsOf().
Vec3 centerOfBounds(const PlacedSolid& area);

}  // namespace cloudcontact
