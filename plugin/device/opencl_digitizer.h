// Digitising on an OpenCL device: a surface goes up, one chain of kernels makes voxels of it and
// sums their windows, and what is asked for comes down.
#pragma once

#include <cloudcontact/device/digitizer.h>

#include "device/device_memory.h"
#include "kernels/digitize/digitize_layout.h"
#include "voxels/columns.h"
#include "workpiece/brick_layout.h"

#include <array>
#include <functional>

namespace cloudcontact::opencl {

class OpenClDigitizer {
 public:
  explicit OpenClDigitizer(std::shared_ptr<Device> device) : device_(std::move(device)) {}

  // Makes voxels of a surface without boundary, and the sums of its windows where `window` gives a
  // field's grid and window; it is called while the device works. Returns why the CPU must do it;
  // nothing where it is done. Throws std::runtime_error where the device fails.
  using StartField = std::function<const BaseVectorField::Bricks*()>;
  std::string run(const GridSurface& surface, int axis, const StartField& field);

  const DeviceDigitizeReport& report() const { return report_; }
  std::size_t badColumns() const { return counters_[CC_BAD_COLUMNS]; }
  std::size_t bytes() const;

  Cloud::Voxels voxels();                        // fetched
  void fetchField(BaseVectorField::Bricks& to);  // table and blocks
  void fetchTable(BaseVectorField::Bricks& to);
  // The field's blocks, of which the first is the shared one.
  const cl::Buffer& blocks() const { return blocks_.buffer(); }
  std::size_t blockCount() const { return counters_[CC_OWN_BLOCKS] + std::size_t{1}; }

 private:
  using Counters = std::array<cl_uint, CC_CUT_COUNTERS>;

  template <typename Self>
  static auto held(Self& self);
  void giveBack();
  void guess(const GridSurface& surface, int axis, bool field);
  void guessRooms(const GridSurface& surface, int axis);
  std::size_t mostBlocks() const;
  std::string lacking(bool field) const;
  bool enlarge(bool field);
  void send(const GridSurface& surface);
  void makeRoom();
  void cut();
  void sum();
  void sumWindows(const BaseVectorField::Bricks& field);
  void sendWindow(const BaseVectorField::Bricks& field);
  std::string runChain(const GridSurface& surface, const StartField& start);

  std::shared_ptr<Device> device_;
  CcColumns grid_{};
  CcWindows windows_{};
  bool flat_ = false;     // windows that the faster kernel can sum
  std::size_t tile_ = 0;  // halves, of its tile
  std::size_t sentBytes_ = 0;
  cl_uint runCount_ = 0;
  std::size_t bins_ = 0, table_ = 0;
  Counters counters_{};
  DeviceDigitizeReport report_;
  Pinned sent_, sentWindow_;
  Grown surface_, triangles_, shells_, countersThere_, counts_, first_, entries_, owners_, found_,
      pieces_, touched_, placed_, sums_, tableThere_, stored_, firstStored_, bricks_, own_,
      ownGroups_, firstOwn_, blockOf_, list_, taps_, runs_, density_, blocks_;
};

}  // namespace cloudcontact::opencl
