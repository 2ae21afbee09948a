// Cuts a surface into depth columns, and those into voxels with exact coverage. The method is in
// columns.cpp.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "voxels/column_cutter.h"

namespace cloudcontact {

struct ColumnResult {
  Cloud::Voxels voxels;
  // Per column (u + v * width) what remains of the sum at its end [1/255]; 0 where the surface is
  // closed.
  std::vector<std::uint8_t> residue;
  std::size_t badColumns = 0;     // columns with a residue
  std::size_t cappedColumns = 0;  // columns that a cap passes through
  std::size_t cappedVoxels = 0;   // voxels that a cap passes through
};

// The bricks that the surface passes through. Only these will store numbers.
struct TouchedBricks {
  std::vector<bool> touched;  // in the order of Cloud::Voxels::table
  std::size_t count = 0;
};
TouchedBricks touchedBricks(const GridSurface& surface);

// The axis along which cutting is fastest.
int cheapestAxis(const GridSurface& surface);

// Cuts the surface into columns along `axis`, and those into voxels.
ColumnResult cutColumns(const GridSurface& surface, int axis, int threads,
                        const std::function<void(double)>& progress);

}  // namespace cloudcontact
