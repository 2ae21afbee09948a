// TouchedList: the collision voxels of many areas in the layout of kernels/cut/digital_normal.h.
#pragma once

#include <cloudcontact/workpiece/collision_finder.h>

#include <span>
#include <vector>

#include "field/base_vector_bricks.h"
#include "kernels/cut/digital_normal.h"

namespace cloudcontact {

struct TouchedList {
  std::vector<CcTouchedVoxel> voxels;  // area by area
  std::vector<uint> firsts;            // of each area; one more at the end
  std::vector<double> terms;           // Gr, then h of each tissue

  // Throws std::out_of_range where a voxel lies outside the grid.
  TouchedList(const BaseVectorBricks& field, Span<const Span<const CollisionVoxel>> areas,
              bool hardness);
  // Computed here, as a device does.
  std::vector<CcNormalSum> sums(const BaseVectorBricks& field) const;
};

}  // namespace cloudcontact
