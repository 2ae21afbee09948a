// An area as a workpiece's grid sees it, and what it leaves of the voxels.
#pragma once

#include <cloudcontact/workpiece/base_vector_field.h>

#include "kernels/cut/area_left.h"

namespace cloudcontact {

// A grid of voxels in the body's frame.
struct VoxelGrid {
  double voxelSize;
  Vec3 origin;
  Eigen::Vector3i size;
};

// The area in the grid; `place`: of the frame that the area is given in. Throws
// std::invalid_argument where the area has no volume or the place is not finite. Of a cloud's area
// the voxels that it may meet alone.
CcArea areaInGrid(const VoxelGrid& grid, const Area& area, const Pose& place);

// What the area leaves of every voxel that it may meet, added to `cuts`.
void listCuts(const VoxelGrid& grid, const Area& area, const Pose& place,
              std::vector<VoxelCut>& cuts);

}  // namespace cloudcontact
