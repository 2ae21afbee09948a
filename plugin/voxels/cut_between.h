// The cut that lies between two states of a body.
#pragma once

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <vector>

namespace cloudcontact {

// The cuts that make `after` of `before`, which has the same grid. Voxels that have more matter
// after it are left out.
std::vector<VoxelCut> cutsBetween(const Cloud& before, const Cloud& after);

}  // namespace cloudcontact
