// Windows as kernels/flat_window.h has them.
#pragma once

#include <cloudcontact/workpiece/window.h>

#include <vector>

#include "device/opencl.h"
#include "kernels/digitize/flat_window.h"

namespace cloudcontact::opencl {

// Whether a kernel may keep a brick's surroundings in local memory and sum in floats: these would
// not be too many, nor too far away, and exact. `localBytes`: what a device has for a group.
bool mayBeFlat(const Window& window, std::size_t localBytes);
// What they take of it at most: the tile, which of its columns lost something, the taps, each a run
// of its own.
std::size_t flatLocalBytes(const Window& window);

struct FlatTaps {
  explicit FlatTaps(const Window& window);
  std::vector<cl_float4> by;  // weights, and these times their places
  std::vector<CcFlatRun> runs;
};

// Halves of a brick's tile.
std::size_t flatTile(const Window& window);

}  // namespace cloudcontact::opencl
