// How deep each voxel's centre lies below a cloud's surface: for clouds used as areas.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact {

// One value a voxel of the cloud's grid, x fastest [m], negative outside. The method:
// cloud_depth.cpp.
std::vector<float> cloudDepth(const Cloud& cloud);

// Depth at a point of the cloud's frame, linear between the voxels; what lies outside the grid is
// as deep as the grid's nearest place, less the way there [m].
double depthAt(const Cloud& cloud, const std::vector<float>& depth, const Vec3& local);

}  // namespace cloudcontact
