// Depth of every voxel's center below a cloud's surface, for clouds used as solids.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact {

// One value per voxel of the cloud's grid, x fastest [m], negative outside.
std::vector<float> cloudDepth(const Cloud& cloud);

}  // namespace cloudcontact
