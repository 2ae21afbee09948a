// DeviceWorkpiece: which workpieces go to the device, and what the CPU does.
#include <cloudcontact/device/device_workpiece.h>

#include <new>
#include <optional>
#include <stdexcept>

#include "device/digitizer_state.h"
#include "workpiece/area_cut.h"
#include "workpiece/brick_layout.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/device_guard.h"
#include "device/opencl_workpiece.h"
#endif

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

}  // namespace

struct DeviceWorkpiece::Inside {
  DeviceWorkpieceSettings settings;
  std::string message, name;
  BaseVectorField field;  // on the device: without its bricks' own blocks
  DeviceCutReport report;
  std::vector<VoxelCut> cuts;  // of an area
#if defined(CLOUDCONTACT_OPENCL)
  std::shared_ptr<opencl::Device> device;
  std::optional<opencl::OpenClWorkpiece> piece;

  template <typename Take>
  std::string takeOver(Take&& take);
  std::string upload();
#endif

  Inside(BaseVectorField whole, const DeviceWorkpieceSettings& how);
  void fallBack(const std::string& why);
};

DeviceWorkpiece::Inside::Inside(BaseVectorField whole, const DeviceWorkpieceSettings& how)
    : settings(how), field(std::move(whole)) {
  if (settings.backend == Backend::Cpu) return;
#if defined(CLOUDCONTACT_OPENCL)
  if (const std::string why = upload(); !why.empty()) fallBack(why);
#else
  fallBack(
      "built without OpenCL; install ocl-icd-opencl-dev and opencl-clhpp-headers and build again");
#endif
}

void DeviceWorkpiece::Inside::fallBack(const std::string& why) {
#if defined(CLOUDCONTACT_OPENCL)
  piece.reset();
  device.reset();
#endif
  message = "the CPU cuts: " + why;
  name.clear();
  settings.backend = Backend::Cpu;
}

#if defined(CLOUDCONTACT_OPENCL)

// Why the CPU must keep it, empty where the device has it: what `take` says, or its failure.
template <typename Take>
std::string DeviceWorkpiece::Inside::takeOver(Take&& take) {
  try {
    return opencl::guardedForRoom(name, take);
  } catch (const std::bad_alloc&) {
    return "the device has no room for it";
  }
}

std::string DeviceWorkpiece::Inside::upload() {
  try {
    device = opencl::Device::open(settings.timing, opencl::Kernels::Cut);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  name = device->name();
  const std::string why = takeOver([&] { return piece.emplace(device).take(field.bricks()); });
  if (!why.empty()) return why;
  std::unique_ptr<Bricks> rest = std::move(field).takeBricks();
  rest->blocks.resize(rest->tissues.size());
  rest->blocks.shrink_to_fit();
  field = BaseVectorField(std::move(rest));
  return {};
}

#endif

DeviceWorkpiece::DeviceWorkpiece(BaseVectorField field, const DeviceWorkpieceSettings& settings)
    : inside_(std::make_unique<Inside>(std::move(field), settings)) {}

DeviceWorkpiece::DeviceWorkpiece(Digitizer& digitizer) {
  Digitizer::Inside& from = *digitizer.inside_;
  const DeviceWorkpieceSettings settings{digitizer.backend(), from.settings.timing};
#if defined(CLOUDCONTACT_OPENCL)
  if (from.ran && from.field && from.onDevice.onDevice) {
    auto rest = std::make_unique<Bricks>(*from.bricks);
    opencl::guarded(from.name, [&] { from.digitizer->fetchTable(*rest); });
    rest->depths = DepthTable(rest->window);
    inside_ = std::make_unique<Inside>(BaseVectorField(std::move(rest)),
                                       DeviceWorkpieceSettings{Backend::Cpu, settings.timing});
    Inside& s = *inside_;
    s.name = from.name;
    s.settings.backend = Backend::OpenCl;
    const std::string why = s.takeOver([&] {
      s.device = opencl::Device::beside(*from.device, opencl::Kernels::Cut);
      return s.piece.emplace(s.device).take(s.field.bricks(), from.digitizer->blocks(),
                                            from.digitizer->blockCount());
    });
    if (why.empty()) return;
    s.fallBack(why);
    s.field = digitizer.field();
    return;
  }
#endif
  inside_ = std::make_unique<Inside>(digitizer.field(), settings);
  if (!from.noDevice.empty()) inside_->fallBack(from.noDevice);
}

DeviceWorkpiece::~DeviceWorkpiece() = default;
DeviceWorkpiece::DeviceWorkpiece(DeviceWorkpiece&&) noexcept = default;
DeviceWorkpiece& DeviceWorkpiece::operator=(DeviceWorkpiece&&) noexcept = default;

Backend DeviceWorkpiece::backend() const {
  return inside_->settings.backend;
}
const std::string& DeviceWorkpiece::device() const {
  return inside_->name;
}
const std::string& DeviceWorkpiece::message() const {
  return inside_->message;
}
const DeviceCutReport& DeviceWorkpiece::report() const {
  return inside_->report;
}

std::size_t DeviceWorkpiece::cut(std::span<const VoxelCut> voxels) {
  Inside& s = *inside_;
  s.report = {};
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece) {
    const std::size_t changed = opencl::guarded(s.name, [&] { return s.piece->cut(voxels); });
    s.report = s.piece->report();
    return changed;
  }
#endif
  return s.field.cut(voxels);
}

std::size_t DeviceWorkpiece::cut(const Area& area, const Pose& tool) {
  Inside& s = *inside_;
  const VoxelGrid grid{s.field.voxelSize(), s.field.origin(), s.field.size()};
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece && !std::holds_alternative<CloudArea>(area)) {
    const CcArea there = areaInGrid(grid, area, tool);
    const std::size_t changed = opencl::guarded(s.name, [&] { return s.piece->cut(there); });
    s.report = s.piece->report();
    return changed;
  }
#endif
  s.cuts.clear();
  listCuts(grid, area, tool, s.cuts);
  return cut(s.cuts);
}

BaseVectorField DeviceWorkpiece::field() const {
  Inside& s = *inside_;
  auto whole = std::make_unique<Bricks>(s.field.bricks());
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece) {
    opencl::guarded(s.name, [&] {
      s.piece->fetch(*whole);
      whole->sums = s.piece->tissueSums();
    });
  }
#endif
  return BaseVectorField(std::move(whole));
}

MassProperties DeviceWorkpiece::mass() const {
  Inside& s = *inside_;
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece)
    return massOf(s.field.bricks(), opencl::guarded(s.name, [&] { return s.piece->tissueSums(); }));
#endif
  return s.field.mass();
}

std::size_t DeviceWorkpiece::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  return inside_->piece ? inside_->piece->bytes() : 0;
#else
  return 0;
#endif
}

std::map<std::string, DeviceTime> DeviceWorkpiece::deviceTimes() {
  std::map<std::string, DeviceTime> times;
#if defined(CLOUDCONTACT_OPENCL)
  if (inside_->device)
    for (const auto& [what, spent] : inside_->device->clock())
      times[what] = {spent.seconds, spent.calls};
#endif
  return times;
}

}  // namespace cloudcontact
