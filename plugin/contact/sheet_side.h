// On which side of a sheet the part of a cloud is that a sample belongs to.
#pragma once

#include <cloudcontact/voxels/cloud.h>

namespace cloudcontact {

// Whether a place [voxels] is in a voxel that is half full.
bool isMatter(const Cloud& cloud, const Vec3& x);

// A cloud may reach around a sheet's border, as a clamp does: then its jaws are on different sides.
// 1 if the part is in front, -1 behind, 0 if it cannot be told, by the matter on the line across
// the sheet through the place a voxel inside the sample. In the cloud's grid [voxels]: the sample's
// place and outward normal, and the sheet's direction to the front. `height`: of the sample in
// front of the sheet.
int sideOfSheet(const Cloud& cloud, const Eigen::Vector3f& sample, const Eigen::Vector3f& outward,
                const Vec3& front, double height);

}  // namespace cloudcontact
