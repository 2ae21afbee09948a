// Voxels of a surface that lacks much of itself: see open_surface.cpp.
#pragma once

#include "voxels/columns.h"

namespace cloudcontact {

struct Vote {
  Cloud::Voxels voxels;
  std::size_t badColumns = 0;       // of all three axes
  std::size_t undecidedVoxels = 0;  // left to the winding number
};

Vote voteOnColumns(const GridSurface& surface, int threads,
                   const std::function<void(double)>& progress);

}  // namespace cloudcontact
