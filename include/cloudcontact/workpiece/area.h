// Areas of any shape: where a tool detects (the paper's collision detection area D, Fig. 6) and the
// window about a voxel of the workpiece in which its matter is weighed (the cuttable area C,
// Fig. 7). An area is not matter; it need not have the shape of a body.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/voxels/cloud.h>

#include <memory>
#include <variant>

namespace cloudcontact {

// Lengths in metres, in the frame of the body or voxel that the area belongs to.
struct SphereArea {
  Vec3 center = Vec3::Zero();
  double radius = 0;
};
struct BoxArea {
  Pose place;
  Vec3 halfExtents = Vec3::Zero();
};
struct EllipsoidArea {
  Pose place;
  Vec3 semiAxes = Vec3::Zero();
};
// Where a cloud has matter: the whole tool, or whatever else is known as a cloud. Made by
// cloudArea(); copies share everything.
struct CloudArea {
  std::shared_ptr<const Cloud> cloud;
  Pose place;
  // [m] depth below the cloud's surface at each voxel's centre, negative outside; x fastest.
  std::shared_ptr<const std::vector<float>> depth;
  Eigen::AlignedBox3d matter;  // bounds, in the cloud's frame [m]
};

using Area = std::variant<SphereArea, BoxArea, EllipsoidArea, CloudArea>;

// Throws std::invalid_argument where the cloud is empty.
CloudArea cloudArea(const Cloud& cloud, const Pose& place = {});

// The matter of `tool` within `thickness` [m] of its surface, and of that only what lies in
// `where`, if given: the cutting surface of a tool (Fig. 6 c). Throws std::invalid_argument where
// nothing is left or the thickness is not positive.
Cloud surfaceLayer(const Cloud& tool, double thickness, const Area* where = nullptr);

// Throws std::invalid_argument, naming the length, where an area has no volume or is not finite.
void requireArea(const Area& area);

// Signed depth of a point inside the area [m]. Exact for spheres and boxes; for ellipsoids to first
// order near the surface; for clouds to their surface as their voxels tell it, rounded at edges by
// up to a quarter of a voxel.
double areaDepth(const Area& area, const Vec3& point);

// The outward unit direction in which the depth falls fastest.
Vec3 areaNormal(const Area& area, const Vec3& point);

// Lowest and highest corner in the frame of the area's owner [m].
Eigen::AlignedBox3d areaBounds(const Area& area);

// What a representative point may be matched with (paper, Fig. 8 a-c). Any other place is as good
// (d-f): it is a point, given by its coordinates.
Vec3 centerOfGravity(const Area& area);  // of the area filled evenly
Vec3 centerOfBounds(const Area& area);   // middle of its bounds

}  // namespace cloudcontact
