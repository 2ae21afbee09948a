// A workpiece on an OpenCL device: its blocks stay there; what a step names goes up, one chain of
// kernels takes it, and two counts come down.
#pragma once

#include <cloudcontact/device/device_workpiece.h>

#include "device/device_memory.h"
#include "kernels/cut/area_left.h"
#include "kernels/cut/matter_cut.h"
#include "workpiece/base_vector_bricks.h"

namespace cloudcontact::opencl {

class OpenClWorkpiece {
 public:
  explicit OpenClWorkpiece(std::shared_ptr<Device> device) : device_(std::move(device)) {}

  // Takes the field over; returns why the CPU must keep it, nothing where it is done. Its blocks
  // may lie on this device already. Throws std::bad_alloc and cl::Error where the device fails.
  std::string take(const BaseVectorField::Bricks& field);
  std::string take(const BaseVectorField::Bricks& rest, const cl::Buffer& blocks,
                   std::size_t count);
  // As BaseVectorField::cut(). Where the device fails half-way, all that is called later throws
  // std::runtime_error.
  std::size_t cut(std::span<const VoxelCut> voxels);
  // Of all voxels that lie in an area.
  std::size_t cut(const CcArea& area);
  // Of all that is left.
  std::vector<TissueSums> tissueSums();
  // Table and blocks as they are now; the shared blocks first, then the bricks' own in their order.
  void fetch(BaseVectorField::Bricks& to);

  const DeviceCutReport& report() const { return report_; }
  std::size_t bytes() const;

 private:
  std::string lacking(const BaseVectorField::Bricks& field) const;
  std::string prepare(const BaseVectorField::Bricks& field, std::size_t blocks);
  void giveHomes(const BaseVectorField::Bricks& field, std::size_t blocks);
  void sendWindow(const BaseVectorField::Bricks& field);
  template <typename Work>
  void change(Work&& work);
  void checkWhole() const;
  void run(const void* packed, std::size_t voxels);
  void run(const CcArea& area, const std::size_t bricks[3], std::size_t count);
  void string(std::size_t voxels);
  void renew(std::size_t bricks);
  void readCounts();

  std::shared_ptr<Device> device_;
  CcCutting grid_{};
  bool flat_ = false;
  std::size_t tile_ = 0;                 // halves, of the faster kernel's
  std::size_t shared_ = 0, blocks_ = 0;  // shared blocks; these and a home for every brick
  std::size_t most_ = 0;                 // bricks that see a voxel
  cl_uint runCount_ = 0;
  std::vector<cl_int> table_, homeOf_;
  std::vector<cl_uint> bricks_;  // of each home
  int turn_ = 0;                 // which of two steps_ the next step goes into
  std::size_t before_ = 0;       // voxels named in the other
  bool failed_ = false;          // half-way in a cut: links and losses that no step is to meet
  DeviceCutReport report_;
  Pinned sent_, fetched_, fetchedSums_;
  Grown steps_[2], next_, last_, lost_, home_, tableThere_, blocksThere_, listed_, list_, kindOf_,
      densities_, taps_, runs_, bricksThere_, sums_;
};

}  // namespace cloudcontact::opencl
