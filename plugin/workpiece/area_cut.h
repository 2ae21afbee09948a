// An area in a workpiece's grid, and the cuts that it makes.
#pragma once

#include <cloudcontact/field/base_vector_field.h>

#include "kernels/cut/area_left.h"

namespace cloudcontact {

// A grid of voxels in the body's frame.
struct VoxelGrid {
  double voxelSize;
  Vec3 origin;
  Eigen::Vector3i size;
};

// The area in the grid. `place`: the pose of the area's frame. Throws std::invalid_argument where
// the area has no volume or the place is not finite.
CcArea areaInGrid(const VoxelGrid& grid, const PlacedSolid& area, const Pose& place);

// Whether ccAreaLeaves() (kernels/cut/area_left.h) supports the area's kind. Of other kinds
// areaInGrid() gives the bounds alone.
bool kernelKnows(const PlacedSolid& area);

// Appends the cuts of all voxels that the area meets.
void listCuts(const VoxelGrid& grid, const PlacedSolid& area, const Pose& place,
              std::vector<VoxelCut>& cuts);

}  // namespace cloudcontact
