// A workpiece cut on the CPU or on an OpenCL device. Both leave the same bits as
// BaseVectorField::cut(). On a device the field stays there until field() is called. A device pays
// off for cuts of thousands of voxels (docs/measurements.md).
#pragma once

#include <cloudcontact/base/span.h>
#include <cloudcontact/device/digitizer.h>
#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/workpiece/cutter.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace cloudcontact {

// The digital normal of a collision area (5').
struct DigitalNormal {
  double count = 0;          // n: sum of the collision voxels' shares
  Vec3 mean = Vec3::Zero();  // of their base vectors, in the workpiece's frame [m]
};

// Where a workpiece is cut.
struct DeviceWorkpieceSettings {
  Backend backend = Backend::Cpu;
  bool timing = false;  // times each kernel and copy, which slows the cuts down
};

// Not thread-safe: even the const functions field() and mass() write to shared buffers.
class DeviceWorkpiece {
 public:
  // Falls back to the CPU if no device computes the same bits as the CPU, or if the field does not
  // fit in device memory (21 kB for every brick with material); message() says why. Throws
  // std::runtime_error if the device fails.
  explicit DeviceWorkpiece(BaseVectorField field, const DeviceWorkpieceSettings& settings = {});
  // Takes the field of the digitizer's last run. A field in device memory is copied there. Throws
  // as Digitizer::field() does, too.
  explicit DeviceWorkpiece(Digitizer& digitizer);
  ~DeviceWorkpiece();
  DeviceWorkpiece(DeviceWorkpiece&&) noexcept;
  DeviceWorkpiece& operator=(DeviceWorkpiece&&) noexcept;

  Backend backend() const;             // in use
  const std::string& device() const;   // name of the OpenCL device; empty on the CPU
  const std::string& message() const;  // why the CPU is used instead of the device, or empty

  // Removes material as BaseVectorField::cut() does, and returns the same count. Throws
  // std::out_of_range if a voxel lies outside the grid, before anything changes, and
  // std::runtime_error if the device fails. After such a failure the field is unknown, and cut(),
  // field() and mass() throw std::runtime_error. Device memory grows only when a list is longer
  // than all before.
  std::size_t cut(Span<const VoxelCut> voxels);
  // The same for all voxels of cutsOf(field, area, tool) (cutter.h). Only the tool's pose is sent
  // to the device, unless the area is a cloud. Throws as cutsOf() does, too.
  std::size_t cut(const PlacedSolid& area, const Pose& tool);

  // The digital normals of many collision areas, each given by its collision voxels, such as
  // Collision::voxels of many places of a tool. Both backends give the same bits; they agree with
  // Collision::mean but for rounding. `hardness`: h in (5'). Throws std::out_of_range where a voxel
  // lies outside the grid, and std::runtime_error if the device fails.
  std::vector<DigitalNormal> digitalNormals(Span<const Span<const CollisionVoxel>> areas,
                                            bool hardness = true) const;

  // The workpiece as it is now, copied from the device.
  BaseVectorField field() const;
  // As BaseVectorField::mass(); only a few sums of each brick are copied from the device.
  MassProperties mass() const;

  const DeviceCutReport& report() const;            // of the last cut on the device
  std::size_t deviceBytes() const;                  // device memory in use [bytes]
  std::map<std::string, DeviceTime> deviceTimes();  // since the last call; needs settings.timing

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
