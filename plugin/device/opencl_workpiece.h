// A workpiece on an OpenCL device, whose blocks stay there. A step uploads the cut, runs one chain
// of kernels and downloads two counts.
#pragma once

#include <cloudcontact/field/base_vector_field.h>

#include "device/device_taps.h"
#include "device/opencl_device.h"
#include "device/touched_list.h"
#include "field/base_vector_bricks.h"
#include "kernels/cut/area_left.h"
#include "kernels/cut/matter_cut.h"

#include <span>
#include <string>
#include <vector>

namespace cloudcontact::opencl {

class OpenClWorkpiece {
 public:
  explicit OpenClWorkpiece(std::shared_ptr<Device> device) : device_(std::move(device)) {}

  // Loads a field; returns why the CPU must keep it, or nothing. Throws std::bad_alloc and
  // cl::Error if the device fails.
  std::string load(const BaseVectorField::Bricks& field);
  // The same for a field whose blocks are on this device already.
  std::string load(const BaseVectorField::Bricks& rest, const cl::Buffer& blocks,
                   std::size_t count);
  // As BaseVectorField::cut(). If the device fails in a cut, every later call throws
  // std::runtime_error.
  std::size_t cut(std::span<const VoxelCut> voxels);
  // The same for all voxels in an area.
  std::size_t cut(const CcArea& area);
  // As TouchedList::sums().
  std::vector<CcNormalSum> normals(const TouchedList& list);
  // The sums of each tissue.
  std::vector<MatterSums> tissueSums();
  // Downloads table and blocks: the shared blocks, then the bricks' own in the order of the table.
  void fetch(BaseVectorField::Bricks& to);

  const DeviceCutReport& report() const { return report_; }
  std::size_t bytes() const;  // device memory in use

 private:
  std::string lacking(const BaseVectorField::Bricks& field) const;
  std::string prepare(const BaseVectorField::Bricks& field, std::size_t blocks);
  void assignHomes(const BaseVectorField::Bricks& field, std::size_t blocks);
  void sendWindow(const BaseVectorField::Bricks& field);
  template <typename Work>
  void change(Work&& work);
  void checkIntact() const;
  void runStep(const void* packed, std::size_t voxels);
  void runStep(const CcArea& area, const std::size_t bricks[3], std::size_t count);
  void linkVoxels(std::size_t voxels);
  void renewWindows(std::size_t bricks);
  void readCounts();

  std::shared_ptr<Device> device_;
  CcCutting grid_{};
  std::size_t shared_ = 0, blocks_ = 0;  // shared blocks; these and one for each brick
  std::size_t maxBricks_ = 0;            // whose windows see one voxel
  std::vector<cl_int> table_, homeOf_;   // of each brick: its block, and the block of its own
  std::vector<cl_uint> bricks_;          // the brick of each own block
  int current_ = 0;                      // which of steps_ the next step uses
  std::size_t lastVoxels_ = 0;           // voxels listed in the other
  bool failed_ = false;                  // during a cut, which leaves links and losses behind
  DeviceCutReport report_;
  PinnedMemory sent_, fetched_, fetchedSums_;
  DeviceTaps taps_;
  DeviceBuffer steps_[2], next_, last_, lost_, home_, deviceTable_, deviceBlocks_, listed_, list_,
      kindOf_, densities_, deviceBricks_, sums_, touched_, firsts_, terms_, normals_;
};

}  // namespace cloudcontact::opencl
