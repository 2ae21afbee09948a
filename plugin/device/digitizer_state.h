// What a Digitizer holds: its last run's results, here or on the device.
#pragma once

#include <cloudcontact/device/digitizer.h>

#include <optional>

#include "voxels/preparation.h"
#include "workpiece/brick_layout.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/opencl_digitizer.h"
#endif

namespace cloudcontact {

// A field that a run is to make, too.
struct FieldWanted {
  const TissueTable& tissue;
  const WindowSettings& window;
};

struct Digitizer::Inside {
  DigitizerSettings settings;
  std::string noDevice, message, name;
  bool ran = false;
  Cloud cloud;  // empty where it is on the device alone
  DigitizeReport report;
  DeviceDigitizeReport onDevice;
  Grid grid;                                        // of the last run
  std::unique_ptr<BaseVectorField::Bricks> bricks;  // without what is on the device
  Cloud fetched();
  BaseVectorField fetchedField();
  std::optional<std::pair<TissueTable, WindowSettings>> field;  // of the last run
#if defined(CLOUDCONTACT_OPENCL)
  std::shared_ptr<opencl::Device> device;
  std::optional<opencl::OpenClDigitizer> digitizer;

  std::string cut(const Prepared& prepared, const DigitizeSettings& how, const FieldWanted* wanted);
  std::string tryDevice(const Mesh& mesh, const DigitizeSettings& how, const FieldWanted* wanted);
  std::string guarded(const Mesh& mesh, const DigitizeSettings& how, const FieldWanted* wanted);
#endif

  explicit Inside(const DigitizerSettings& how);
  void run(const Mesh& mesh, const DigitizeSettings& how, const FieldWanted* wanted);
};

}  // namespace cloudcontact
