// DeviceTaps: a window's taps in device memory. Where they suit the faster kernels
// (kernels/digitize/flat_window.h), which keep a brick and its surroundings in local memory and sum
// in floats, they are in runs along z.
#pragma once

#include <cloudcontact/field/window.h>

#include <vector>

#include "device/opencl_device.h"
#include "kernels/cut/matter_cut.h"
#include "kernels/digitize/flat_window.h"

namespace cloudcontact::opencl {

class DeviceTaps {
 public:
  // Copies them, while the host goes on.
  void send(Device& device, const Window& window, const char* label);

  // Whether they are for the faster kernels: few and near enough, float sums are exact, and a
  // work-group's local memory holds the tile.
  bool flat() const { return flat_; }
  std::size_t tileBytes() const { return tile_; }  // of a brick and its surroundings
  // Moments and weights, or CcWindowTap.
  const cl::Buffer& taps() const { return deviceTaps_.buffer(); }
  const cl::Buffer& runs() const { return deviceRuns_.buffer(); }
  cl_uint runCount() const { return static_cast<cl_uint>(runs_.size()); }
  std::size_t sentBytes() const;
  std::vector<const DeviceBuffer*> buffers() const { return {&deviceTaps_, &deviceRuns_}; }

 private:
  void addRuns(const Window& window);

  bool flat_ = false;
  std::size_t tile_ = 0;
  std::vector<CcWindowTap> any_;
  std::vector<cl_float4> by_;
  std::vector<CcFlatRun> runs_;
  DeviceBuffer deviceTaps_, deviceRuns_;
};

}  // namespace cloudcontact::opencl
