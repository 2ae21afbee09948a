// A workpiece that is cut on the CPU or on an OpenCL device. Either leaves what
// BaseVectorField::cut() leaves, to the bit; on a device the field stays there until it is asked
// for. For cuts of thousands of voxels: one of 1,000 takes an H100 60 us, most of it launches.
#pragma once

#include <cloudcontact/device/digitizer.h>
#include <cloudcontact/workpiece/base_vector_field.h>
#include <cloudcontact/workpiece/cutter.h>

#include <map>
#include <memory>
#include <span>
#include <string>

namespace cloudcontact {

struct DeviceWorkpieceSettings {
  Backend backend = Backend::Cpu;
  bool timing = false;  // notes what each step on the device takes, which takes time itself
};

// What the last cut came to on the device.
struct DeviceCutReport {
  std::size_t named = 0;              // voxels that the cut named
  std::size_t changed = 0;            // that lost matter, as cut() counts them
  std::size_t bricks = 0;             // whose windows saw that
  std::size_t sent = 0, fetched = 0;  // [bytes]
};

// One object is for one thread at a time: field() and mass(), though const, write memory that all
// of its calls share.
class DeviceWorkpiece {
 public:
  // Where there is no device that computes as the CPU does, or it has no room for the field (one
  // block [21 kB] for every brick with matter), the CPU cuts, and message() says why. Throws
  // std::runtime_error where the device fails.
  explicit DeviceWorkpiece(BaseVectorField field, const DeviceWorkpieceSettings& settings = {});
  // The field of the digitiser's last run, on what that ran on; it never leaves the device. Throws
  // as Digitizer::field() does, too.
  explicit DeviceWorkpiece(Digitizer& digitizer);
  ~DeviceWorkpiece();
  DeviceWorkpiece(DeviceWorkpiece&&) noexcept;
  DeviceWorkpiece& operator=(DeviceWorkpiece&&) noexcept;

  Backend backend() const;             // what it runs on
  const std::string& device() const;   // the OpenCL device's name; empty on the CPU
  const std::string& message() const;  // why the CPU cuts; empty where it was to

  // Takes matter away, as BaseVectorField::cut() does; returns what that returns. Throws
  // std::out_of_range where a voxel is outside the grid, before anything is changed, and
  // std::runtime_error where the device fails: what is left there is then not known, and cut(),
  // field() and mass() throw std::runtime_error from then on. Takes no more memory there once it
  // was called with as many voxels.
  std::size_t cut(std::span<const VoxelCut> voxels);
  // The same with cutsOf() of a tool (cutter.h), whose pose alone goes to the device unless its
  // area is a cloud's. Throws as that does.
  std::size_t cut(const Area& area, const Pose& tool);

  // The workpiece as it is now; from the device it is fetched.
  BaseVectorField field() const;
  // As BaseVectorField::mass(); from the device a few sums of each brick are fetched.
  MassProperties mass() const;

  const DeviceCutReport& report() const;
  std::size_t deviceBytes() const;                  // held there
  std::map<std::string, DeviceTime> deviceTimes();  // DeviceWorkpieceSettings::timing

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace cloudcontact
