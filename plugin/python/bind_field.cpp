// Python: surface fields.
#include <cloudcontact/field/field_file.h>
#include <cloudcontact/field/surface_field.h>

#include <limits>

#include "field/field_data.h"
#include "python/bindings.h"
#include "python/long_work.h"
#include "python/numpy_views.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using FieldPtr = std::shared_ptr<const SurfaceField>;
// pybind11 holds no pointers to const; no function here changes a field.
using Held = std::shared_ptr<SurfaceField>;

Held held(FieldPtr field) {
  return std::const_pointer_cast<SurfaceField>(std::move(field));
}

Held buildField(const Cloud& cloud, bool renewable, int threads, const py::object& progress) {
  FieldPtr field;
  runLong(progress, "finding the surface", [&](const auto& tell) {
    FieldSettings settings;
    settings.threads = threads;
    settings.progress = tell;
    settings.renewable = renewable;
    field = SurfaceField::build(cloud, settings);
  });
  return held(field);
}

Held renewField(const Held& before, const Cloud& after, int threads, const py::object& progress) {
  FieldPtr field;
  runLong(progress, "renewing the surface", [&](const auto& tell) {
    FieldSettings settings;
    settings.threads = threads;
    settings.progress = tell;
    field = renewed(before, after, settings);
  });
  return held(field);
}

py::tuple pointsAt(const SurfaceField& field, const py::object& points) {
  const Numbers rows = rowsOf("points", points, 3);
  py::array_t<double> depths(rows.shape(0));
  py::array_t<double> normals({rows.shape(0), py::ssize_t{3}});
  double* depth = depths.mutable_data();
  double* normal = normals.mutable_data();
  {
    const Unlocked unlocked;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      const auto point = field.at(Eigen::Map<const Vec3>(rows.data() + 3 * i));
      depth[i] = point ? point->depth : kNone;
      Eigen::Map<Vec3>(normal + 3 * i) = point ? point->normal : Vec3::Constant(kNone).eval();
    }
  }
  return py::make_tuple(std::move(depths), std::move(normals));
}

// A column of the samples over the field's own memory.
py::array sampleColumn(const Held& field, const LargeVector<float>& numbers) {
  return viewOf(numbers.data(), {static_cast<py::ssize_t>(numbers.size())}, {sizeof(float)},
                keeping(field));
}

py::dict samplesOf(const Held& field) {
  const SampleColumns& s = field->data().samples().levels[0].samples;
  return py::dict("x"_a = sampleColumn(field, s.x), "y"_a = sampleColumn(field, s.y),
                  "z"_a = sampleColumn(field, s.z), "nx"_a = sampleColumn(field, s.nx),
                  "ny"_a = sampleColumn(field, s.ny), "nz"_a = sampleColumn(field, s.nz),
                  "area"_a = sampleColumn(field, s.area), "width"_a = sampleColumn(field, s.width));
}

void bindQueries(py::class_<SurfaceField, Held>& field) {
  field
      .def(
          "at", &pointsAt, "points"_a,
          "Depths and normals at points (n, 3) of the body's frame [m]: arrays (n,) [m], positive\n"
          "inside, and (n, 3), outward. NaN where they are more than about two\n"
          "voxels outside.")
      .def("samples", &samplesOf,
           "The pieces of the surface that other bodies are searched with: a dict of float32\n"
           "arrays (n,) over the field's own memory, which cannot be written to. x, y, z:\n"
           "positions from the grid's corner [voxels]; nx, ny, nz: outward normals; area\n"
           "[voxels^2]; width [voxels].")
      .def_property_readonly(
          "bounds",
          [](const SurfaceField& f) {
            Eigen::Matrix<double, 2, 3, Eigen::RowMajor> corners;
            corners << f.bounds().min().transpose(), f.bounds().max().transpose();
            return corners;
          },
          "Lowest and highest corner of the surface, (2, 3) [m].");
}

}  // namespace

void bindField(py::module_& module) {
  py::class_<SurfaceField, Held> field(
      module, "SurfaceField",
      "The surface of a cloud, ready for contacts. Built once, shared by all bodies of a shape.");
  field
      .def(py::init(&buildField), "cloud"_a, "renewable"_a = false, "threads"_a = 0,
           "progress"_a = py::none(),
           "renewable: keeps what renewed() starts from, for bodies that will be cut; takes\n"
           "several times the memory. threads: 0 for all cores. progress: see digitize(). Raises\n"
           "ValueError where the cloud is empty or has no surface.")
      .def("renewed", &renewField, "after"_a, "threads"_a = 0, "progress"_a = py::none(),
           "The field of a cloud in the same grid, as Cloud.cut() returns it. Computes only what\n"
           "the change affects where this field is renewable.")
      .def(
          "scaled", [](const SurfaceField& f, double by) { return held(scaled(f, by)); },
          "factor"_a, "The field of the scaled cloud, by copying.")
      .def(
          "save",
          [](const SurfaceField& f, const std::filesystem::path& file) { saveField(f, file); },
          "file"_a, py::call_guard<Unlocked>(),
          "Writes a .field file, whole or not at all. Raises RuntimeError that names the file.")
      .def_static(
          "load", [](const std::filesystem::path& file) { return held(loadField(file)); }, "file"_a,
          py::call_guard<Unlocked>(),
          "Reads a .field file. Raises RuntimeError that names the file and the fault.")
      .def_property_readonly("cloud", &SurfaceField::cloud, py::return_value_policy::copy,
                             "Its Cloud.")
      .def_property_readonly("band_voxels", &SurfaceField::bandVoxels,
                             "Number of voxels that know the surface.")
      .def_property_readonly("sample_count", &SurfaceField::sampleCount, "Length of samples().")
      .def_property_readonly("bytes", &SurfaceField::bytes, "Memory.")
      .def_property_readonly("hash", &SurfaceField::hash, "Equal for equal fields, everywhere.")
      .def("__repr__", [](const SurfaceField& f) {
        return "SurfaceField(" + std::to_string(f.bandVoxels()) + " voxels, " +
               std::to_string(f.sampleCount()) + " samples)";
      });
  bindQueries(field);
}

}  // namespace cloudcontact::python
