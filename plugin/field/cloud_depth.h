// How deep each voxel's centre lies below a cloud's surface: for clouds used as solids.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact {

// One value a voxel of the cloud's grid, x fastest [m], negative outside. The method:
// cloud_depth.cpp.
std::vector<float> cloudDepth(const Cloud& cloud);

}  // namespace cloudcontact
