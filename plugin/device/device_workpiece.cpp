// DeviceWorkpiece: decides which workpieces go to the device, and cuts the others on the CPU.
#include <cloudcontact/device/device_workpiece.h>

#include <new>
#include <optional>
#include <stdexcept>

#include "device/touched_list.h"
#include "field/brick_layout.h"
#include "workpiece/area_cut.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/opencl_digitizer.h"
#include "device/opencl_workpiece.h"
#endif

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

std::vector<DigitalNormal> meansOf(std::span<const CcNormalSum> sums, double voxelSize) {
  std::vector<DigitalNormal> result;
  result.reserve(sums.size());
  for (const CcNormalSum& sum : sums) {
    DigitalNormal& n = result.emplace_back();
    n.count = sum.count;
    const double* const f = ccIsPlain(&sum) ? sum.plain : sum.vector;
    if (sum.count > 0) n.mean = voxelSize / sum.count * Vec3(f[0], f[1], f[2]);
  }
  return result;
}

}  // namespace

struct DeviceWorkpiece::State {
  DeviceWorkpieceSettings settings;
  std::string message, name;
  BaseVectorField field;  // without the bricks' own blocks if the device has them
  DeviceCutReport report;
  std::vector<VoxelCut> cuts;  // of an area
#if defined(CLOUDCONTACT_OPENCL)
  std::shared_ptr<opencl::Device> device;
  std::optional<opencl::OpenClWorkpiece> piece;

  template <typename Load>
  std::string load(Load&& onto);
  std::string upload();
#endif

  State(BaseVectorField whole, const DeviceWorkpieceSettings& given);
  void fallBack(const std::string& why);
};

DeviceWorkpiece::State::State(BaseVectorField whole, const DeviceWorkpieceSettings& given)
    : settings(given), field(std::move(whole)) {
  if (settings.backend == Backend::Cpu) return;
#if defined(CLOUDCONTACT_OPENCL)
  if (const std::string why = upload(); !why.empty()) fallBack(why);
#else
  fallBack(
      "built without OpenCL; install ocl-icd-opencl-dev and opencl-clhpp-headers and build again");
#endif
}

void DeviceWorkpiece::State::fallBack(const std::string& why) {
#if defined(CLOUDCONTACT_OPENCL)
  piece.reset();
  device.reset();
#endif
  message = "the CPU cuts: " + why;
  name.clear();
  settings.backend = Backend::Cpu;
}

#if defined(CLOUDCONTACT_OPENCL)

// Calls `onto`, which loads the field onto the device. Returns why the CPU must keep it, or
// nothing.
template <typename Load>
std::string DeviceWorkpiece::State::load(Load&& onto) {
  try {
    return opencl::guardedForRoom(name, onto);
  } catch (const std::bad_alloc&) {
    return "the device has no room for it";
  }
}

std::string DeviceWorkpiece::State::upload() {
  try {
    device = opencl::Device::open(settings.timing, opencl::Kernels::Cut);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  name = device->name();
  const std::string why = load([&] { return piece.emplace(device).load(field.bricks()); });
  if (!why.empty()) return why;
  std::unique_ptr<Bricks> rest = std::move(field).takeBricks();
  rest->blocks.resize(rest->tissues.size());
  rest->blocks.shrink_to_fit();
  field = BaseVectorField(std::move(rest));
  return {};
}

#endif

DeviceWorkpiece::DeviceWorkpiece(BaseVectorField field, const DeviceWorkpieceSettings& settings)
    : state_(std::make_unique<State>(std::move(field), settings)) {}

DeviceWorkpiece::DeviceWorkpiece(Digitizer& digitizer) {
  const DeviceWorkpieceSettings settings{digitizer.backend(), digitizer.timing()};
#if defined(CLOUDCONTACT_OPENCL)
  if (const auto from = digitizer.fieldOnDevice()) {
    from->rest->depths = DepthTable(from->rest->window);
    state_ = std::make_unique<State>(BaseVectorField(std::move(from->rest)),
                                     DeviceWorkpieceSettings{Backend::Cpu, settings.timing});
    State& s = *state_;
    s.name = digitizer.device();
    s.settings.backend = Backend::OpenCl;
    const std::string why = s.load([&] {
      s.device = opencl::Device::sharing(*from->device, opencl::Kernels::Cut);
      return s.piece.emplace(s.device).load(s.field.bricks(), from->blocks, from->blockCount);
    });
    if (why.empty()) return;
    s.fallBack(why);
    s.field = digitizer.field();
    return;
  }
#endif
  state_ = std::make_unique<State>(digitizer.field(), settings);
  if (settings.backend == Backend::Cpu && !digitizer.message().empty())
    state_->fallBack(digitizer.message());
}

DeviceWorkpiece::~DeviceWorkpiece() = default;
DeviceWorkpiece::DeviceWorkpiece(DeviceWorkpiece&&) noexcept = default;
DeviceWorkpiece& DeviceWorkpiece::operator=(DeviceWorkpiece&&) noexcept = default;

Backend DeviceWorkpiece::backend() const {
  return state_->settings.backend;
}
const std::string& DeviceWorkpiece::device() const {
  return state_->name;
}
const std::string& DeviceWorkpiece::message() const {
  return state_->message;
}
const DeviceCutReport& DeviceWorkpiece::report() const {
  return state_->report;
}

std::size_t DeviceWorkpiece::cut(Span<const VoxelCut> voxels) {
  State& s = *state_;
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

std::size_t DeviceWorkpiece::cut(const PlacedSolid& area, const Pose& tool) {
  State& s = *state_;
  const VoxelGrid grid{s.field.voxelSize(), s.field.origin(), s.field.size()};
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece && kernelKnows(area)) {
    const CcArea inGrid = areaInGrid(grid, area, tool);
    const std::size_t changed = opencl::guarded(s.name, [&] { return s.piece->cut(inGrid); });
    s.report = s.piece->report();
    return changed;
  }
#endif
  s.cuts.clear();
  listCuts(grid, area, tool, s.cuts);
  return cut(s.cuts);
}

std::vector<DigitalNormal> DeviceWorkpiece::digitalNormals(
    Span<const Span<const CollisionVoxel>> areas, bool hardness) const {
  State& s = *state_;
  const TouchedList list(s.field.bricks(), areas, hardness);
  if (areas.empty()) return {};
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece)
    return meansOf(opencl::guarded(s.name, [&] { return s.piece->normals(list); }),
                   s.field.voxelSize());
#endif
  return meansOf(list.sums(s.field.bricks()), s.field.voxelSize());
}

BaseVectorField DeviceWorkpiece::field() const {
  State& s = *state_;
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
  State& s = *state_;
#if defined(CLOUDCONTACT_OPENCL)
  if (s.piece)
    return massOf(s.field.bricks(), opencl::guarded(s.name, [&] { return s.piece->tissueSums(); }));
#endif
  return s.field.mass();
}

std::size_t DeviceWorkpiece::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  return state_->piece ? state_->piece->bytes() : 0;
#else
  return 0;
#endif
}

std::map<std::string, DeviceTime> DeviceWorkpiece::deviceTimes() {
#if defined(CLOUDCONTACT_OPENCL)
  if (state_->device) return state_->device->clock();
#endif
  return {};
}

}  // namespace cloudcontact
