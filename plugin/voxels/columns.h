// Depth columns with exact coverage: how a surface becomes voxels. See columns.cpp for the method.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "voxels/grid_surface.h"

namespace cloudcontact {

struct ColumnResult {
  Cloud::Voxels voxels;
  // One entry a column, u + v * width: what the surface's sum left at the column's end [1/255],
  // 0 where it closed. Only surfaces with a boundary leave anything.
  std::vector<std::uint8_t> residue;
  std::size_t badColumns = 0;
  std::size_t cappedColumns = 0;  // columns in which a closing triangle took part
  std::size_t cappedVoxels = 0;   // voxels that one passes through
};

// The bricks that the surface passes through: no others will store numbers.
struct SurfaceBricks {
  std::vector<bool> touched;  // in the order of Cloud::Voxels::table
  std::size_t count = 0;
};
SurfaceBricks surfaceBricks(const GridSurface& surface);

// The axis along which cutting is cheapest.
int cheapestAxis(const GridSurface& surface);

// Cuts the surface into columns along `axis` and those into voxels.
ColumnResult cutColumns(const GridSurface& surface, int axis, int threads,
                        const std::function<void(double)>& progress);

}  // namespace cloudcontact
