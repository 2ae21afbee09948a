// Which of a sample's voxels may lie below a plane, boxes of them first, side by side.
#pragma once

#include "contact/lanes.h"

namespace cloudcontact::search {

// x is here - n.x below it.
struct OwnedPlane {
  float nx, ny, nz, here;
  float least;  // a voxel counts if it is more than this below
};

// A bit for each of `count` voxels from `first` on, at most OwnedVoxels::kBoxed: whether it counts.
std::uint32_t voxelsBelow(const OwnedPlane& plane, const OwnedVoxels::Level& level,
                          std::uint32_t first, int count);
// The same of boxes in which a point counts.
std::uint32_t boxesBelow(const OwnedPlane& plane, const OwnedBoxes& boxes, std::uint32_t first,
                         int count);

}  // namespace cloudcontact::search
