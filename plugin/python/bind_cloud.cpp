// Python: clouds, how they are made, and CT volumes.
#include <cloudcontact/device/digitizer.h>
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/voxels/cloud_file.h>
#include <cloudcontact/voxels/ct_volume.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/display_mesh.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/pieces.h>
#include <cloudcontact/voxels/volume_file.h>

#include <cmath>

#include "python/bindings.h"
#include "python/dense_cloud.h"
#include "python/long_work.h"
#include "python/numpy_views.h"
#include "python/unlocked.h"
#include "python/voxel_lists.h"
#include "scene/body.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using Bytes = py::array_t<std::uint8_t, py::array::f_style | py::array::forcecast>;

py::ssize_t along(const Eigen::Vector3i& size, int axis) {
  return static_cast<py::ssize_t>(size[axis]);
}

// Numbers of a grid, x fastest, as an array [x, y, z].
template <typename Number>
py::array gridView(const Number* data, const Eigen::Vector3i& size, const py::object& owner,
                   bool writable) {
  const auto bytes = static_cast<py::ssize_t>(sizeof(Number));
  return viewOf(data, {along(size, 0), along(size, 1), along(size, 2)},
                {bytes, bytes * along(size, 0), bytes * along(size, 0) * along(size, 1)}, owner,
                writable);
}

py::array gridArray(std::vector<std::uint8_t> numbers, const Eigen::Vector3i& size) {
  auto kept = std::make_shared<std::vector<std::uint8_t>>(std::move(numbers));
  return gridView(kept->data(), size, keeping(kept), true);
}

// The bricks of a cloud [brick, x, y, z], over the cloud's own memory.
template <typename Bricks>
py::array brickView(const Cloud& cloud, const Bricks& bricks) {
  static_assert(sizeof bricks[0] == kBrickVoxels);
  return viewOf(reinterpret_cast<const std::uint8_t*>(bricks.data()),
                {static_cast<py::ssize_t>(bricks.size()), kBrickEdge, kBrickEdge, kBrickEdge},
                {kBrickVoxels, 1, kBrickEdge, kBrickEdge * kBrickEdge}, keeping(cloud));
}

// Coverage in 1/255 from shares of 0..1, booleans, or bytes.
Bytes coverageOf(const py::array& values) {
  if (values.ndim() != 3)
    throw std::invalid_argument("coverage: give an array of the shape (nx, ny, nz)");
  const char kind = values.dtype().kind();
  if (kind == 'u' && values.itemsize() == 1) return Bytes::ensure(values);
  if (kind == 'b') return Bytes::ensure(values * py::int_(255));
  if (kind != 'f')
    throw std::invalid_argument("coverage: give shares of 0..1, booleans, or uint8 of 0..255");
  const auto shares =
      py::array_t<double, py::array::f_style | py::array::forcecast>::ensure(values);
  Bytes bytes({shares.shape(0), shares.shape(1), shares.shape(2)});
  const double* from = shares.data();
  std::uint8_t* to = bytes.mutable_data();
  for (py::ssize_t i = 0; i < shares.size(); ++i) {
    if (!(from[i] >= 0 && from[i] <= 1))
      throw std::invalid_argument("coverage: a share is not in 0..1; divide by the largest value");
    to[i] = static_cast<std::uint8_t>(std::lround(255 * from[i]));
  }
  return bytes;
}

// Numbers of materials, for voxels of that coverage.
Bytes materialOf(const py::object& material, const Bytes& coverage) {
  const Integers numbers = integersOf("material", material);
  if (numbers.ndim() != 3 || numbers.size() != coverage.size() ||
      numbers.shape(0) != coverage.shape(0) || numbers.shape(1) != coverage.shape(1))
    throw std::invalid_argument("material: give an array of the shape of the coverage");
  for (py::ssize_t i = 0; i < numbers.size(); ++i)
    if (numbers.data()[i] < 0 || numbers.data()[i] > 255)
      throw std::invalid_argument("material: is not in 0..255; give numbers into `materials`");
  return Bytes::ensure(material);
}

Cloud fromArray(const py::array& values, double voxel, const Vec3& origin,
                const py::object& material, const std::vector<std::string>& names) {
  const Bytes coverage = coverageOf(values);
  DenseVoxels voxels;
  for (int k = 0; k < 3; ++k) voxels.size[k] = static_cast<int>(coverage.shape(k));
  voxels.coverage = {coverage.data(), static_cast<std::size_t>(coverage.size())};
  Bytes numbers;
  if (!material.is_none()) {
    numbers = materialOf(material, coverage);
    voxels.material = {numbers.data(), static_cast<std::size_t>(numbers.size())};
  }
  const Unlocked unlocked;
  return cloudFromDense(voxels, voxel, origin, names);
}

