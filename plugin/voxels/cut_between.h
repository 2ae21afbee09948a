// Bricks of clouds, compared; and the cut that lies between two states of a body.
#pragma once

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <vector>

namespace cloudcontact {

// Coverage of a cell of a brick, as the table has it: stored, or a code.
inline std::uint8_t coverageIn(const Cloud::Voxels& voxels, std::int32_t brick, int cell) {
  if (brick < 0) return brick == kSolidBrick ? 255 : 0;
  return voxels.coverage[static_cast<std::size_t>(brick)][static_cast<std::size_t>(cell)];
}

inline bool sameGrid(const Cloud& a, const Cloud& b) {
  return a.bricks() == b.bricks() && a.voxelSize() == b.voxelSize() && a.origin() == b.origin();
}

// Whether two states of a body are equal in a brick of the grid that they share.
bool sameCoverage(const Cloud::Voxels& a, const Cloud::Voxels& b, std::size_t brick);
bool sameMaterial(const Cloud::Voxels& a, const Cloud::Voxels& b, std::size_t brick);

// The cuts that make `after` of `before`, which has the same grid. Voxels that have more matter
// after it are left out.
std::vector<VoxelCut> cutsBetween(const Cloud& before, const Cloud& after);

}  // namespace cloudcontact
