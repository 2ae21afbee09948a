// Digitizing on an OpenCL device: uploads a surface and runs one chain of kernels, which makes
// voxels and sums their windows. Results are downloaded on request.
#pragma once

#include <cloudcontact/field/base_vector_field.h>

#include "device/device_taps.h"
#include "device/opencl_device.h"
#include "field/brick_layout.h"
#include "kernels/digitize/digitize_layout.h"
#include "voxels/columns.h"

#include <array>
#include <functional>

namespace cloudcontact::opencl {

// A field whose blocks are in device memory, shared blocks first.
struct DigitizedField {
  std::shared_ptr<Device> device;
  std::unique_ptr<BaseVectorField::Bricks> rest;  // all but the blocks
  cl::Buffer blocks;
  std::size_t blockCount = 0;
};

class OpenClDigitizer {
 public:
  explicit OpenClDigitizer(std::shared_ptr<Device> device) : device_(std::move(device)) {}

  // Digitizes a surface without boundary. With `field` also sums its windows: `field` returns the
  // field's grid and window, and is called while the device works. Returns why the CPU must do it
  // instead, or nothing. Throws cl::Error if the device fails.
  using StartField = std::function<const BaseVectorField::Bricks*()>;
  std::string run(const GridSurface& surface, int axis, const StartField& field);

  const DeviceDigitizeReport& report() const { return report_; }
  std::size_t badColumns() const { return counters_[CC_BAD_COLUMNS]; }
  std::size_t bytes() const;  // device memory in use

  // Downloads.
  Cloud::Voxels voxels();
  void fetchField(BaseVectorField::Bricks& to);  // table and blocks
  void fetchTable(BaseVectorField::Bricks& to);
  // The field's blocks in device memory; the first is the shared one.
  const cl::Buffer& blocks() const { return blocks_.buffer(); }
  std::size_t blockCount() const { return counters_[CC_OWN_BLOCKS] + std::size_t{1}; }

 private:
  using Counters = std::array<cl_uint, CC_CUT_COUNTERS>;

  template <typename Self>
  static auto buffers(Self& self);
  void release();
  void guess(const GridSurface& surface, int axis, bool field);
  void guessRooms(const GridSurface& surface, int axis);
  std::size_t maxBlocks() const;
  std::string lacking(bool field) const;
  bool enlarge(bool field);
  void send(const GridSurface& surface);
  void reserve();
  void cut();
  void sum();
  void sumWindows(const BaseVectorField::Bricks& field);
  void sendWindow(const BaseVectorField::Bricks& field);
  std::string runChain(const GridSurface& surface, const StartField& start);

  std::shared_ptr<Device> device_;
  CcColumns grid_{};
  CcWindows windows_{};
  std::size_t columns_ = 0, table_ = 0;  // columns of bricks; bricks
  Counters counters_{};
  DeviceDigitizeReport report_;
  PinnedMemory sent_;
  DeviceTaps taps_;
  DeviceBuffer surface_, triangles_, shells_, deviceCounters_, counts_, first_, entries_, owners_,
      found_, pieces_, touched_, placed_, sums_, deviceTable_, stored_, firstStored_, bricks_, own_,
      ownGroups_, firstOwn_, blockOf_, list_, density_, blocks_;
};

}  // namespace cloudcontact::opencl
