// Python: triangle meshes.
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;

Mesh meshFrom(const py::object& vertices, const py::object& triangles, const py::object& unit) {
  const Numbers v = rowsOf("vertices", vertices, 3);
  const Integers t = integersOf("triangles", triangles);
  if (!t || t.ndim() != 2 || t.shape(1) != 3)
    throw std::invalid_argument("triangles: give an array of integers of the shape (n, 3)");
  const double meters = unitOf(unit);
  const Unlocked unlocked;
  Mesh mesh;
  mesh.vertices.resize(static_cast<std::size_t>(v.shape(0)));
  mesh.triangles.resize(static_cast<std::size_t>(t.shape(0)));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i] = meters * Eigen::Map<const Vec3>(v.data() + 3 * i);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    mesh.triangles[i] = Eigen::Map<const Eigen::Vector3i>(t.data() + 3 * i);
  validate(mesh);
  return mesh;
}

static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) &&
              sizeof(Eigen::Vector3i) == 3 * sizeof(int));

// A mesh's vectors as an array that may be written to.
template <typename Number, typename Vectors>
py::array sharedRows(const py::object& self, Vectors& vectors) {
  return viewOf(reinterpret_cast<const Number*>(vectors.data()),
                {static_cast<py::ssize_t>(vectors.size()), 3},
                {3 * static_cast<py::ssize_t>(sizeof(Number)), sizeof(Number)}, self, true);
}

void bindRepair(py::module_& module) {
  py::class_<MeshReport>(module, "MeshReport", "What `inspect` finds, equal vertices welded.")
      .def_readonly("open_edges", &MeshReport::openEdges, "Edges of a single triangle.")
      .def_readonly("overused_edges", &MeshReport::overusedEdges, "Of three triangles or more.")
      .def_readonly("degenerate_triangles", &MeshReport::degenerateTriangles,
                    "Triangles that are a line or a point.")
      .def_readonly("volume", &MeshReport::volume, "Signed [m^3].")
      .def_readonly("area", &MeshReport::area, "[m^2]")
      .def_property_readonly("closed", &MeshReport::closed, "No edge is open or overused.");
  using WithoutLock = py::call_guard<Unlocked>;
  module.def(
      "inspect", [](const Mesh& mesh) { return cloudcontact::inspect(mesh); }, "mesh"_a,
      WithoutLock(), "A MeshReport of a mesh.");
  module.def(
      "mended", [](const Mesh& mesh, double by) { return cloudcontact::mended(mesh, by); },
      "mesh"_a, "tolerance"_a = 0.0, WithoutLock(),
      "The mesh repaired: vertices within `tolerance` [m] welded, triangles turned outward.");
  module.def(
      "shell", [](const Mesh& mesh, double by) { return cloudcontact::shell(mesh, by); }, "mesh"_a,
      "thickness"_a, WithoutLock(), "A closed shell behind a sheet, `thickness` [m] thick.");
  module.def(
      "is_sheet", [](const Mesh& mesh) { return cloudcontact::isSheet(mesh); }, "mesh"_a,
      WithoutLock(), "Whether so much of the surface is open that it bounds no volume.");
}

}  // namespace

void bindMesh(py::module_& module) {
  py::class_<Mesh, std::shared_ptr<Mesh>>(
      module, "Mesh", "Triangles over shared vertices, counter-clockwise seen from outside.")
      .def(
          py::init(&meshFrom), "vertices"_a, "triangles"_a, "unit"_a = 1.0,
          "vertices: (n, 3), in `unit`: meters each, or \"mm\", \"cm\", \"in\", \"m\". triangles:\n"
          "(m, 3), indices of vertices. Both are copied. Raises ValueError for other shapes, an\n"
          "index without a vertex, and numbers that are not finite.")
      .def_property_readonly(
          "vertices",
          [](const py::object& self) {
            return sharedRows<double>(self, self.cast<Mesh&>().vertices);
          },
          "Array (n, 3) [m] over the mesh's own memory: what is written to it moves the vertices.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            return sharedRows<int>(self, self.cast<Mesh&>().triangles);
          },
          "Array (m, 3) of int32 over the mesh's own memory.")
      .def(
          "scaled", [](const Mesh& mesh, const Vec3& by) { return mesh.scaled(by); }, "factor"_a,
          "A mesh with every vertex multiplied by factor (3,).")
      .def(
          "suggested_voxel", [](const Mesh& mesh) { return suggestedVoxel(mesh); },
          "The voxel that it gets where none is stated [m]: a hundredth of the diagonal of its\n"
          "bounds, down to half of that for threads and thin walls.")
      .def("__repr__", [](const Mesh& mesh) {
        return "Mesh(" + std::to_string(mesh.vertices.size()) + " vertices, " +
               std::to_string(mesh.triangles.size()) + " triangles)";
      });
  module.def(
      "load_mesh",
      [](const std::filesystem::path& file, const py::object& unit) {
        const double meters = unitOf(unit);
        const Unlocked unlocked;
        return loadMesh(file, meters);
      },
      "file"_a, "unit"_a = 1.0,
      "The meshes of an STL, OBJ, PLY, glTF ... file as one. unit: of the file, as of Mesh.\n"
      "Raises RuntimeError that names the file and the fault.");
  module.def(
      "load_mesh_parts",
      [](const std::filesystem::path& file, const py::object& unit) {
        const double meters = unitOf(unit);
        std::vector<NamedMesh> parts;
        {
          const Unlocked unlocked;
          parts = loadMeshParts(file, meters);
        }
        py::dict named;
        for (NamedMesh& part : parts) named[py::str(part.name)] = std::move(part.mesh);
        return named;
      },
      "file"_a, "unit"_a = 1.0, "The objects or groups of a file: a dict of meshes by name.");
  bindRepair(module);
}

}  // namespace cloudcontact::python
