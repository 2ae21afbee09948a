// Digitizer: decides which meshes go to the device, and digitizes the others on the CPU.
#include <cloudcontact/device/digitizer.h>

#include <exception>
#include <functional>
#include <future>
#include <new>
#include <optional>
#include <stdexcept>

#include "field/brick_layout.h"
#include "mesh/mesh_topology.h"
#include "voxels/preparation.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/opencl_digitizer.h"
#endif

namespace cloudcontact {

namespace {

// What a run makes a field from, besides the voxels.
struct FieldSource {
  const TissueTable& tissue;
  const WindowSettings& window;
};

}  // namespace

struct Digitizer::State {
  DigitizerSettings settings;
  std::string noDevice, message, name;
  // The last run:
  bool ran = false;
  Cloud cloud;  // empty until it is copied from the device
  DigitizeReport report;
  DeviceDigitizeReport onDevice;
  Grid grid;
  std::unique_ptr<BaseVectorField::Bricks>
      bricks;  // without table and blocks, which the device has
  std::optional<std::pair<TissueTable, WindowSettings>> field;
#if defined(CLOUDCONTACT_OPENCL)
  std::shared_ptr<opencl::Device> device;
  std::optional<opencl::OpenClDigitizer> digitizer;

  std::string cut(const Prepared& prepared, const DigitizeSettings& how, const FieldSource* source);
  std::string tryDevice(const Mesh& mesh, const DigitizeSettings& how, const FieldSource* source);
  std::string runOnDevice(const Mesh& mesh, const DigitizeSettings& how, const FieldSource* source);
#endif