MassProperties massOf(const Cloud& cloud, const py::object& density) {
  std::vector<double> densities;
  if (py::isinstance<py::sequence>(density) || py::isinstance<py::array>(density))
    densities = density.cast<std::vector<double>>();
  else
    densities = {numberOf("density", density)};
  const Unlocked unlocked;
  return massPropertiesOf(cloud, densities);
}

void bindCloudArrays(py::class_<Cloud>& cloud) {
  cloud
      .def_static(
          "from_array", &fromArray, "coverage"_a, "voxel"_a, "origin"_a = Vec3::Zero().eval(),
          "material"_a = py::none(), "materials"_a = std::vector<std::string>(),
          "A cloud of the voxels of an array.\n\n"
          "coverage: (nx, ny, nz), how much of each voxel is material: shares of 0..1,\n"
          "booleans, or uint8 of 0..255. voxel: edge of a voxel [m]. origin: lowest corner\n"
          "of the array (3,) [m]. material: of the same shape, numbers into `materials`,\n"
          "the names. The cloud's grid is 8 voxels wider on every side. Raises ValueError\n"
          "for other shapes and values, and where no voxel has material.")
      .def_property_readonly(
          "coverage", [](const Cloud& c) { return gridArray(denseCoverage(c), c.size()); },
          "Coverage of every voxel of the grid [1/255]: a new array of uint8 (nx, ny, nz).")
      .def_property_readonly(
          "material", [](const Cloud& c) { return gridArray(denseMaterial(c), c.size()); },
          "Index into `materials` of every voxel: a new array of uint8 (nx, ny, nz).")
      .def_property_readonly(
          "bricks", [](const Cloud& c) { return brickView(c, c.voxels().coverage); },
          "Coverage of the stored bricks [1/255]: (n, 8, 8, 8) [brick, x, y, z], over the cloud's\n"
          "own memory. Clouds do not change, so it cannot be written to.")
      .def_property_readonly(
          "brick_table",
          [](const Cloud& c) {
            return gridView(c.voxels().table.data(), c.bricks(), keeping(c), false);
          },
          "For each 8x8x8 brick of the grid its index in `bricks`, -1 where it is empty, -2 where\n"
          "it is full: int32 (bx, by, bz), over the cloud's own memory.");
}

void bindCloudChanges(py::class_<Cloud>& cloud) {
  using WithoutLock = py::call_guard<Unlocked>;
  cloud
      .def("translated", &Cloud::translated, "shift"_a,
           "The same voxels moved by shift (3,) [m]. Shares them.")
      .def("scaled", &Cloud::scaled, "factor"_a,
           "The same voxels, larger or smaller about the frame's origin. Shares them.")
      .def(
          "resampled", [](const Cloud& c, double voxel) { return resampled(c, voxel); }, "voxel"_a,
          WithoutLock(), "The cloud in voxels of another size [m].")
      .def(
          "cut",
          [](const Cloud& c, const py::object& voxels, const py::object& coverage) {
            const std::vector<VoxelCut> cuts = cutsFrom(voxels, coverage);
            const Unlocked unlocked;
            return cutCloud(c, cuts);
          },
          "voxels"_a, "coverage"_a = py::none(),
          "The cloud after cuts: at most `coverage` (n,) [1/255] remains of voxels (n, 3),\n"
          "nothing where it is not given. Raises IndexError where a voxel is outside the grid.")
      .def(
          "pieces", [](const Cloud& c) { return pieces(c); }, WithoutLock(),
          "The connected parts of the cloud: a list of clouds in its grid.")
      .def(
          "surface", [](const Cloud& c) { return DisplayMesh(c).mesh(); }, WithoutLock(),
          "The surface at a coverage of one half, for viewers: a Mesh.");
}

