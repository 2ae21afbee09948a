// Digitizer: which meshes go to the device, and what the CPU does.
#include "device/digitizer_state.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/device_guard.h"
#endif

#include <exception>
#include <functional>
#include <future>
#include <new>
#include <stdexcept>

#include "mesh/mesh_topology.h"

namespace cloudcontact {

Digitizer::Inside::Inside(const DigitizerSettings& how) : settings(how) {
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
  message = noDevice = "the CPU digitises: " + noDevice;
  settings.backend = Backend::Cpu;
}

#if defined(CLOUDCONTACT_OPENCL)

namespace {

// In how many columns the triangles that close a surface take part: there are few of them.
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

// Why the CPU must do it; empty where it is done.
std::string Digitizer::Inside::cut(const Prepared& prepared, const DigitizeSettings& how,
                                   const FieldWanted* wanted) {
  checkSize(prepared, how, prepared.passes());
  if (!prepared.closable) return "the surface lacks much";
  grid = gridAround(prepared.closing.mesh, how.voxelSize);
  const GridSurface surface = inGrid(prepared, grid);
  opencl::OpenClDigitizer::StartField start;
  if (wanted)
    start = [&] {
      bricks = startBricks({grid.voxelSize, grid.origin, grid.bricks.cast<int>(), {}},
                           wanted->tissue, wanted->window);
      return bricks.get();
    };
  const int axis = cheapestAxis(surface);
  const std::string why = digitizer->run(surface, axis, start);
  onDevice = digitizer->report();
  if (!why.empty()) return why;
  // Nothing stored may still be solid bricks, which the CPU tells from nothing at all.
  if (onDevice.stored == 0) return "it stores no brick";
  report = {prepared.wasClosed, digitizer->badColumns() + cappedColumns(surface, axis), 0};
  return {};
}

// Most meshes are one closed surface: that is found out while the device already works.
std::string Digitizer::Inside::tryDevice(const Mesh& mesh, const DigitizeSettings& how,
                                         const FieldWanted* wanted) {
  if (wanted && wanted->tissue.size() > 1) return "a body of several tissues";
  if (const std::optional<Prepared> whole = preparedAsWhole(mesh)) {
    std::future<bool> is =
        std::async(std::launch::async, isOneClosedSurface, std::cref(whole->closing.mesh));
    std::exception_ptr failure;
    std::string why;
    try {
      why = cut(*whole, how, wanted);
    } catch (...) {
      failure = std::current_exception();
    }
    if (is.get()) {
      if (failure) std::rethrow_exception(failure);
      return why;
    }
  }
  return cut(prepare(mesh), how, wanted);
}

// The same, where the device's own failures are told apart.
std::string Digitizer::Inside::guarded(const Mesh& mesh, const DigitizeSettings& how,
                                       const FieldWanted* wanted) {
  try {
    return opencl::guardedForRoom(name, [&] { return tryDevice(mesh, how, wanted); });
  } catch (const std::bad_alloc&) {
    return "the device has no room for it";
  }
}

#endif

void Digitizer::Inside::run(const Mesh& mesh, const DigitizeSettings& how,
                            const FieldWanted* wanted) {
  ran = false;
  message = noDevice;
  cloud = {};
  bricks.reset();
  onDevice = {};
  field.reset();
  validate(how);
#if defined(CLOUDCONTACT_OPENCL)
  if (device) {
    const std::string why = guarded(mesh, how, wanted);
    onDevice.onDevice = why.empty();
    if (!why.empty()) message = "the CPU digitised: " + why;
  }
#endif
  if (!onDevice.onDevice) {
    cloud = digitize(mesh, how, &report);
    // Throws now, not when the field is asked for.
    if (wanted)
      startBricks({how.voxelSize, Vec3::Zero(), Eigen::Vector3i::Ones(), {}}, wanted->tissue,
                  wanted->window);
  }
  if (wanted) field.emplace(wanted->tissue, wanted->window);
  ran = true;
}

#if defined(CLOUDCONTACT_OPENCL)
Cloud Digitizer::Inside::fetched() {
  return opencl::guarded(name, [&] {
    return Cloud(grid.voxelSize, grid.origin,
                 std::make_shared<const Cloud::Voxels>(digitizer->voxels()));
  });
}
BaseVectorField Digitizer::Inside::fetchedField() {
  auto whole = std::make_unique<BaseVectorField::Bricks>(*bricks);
  opencl::guarded(name, [&] { digitizer->fetchField(*whole); });
  finishBricks(*whole);
  return BaseVectorField(std::move(whole));
}
#else
Cloud Digitizer::Inside::fetched() {
  return cloud;
}
BaseVectorField Digitizer::Inside::fetchedField() {
  return BaseVectorField(cloud, field->first, field->second);
}
#endif

Digitizer::Digitizer(const DigitizerSettings& settings)
    : inside_(std::make_unique<Inside>(settings)) {}
Digitizer::~Digitizer() = default;
Digitizer::Digitizer(Digitizer&&) noexcept = default;
Digitizer& Digitizer::operator=(Digitizer&&) noexcept = default;

Backend Digitizer::backend() const {
  return inside_->settings.backend;
}
const std::string& Digitizer::message() const {
  return inside_->message;
}
const std::string& Digitizer::device() const {
  return inside_->name;
}
const DigitizeReport& Digitizer::report() const {
  return inside_->report;
}
const DeviceDigitizeReport& Digitizer::deviceReport() const {
  return inside_->onDevice;
}

void Digitizer::run(const Mesh& mesh, const DigitizeSettings& settings) {
  inside_->run(mesh, settings, nullptr);
}

void Digitizer::run(const Mesh& mesh, const DigitizeSettings& settings, const TissueTable& tissue,
                    const WindowSettings& window) {
  const FieldWanted wanted{tissue, window};
  inside_->run(mesh, settings, &wanted);
}

Cloud Digitizer::cloud() {
  Inside& s = *inside_;
  if (!s.ran) throw std::logic_error("Digitizer::cloud: nothing was digitised; call run() first");
  if (s.onDevice.onDevice && s.cloud.empty()) s.cloud = s.fetched();
  return s.cloud;
}

BaseVectorField Digitizer::field() {
  Inside& s = *inside_;
  if (!s.ran || !s.field)
    throw std::logic_error("Digitizer::field: no field was made; call run() with a window first");
  if (s.onDevice.onDevice) return s.fetchedField();
  return BaseVectorField(s.cloud, s.field->first, s.field->second);
}

std::size_t Digitizer::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  return inside_->digitizer ? inside_->digitizer->bytes() : 0;
#else
  return 0;
#endif
}

std::map<std::string, DeviceTime> Digitizer::deviceTimes() {
  std::map<std::string, DeviceTime> times;
#if defined(CLOUDCONTACT_OPENCL)
  if (inside_->device)
    for (const auto& [name, spent] : inside_->device->clock())
      times[name] = {spent.seconds, spent.calls};
#endif
  return times;
}

}  // namespace cloudcontact
