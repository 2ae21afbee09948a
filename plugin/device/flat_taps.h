// Windows for the faster kernels (kernels/digitize/flat_window.h), which keep a brick and its
// surroundings in local memory and sum in floats.
#pragma once

#include <cloudcontact/field/window.h>

#include <vector>

#include "device/opencl_device.h"
#include "kernels/digitize/flat_window.h"

namespace cloudcontact::opencl {

// Whether a window fits those kernels: its taps are few and near enough, float sums are exact, and
// a work-group's local memory holds the tile.
bool mayBeFlat(const Window& window, std::size_t localBytes);
// An upper bound of the local memory in use [bytes].
std::size_t flatLocalBytes(const Window& window);
// Size of a brick's tile [halves].
std::size_t flatTile(const Window& window);

// A window's taps in runs along z.
struct FlatTaps {
  explicit FlatTaps(const Window& window);
  std::vector<cl_float4> by;  // moments and weights
  std::vector<CcFlatRun> runs;
};

}  // namespace cloudcontact::opencl
