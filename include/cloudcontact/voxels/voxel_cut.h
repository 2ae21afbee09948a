// What a cut does to one voxel of a grid. Cuts apply to a Cloud (pieces.h), to a BaseVectorField
// and to their copies on a device.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cloudcontact {

// A voxel by its indices in a grid.
using VoxelIndex = Eigen::Vector3i;

// Coverage that a cut leaves of a voxel [1/255]. Cuts never add material: the smaller of this and
// the voxel's own coverage remains.
struct VoxelCut {
  VoxelIndex voxel;
  std::uint8_t coverage = 0;
};

}  // namespace cloudcontact