  explicit State(const DigitizerSettings& given);
  void run(const Mesh& mesh, const DigitizeSettings& how, const FieldSource* source);
  Cloud fetchCloud();
  BaseVectorField fetchField();
};

Digitizer::State::State(const DigitizerSettings& given) : settings(given) {
  if (settings.backend == Backend::Cpu) return;
#if defined(CLOUDCONTACT_OPENCL)
  try {
    device = opencl::Device::open(settings.timing, opencl::Kernels::Digitize);
    digitizer.emplace(device);
    name = device->name();
    return;
  } catch (const std::runtime_error& e) {
    noDevice = e.what();
  }
#else
  noDevice =
      "built without OpenCL; install ocl-icd-opencl-dev and opencl-clhpp-headers and build again";
#endif
  message = noDevice = "the CPU digitizes: " + noDevice;
  settings.backend = Backend::Cpu;
}

#if defined(CLOUDCONTACT_OPENCL)

namespace {

// How many columns contain a triangle that closes a hole. There are few of those triangles.
std::size_t cappedColumns(const GridSurface& surface, int axis) {
  if (surface.firstCap == surface.triangles.size()) return 0;
  GridSurface caps = surface;
  caps.triangles.erase(caps.triangles.begin(),
                       caps.triangles.begin() + static_cast<std::ptrdiff_t>(caps.firstCap));
  caps.component.clear();
  caps.firstCap = 0;
  return cutColumns(caps, axis, 0, {}).cappedColumns;
}

}  // namespace

// Digitizes a prepared surface; returns why the CPU must do it instead, or nothing.
std::string Digitizer::State::cut(const Prepared& prepared, const DigitizeSettings& how,
                                  const FieldSource* source) {
  checkSize(prepared, how, prepared.passes());
  if (!prepared.closable) return "the surface has large holes";
  grid = gridAround(prepared.closing.mesh, how.voxelSize);
  const GridSurface surface = inGrid(prepared.closing, grid, prepared.oneShell);
  opencl::OpenClDigitizer::StartField start;
  if (source)
    start = [&] {
      bricks = startBricks({grid.voxelSize, grid.origin, grid.bricks.cast<int>(), {}},
                           source->tissue, source->window);
      return bricks.get();
    };
  const int axis = cheapestAxis(surface);
  const std::string why = digitizer->run(surface, axis, start);
  onDevice = digitizer->report();
  if (!why.empty()) return why;
  // Only solid bricks, or no voxel at all: the CPU distinguishes the two.
  if (onDevice.stored == 0) return "it stores no brick";
  report = {prepared.wasClosed, digitizer->badColumns() + cappedColumns(surface, axis), 0};
  return {};
}

// Most meshes are one closed surface, so the device starts while that is still being checked.
std::string Digitizer::State::tryDevice(const Mesh& mesh, const DigitizeSettings& how,
                                        const FieldSource* source) {
  if (source && source->tissue.size() > 1) return "a body of several tissues";
  if (const std::optional<Prepared> whole = preparedAsWhole(mesh)) {
    std::future<bool> closed =
        std::async(std::launch::async, isOneClosedSurface, std::cref(whole->closing.mesh));
    std::exception_ptr failure;
    std::string why;
    try {
      why = cut(*whole, how, source);
    } catch (...) {
      failure = std::current_exception();
    }
    if (closed.get()) {
      if (failure) std::rethrow_exception(failure);
      return why;
    }
  }
  return cut(prepare(mesh), how, source);
}

std::string Digitizer::State::runOnDevice(const Mesh& mesh, const DigitizeSettings& how,
                                          const FieldSource* source) {
  try {
    return opencl::guardedForRoom(name, [&] { return tryDevice(mesh, how, source); });
  } catch (const std::bad_alloc&) {
    return "the device has no room for it";
  }
}

#endif

void Digitizer::State::run(const Mesh& mesh, const DigitizeSettings& how,
                           const FieldSource* source) {
  ran = false;
  message = noDevice;
  cloud = {};
  bricks.reset();
  onDevice = {};
  field.reset();
  validate(how);
#if defined(CLOUDCONTACT_OPENCL)
  if (device) {
    const std::string why = runOnDevice(mesh, how, source);
    onDevice.onDevice = why.empty();
    if (!why.empty()) message = "the CPU digitized: " + why;
  }
#endif
  if (!onDevice.onDevice) {
    cloud = digitize(mesh, how, &report);
    // Throws now rather than in field().
    if (source)
      startBricks({how.voxelSize, Vec3::Zero(), Eigen::Vector3i::Ones(), {}}, source->tissue,
                  source->window);
  }
  if (source) field.emplace(source->tissue, source->window);
  ran = true;
}

#if defined(CLOUDCONTACT_OPENCL)
Cloud Digitizer::State::fetchCloud() {
  return opencl::guarded(name, [&] {
    return Cloud(grid.voxelSize, grid.origin,
                 std::make_shared<const Cloud::Voxels>(digitizer->voxels()));
  });
}
BaseVectorField Digitizer::State::fetchField() {
  auto whole = std::make_unique<BaseVectorField::Bricks>(*bricks);
  opencl::guarded(name, [&] { digitizer->fetchField(*whole); });
  finishBricks(*whole);
  return BaseVectorField(std::move(whole));
}
#else
Cloud Digitizer::State::fetchCloud() {
  return cloud;
}
BaseVectorField Digitizer::State::fetchField() {
  return BaseVectorField(cloud, field->first, field->second);
}
#endif

bool Digitizer::timing() const {
  return state_->settings.timing;
}

#if defined(CLOUDCONTACT_OPENCL)
std::unique_ptr<opencl::DigitizedField> Digitizer::fieldOnDevice() {
  State& s = *state_;
  if (!s.ran || !s.field || !s.onDevice.onDevice) return nullptr;
  auto rest = std::make_unique<BaseVectorField::Bricks>(*s.bricks);
  opencl::guarded(s.name, [&] { s.digitizer->fetchTable(*rest); });
  return std::make_unique<opencl::DigitizedField>(opencl::DigitizedField{
      s.device, std::move(rest), s.digitizer->blocks(), s.digitizer->blockCount()});
}
#endif

Digitizer::Digitizer(const DigitizerSettings& settings)
    : state_(std::make_unique<State>(settings)) {}
Digitizer::~Digitizer() = default;
Digitizer::Digitizer(Digitizer&&) noexcept = default;
Digitizer& Digitizer::operator=(Digitizer&&) noexcept = default;

Backend Digitizer::backend() const {
  return state_->settings.backend;
}
const std::string& Digitizer::message() const {
  return state_->message;
}
const std::string& Digitizer::device() const {
  return state_->name;
}
const DigitizeReport& Digitizer::report() const {
  return state_->report;
}
const DeviceDigitizeReport& Digitizer::deviceReport() const {
  return state_->onDevice;
}

void Digitizer::run(const Mesh& mesh, const DigitizeSettings& settings) {
  state_->run(mesh, settings, nullptr);
}

void Digitizer::run(const Mesh& mesh, const DigitizeSettings& settings, const TissueTable& tissue,
                    const WindowSettings& window) {
  const FieldSource source{tissue, window};
  state_->run(mesh, settings, &source);
}

Cloud Digitizer::cloud() {
  State& s = *state_;
  if (!s.ran) throw std::logic_error("Digitizer::cloud: nothing was digitized; call run() first");
  if (s.onDevice.onDevice && s.cloud.empty()) s.cloud = s.fetchCloud();
  return s.cloud;
}

BaseVectorField Digitizer::field() {
  State& s = *state_;
  if (!s.ran || !s.field)
    throw std::logic_error("Digitizer::field: no field was made; call run() with a window first");
  if (s.onDevice.onDevice) return s.fetchField();
  return BaseVectorField(s.cloud, s.field->first, s.field->second);
}

std::size_t Digitizer::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  return state_->digitizer ? state_->digitizer->bytes() : 0;
#else
  return 0;
#endif
}

std::map<std::string, DeviceTime> Digitizer::deviceTimes() {
#if defined(CLOUDCONTACT_OPENCL)
  if (state_->device) return state_->device->clock();
#endif
  return {};
}

}  // namespace cloudcontact
