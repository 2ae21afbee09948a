// Digitizes meshes and sums base vectors, on the CPU or on an OpenCL device. Both give the same
// bits as digitize() and BaseVectorField. Results stay in device memory until they are requested.
#pragma once

#include <cloudcontact/device/backend.h>
#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/voxels/digitize.h>

#include <map>
#include <memory>
#include <string>

namespace cloudcontact {

namespace opencl {
struct DigitizedField;
}

// Where meshes are digitized.
struct DigitizerSettings {
  Backend backend = Backend::Cpu;
  bool timing = false;  // times each kernel and copy, which slows the digitizer down
};

class Digitizer {
 public:
  // Falls back to the CPU if no device computes the same bits as the CPU; message() says why.
  explicit Digitizer(const DigitizerSettings& settings = {});
  ~Digitizer();
  Digitizer(Digitizer&&) noexcept;
  Digitizer& operator=(Digitizer&&) noexcept;

  Backend backend() const;            // in use
  const std::string& device() const;  // name of the OpenCL device; empty on the CPU
  // Why the CPU did the last run, or does all runs; empty if the device did it, or was not chosen.
  const std::string& message() const;

  // Digitizes a mesh. The CPU takes over for surfaces with large holes, shells that share a column,
  // and meshes that do not fit in device memory. Throws as digitize() does, and std::runtime_error
  // if the device fails.
  void run(const Mesh& mesh, const DigitizeSettings& settings);
  // Also makes the base-vector field of a body of one tissue. Throws as BaseVectorField does, too.
  void run(const Mesh& mesh, const DigitizeSettings& settings, const TissueTable& tissue,
           const WindowSettings& window);

  // Results of the last run, copied from the device on request. They throw std::logic_error before
  // the first run; field() also after a run without a window.
  Cloud cloud();
  BaseVectorField field();
  const DigitizeReport& report() const;

  const DeviceDigitizeReport& deviceReport() const;
  std::size_t deviceBytes() const;                  // device memory in use [bytes]
  std::map<std::string, DeviceTime> deviceTimes();  // since the last call; needs settings.timing

 private:
  friend class DeviceWorkpiece;  // continues with the field in device memory
  bool timing() const;
  std::unique_ptr<opencl::DigitizedField> fieldOnDevice();  // null if it is on the CPU

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