void bindCloudClass(py::module_& module) {
  py::class_<Cloud> cloud(module, "Cloud",
                          "A body as voxels that each hold how much of them is material.\n\n"
                          "Arrays are indexed [x, y, z]. A cloud does not change; copies share\n"
                          "their voxels.");
  cloud.def_property_readonly("voxel", &Cloud::voxelSize, "Edge of a voxel [m].")
      .def_property_readonly("origin", copied(&Cloud::origin),
                             "Lowest corner of voxel (0, 0, 0), (3,) [m].")
      .def_property_readonly(
          "shape",
          [](const Cloud& c) { return py::make_tuple(c.size()[0], c.size()[1], c.size()[2]); },
          "Voxels along x, y, z.")
      .def_property_readonly("materials", &Cloud::materials,
                             "Names of its materials; empty where there is one.")
      .def_property_readonly(
          "voxels",
          [](const Cloud& c) {
            const auto n = c.counts();
            return n.inside + n.interface;
          },
          "Number of voxels with material.")
      .def_property_readonly("bytes", &Cloud::bytes, "Memory of the voxels.")
      .def("mass_properties", &massOf, "density"_a = 1000.0,
           "MassProperties at a density, or one for each material [kg/m^3].")
      .def(
          "center", [](const Cloud& c, int x, int y, int z) { return c.center(x, y, z); }, "x"_a,
          "y"_a, "z"_a, "Center of a voxel, (3,) [m].")
      .def(
          "save", [](const Cloud& c, const std::filesystem::path& f) { saveCloud(c, f); }, "file"_a,
          py::call_guard<Unlocked>(),
          "Writes a .cloud file, whole or not at all. Raises RuntimeError that names the file.")
      .def_static("load", &loadCloud, "file"_a, py::call_guard<Unlocked>(),
                  "Reads a .cloud file of voxels. Raises RuntimeError that names the file and the\n"
                  "fault: missing, of another kind or version, cut short, damaged.")
      .def("__repr__", [](const Cloud& c) {
        return "Cloud(" + std::to_string(c.size()[0]) + " x " + std::to_string(c.size()[1]) +
               " x " + std::to_string(c.size()[2]) + " voxels of " +
               py::repr(py::float_(c.voxelSize())).cast<std::string>() + " m)";
      });
  bindCloudArrays(cloud);
  bindCloudChanges(cloud);
}

// Meshes by name, or one mesh without a name.
std::vector<NamedMesh> partsOf(const py::object& source) {
  if (py::isinstance<Mesh>(source)) return {{"", source.cast<Mesh>()}};
  std::vector<NamedMesh> parts;
  for (const auto& [name, mesh] : source.cast<py::dict>())
    parts.push_back({name.cast<std::string>(), mesh.cast<Mesh>()});
  return parts;
}

Cloud digitized(const std::vector<NamedMesh>& parts, const DigitizeSettings& settings,
                Backend backend, DigitizeReport& report) {
  if (parts.size() > 1) return digitize(parts, settings, &report);
  const Mesh& mesh = parts.front().mesh;
  if (backend == Backend::Cpu) return digitize(mesh, settings, &report);
  Digitizer digitizer({.backend = backend});
  digitizer.run(mesh, settings);
  report = digitizer.report();
  return digitizer.cloud();
}

py::tuple digitizeMesh(const py::object& source, double voxel, int threads, std::size_t maxBytes,
                       const std::string& backend, const py::object& progress) {
  const std::vector<NamedMesh> parts = partsOf(source);
  if (parts.empty()) throw std::invalid_argument("digitize: no mesh; give at least one");
  const Backend where = program::readBackend(backend);
  Cloud cloud;
  DigitizeReport report;
  runLong(progress, "digitizing", [&](const auto& tell) {
    cloud = digitized(parts, {voxel, maxBytes, threads, tell}, where, report);
  });
  return py::make_tuple(std::move(cloud), report);
}

Cloud digitizeFile(const std::filesystem::path& path, const std::optional<double>& voxel,
                   const py::object& unit, const std::optional<double>& shell,
                   const std::map<std::string, double>& thresholds, int threads,
                   std::size_t maxBytes, const std::string& backend, const py::object& progress) {
  const std::string file = path.string();
  if (voxel && (!(*voxel > 0) || !std::isfinite(*voxel)))
    throw std::invalid_argument("voxel: must be above 0 and finite");
  if (shell && (!(*shell > 0) || !std::isfinite(*shell)))
    throw std::invalid_argument("shell: must be above 0 and finite");
  if (threads < 0) throw std::invalid_argument("threads: must be 0 or more");
  program::CommonOptions options;
  options.maxBytes = maxBytes;
  options.voxel = voxel;
  options.metersPerUnit = unitOf(unit);
  options.shell = shell;
  for (const auto& [name, from] : thresholds)
    program::addThreshold("thresholds", {from, name}, options.thresholds);
  if (!thresholds.empty() && !isVolumeFile(file))
    throw std::invalid_argument("thresholds: is of CT volumes, and '" + file + "' is none");
  options.threads = threads;
  options.backend = program::readBackend(backend);
  Cloud cloud;
  runLong(progress, "digitizing " + file, [&](const auto& tell) {
    options.progress = [&](const std::string&) { return tell; };
    const program::Body body = program::readBody(file, options);
    cloud =
        program::digitizeBody(body, voxel ? *voxel : program::defaultVoxel(body), options).cloud;
  });
  return cloud;
}

