// Meshes into voxels, and voxels' base vectors, on the CPU or on an OpenCL device. Either gives
// what digitize() and BaseVectorField give, to the bit; on a device the results stay there until
// they are asked for.
#pragma once

#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/workpiece/base_vector_field.h>

#include <map>
#include <memory>
#include <string>

namespace cloudcontact {

struct DigitizerSettings {
  Backend backend = Backend::Cpu;
  bool timing = false;  // notes what each step on the device takes, which takes time itself
};

// What the last run came to on the device.
struct DeviceDigitizeReport {
  bool onDevice = false;
  std::size_t triangles = 0;
  std::size_t listed = 0;   // triangles over columns eight voxels wide
  std::size_t places = 0;   // for pieces of triangles in voxels
  std::size_t touched = 0;  // bricks with a piece in them
  std::size_t stored = 0;   // bricks that store numbers
  std::size_t blocks = 0;   // bricks with windows of their own
  std::size_t taps = 0;     // voxels of a window
  std::size_t rounds = 0;   // 1; more where the device first had to make room
  std::size_t sent = 0;     // [bytes]
};

class Digitizer {
 public:
  // Where there is no device that computes as the CPU does the CPU digitises, and message() says
  // why.
  explicit Digitizer(const DigitizerSettings& settings = {});
  ~Digitizer();
  Digitizer(Digitizer&&) noexcept;
  Digitizer& operator=(Digitizer&&) noexcept;

  Backend backend() const;            // what it runs on
  const std::string& device() const;  // the OpenCL device's name; empty on the CPU
  // Why the CPU did the last run's work, or does all of it; empty where it was not to.
  const std::string& message() const;

  // Digitises; throws as digitize() does, and std::runtime_error where the device fails. Surfaces
  // that lack a part, shells that pass through one column, and what the device has no room for are
  // the CPU's.
  void run(const Mesh& mesh, const DigitizeSettings& settings);
  // The same, and a field of base vectors, of a body of one tissue; throws as BaseVectorField does.
  void run(const Mesh& mesh, const DigitizeSettings& settings, const TissueTable& tissue,
           const WindowSettings& window);

  // Of the last run; from the device they are fetched as they are asked for. Throw
  // std::logic_error where there was none, or none with a field.
  Cloud cloud();
  BaseVectorField field();
  const DigitizeReport& report() const;

  const DeviceDigitizeReport& deviceReport() const;
  std::size_t deviceBytes() const;                  // held there
  std::map<std::string, DeviceTime> deviceTimes();  // DigitizerSettings::timing

 private:
  friend class DeviceWorkpiece;  // takes a field over where it lies
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace cloudcontact
