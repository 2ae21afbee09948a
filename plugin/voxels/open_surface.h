// Voxels of a surface with large missing parts, by vote of columns along three axes: see
// open_surface.cpp.
#pragma once

#include "voxels/columns.h"

namespace cloudcontact {

struct Vote {
  Cloud::Voxels voxels;
  std::size_t badColumns = 0;       // along all three axes
  std::size_t undecidedVoxels = 0;  // decided by the winding number
};

Vote voteOnColumns(const GridSurface& surface, int threads,
                   const std::function<void(double)>& progress);

}  // namespace cloudcontact