void bindDigitize(py::module_& module) {
  py::class_<DigitizeReport>(module, "DigitizeReport", "How well a mesh bounded a volume.")
      .def_readonly("closed", &DigitizeReport::closed, "The repaired surface has no boundary.")
      .def_readonly("bad_columns", &DigitizeReport::badColumns,
                    "Columns in which the surface is not closed.")
      .def_readonly("undecided_voxels", &DigitizeReport::undecidedVoxels,
                    "Voxels that the winding number had to decide.");
  module.def("digitize_mesh", &digitizeMesh, "source"_a, "voxel"_a, "threads"_a, "max_bytes"_a,
             "backend"_a, "progress"_a, "A Cloud and its DigitizeReport; see digitize().");
  module.def("digitize_file", &digitizeFile, "file"_a, "voxel"_a, "unit"_a, "shell"_a,
             "thresholds"_a, "threads"_a, "max_bytes"_a, "backend"_a, "progress"_a,
             "A Cloud of any file that the program reads; see digitize().");
}

using Floats = py::array_t<float, py::array::f_style | py::array::forcecast>;

CtVolume volumeOf(const Floats& values, const Vec3& spacing, const Vec3& origin) {
  if (values.ndim() != 3)
    throw std::invalid_argument("values: give an array of the shape (nx, ny, nz)");
  CtVolume volume;
  for (int k = 0; k < 3; ++k) volume.size[k] = static_cast<int>(values.shape(k));
  volume.spacing = spacing;
  volume.origin = origin;
  volume.values.assign(values.data(), values.data() + values.size());
  return volume;
}

Cloud fromCt(const CtVolume& volume, const py::object& thresholds, double voxel,
             std::size_t maxBytes) {
  std::vector<CtRange> ranges;
  if (py::hasattr(thresholds, "keys")) {
    for (const auto& [name, from] : py::dict(thresholds))
      ranges.push_back({numberOf("thresholds", py::reinterpret_borrow<py::object>(from)),
                        name.cast<std::string>()});
  } else {
    ranges.push_back({numberOf("thresholds", thresholds), "all"});
  }
  std::sort(ranges.begin(), ranges.end(),
            [](const CtRange& a, const CtRange& b) { return a.from < b.from; });
  const Unlocked unlocked;
  return cloudFromCt(volume, ranges, {voxel, maxBytes});
}

void bindVolume(py::module_& module) {
  constexpr std::size_t kMost = std::size_t{4} << 30;
  py::class_<CtVolume, std::shared_ptr<CtVolume>>(
      module, "CtVolume", "A CT scan: values on a grid that increase with density.")
      .def(
          py::init(&volumeOf), "values"_a, "spacing"_a, "origin"_a = Vec3::Zero().eval(),
          "values: (nx, ny, nz), copied. spacing: edges of a cell (3,) [m]. origin: lowest corner\n"
          "(3,) [m].")
      .def_property_readonly(
          "values",
          [](const py::object& self) {
            auto& volume = self.cast<CtVolume&>();
            return gridView(volume.values.data(), volume.size, self, true);
          },
          "Array (nx, ny, nz) of float32 over the volume's own memory, which may be written to.")
      .def_property_readonly("spacing", copied(&CtVolume::spacing), "(3,) [m]")
      .def_property_readonly("origin", copied(&CtVolume::origin), "(3,) [m]");
  module.def(
      "load_volume",
      [](const std::filesystem::path& file, const py::object& unit, double voxel) {
        const double meters = unitOf(unit);
        const Unlocked unlocked;
        return loadVolume(file, {meters, voxel});
      },
      "file"_a, "unit"_a = 1.0, "voxel"_a = 0.0,
      "A CtVolume of an NRRD or MetaImage file. unit: of lengths whose unit the file does not\n"
      "state. voxel: that the values shall become [m]; while they are read, blocks become their\n"
      "mean where that is much wider than the spacing. Raises RuntimeError that names the file.");
  module.def(
      "digitize_volume", &fromCt, "volume"_a, "thresholds"_a, "voxel"_a = 0.0,
      "max_bytes"_a = kMost,
      "A Cloud of a CtVolume.\n\n"
      "thresholds: the value from which on there is material, or a dict of such values by\n"
      "the names of several materials. voxel [m]; 0: the smallest spacing. Raises ValueError\n"
      "where values or thresholds do not fit, or the voxels need more than max_bytes.");
}

}  // namespace

void bindCloud(py::module_& module) {
  bindCloudClass(module);
  bindDigitize(module);
  bindVolume(module);
}

}  // namespace cloudcontact::python
