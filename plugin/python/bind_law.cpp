// Python: force laws, tissues and solids.
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/workpiece/cloud_solid.h>

#include "python/bindings.h"
#include "python/numpy_views.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;

// Makes a law or a solid of its numbers, and checks it.
template <typename Kind, typename... Numbers>
auto made() {
  return py::init([](const Numbers&... numbers) {
    const Kind kind{numbers...};
    if constexpr (std::is_constructible_v<Law, Kind>)
      validate(Law(kind));
    else
      validate(PlacedSolid{kind, {}});
    return kind;
  });
}

void bindLaws(py::module_& module) {
  py::class_<KelvinVoigt>(module, "KelvinVoigt",
                          "F = k d + c v, the paper's (3): one spring a pair.")
      .def(made<KelvinVoigt, double, double>(), "stiffness"_a, "damping"_a = 0.0,
           "stiffness: k [N/m]. damping: c [N s/m].")
      .def_readonly("stiffness", &KelvinVoigt::stiffness, "k [N/m]")
      .def_readonly("damping", &KelvinVoigt::damping, "c [N s/m]");
  py::class_<Foundation>(module, "Foundation", "F = k d + c v for each area of the contact.")
      .def(made<Foundation, double, double>(), "stiffness"_a, "damping"_a = 0.0,
           "stiffness: k [N/m^3]. damping: c [N s/m^3].")
      .def_readonly("stiffness", &Foundation::stiffness, "k [N/m^3]")
      .def_readonly("damping", &Foundation::damping, "c [N s/m^3]");
  py::class_<Rigid>(module, "Rigid", "Bodies do not give at all; a solver keeps them apart.")
      .def(py::init<>());
  py::class_<Maxwell>(module, "Maxwell", "A spring and a dashpot in series. For worlds.")
      .def(made<Maxwell, double, double>(), "stiffness"_a, "damping"_a,
           "stiffness: k [N/m]. damping: c [N s/m].")
      .def_readonly("stiffness", &Maxwell::stiffness, "k [N/m]")
      .def_readonly("damping", &Maxwell::damping, "c [N s/m]");
  py::class_<StandardLinearSolid>(module, "StandardLinearSolid",
                                  "A spring beside a spring and a dashpot in series. For worlds.")
      .def(made<StandardLinearSolid, double, double, double>(), "stiffness"_a, "branch_stiffness"_a,
           "branch_damping"_a,
           "stiffness: k [N/m]. branch_stiffness: k1 [N/m]. branch_damping: c1 [N s/m].")
      .def_readonly("stiffness", &StandardLinearSolid::stiffness, "k [N/m]")
      .def_readonly("branch_stiffness", &StandardLinearSolid::branchStiffness, "k1 [N/m]")
      .def_readonly("branch_damping", &StandardLinearSolid::branchDamping, "c1 [N s/m]");
}

void bindTissues(py::module_& module) {
  py::class_<Tissue>(module, "Tissue", "What a part of a body is made of.")
      .def(py::init([](std::string name, double stiffness, double damping, double hardness,
                       double density, double elasticity) {
             Tissue tissue{std::move(name), stiffness, damping, hardness, density, elasticity};
             validate(TissueTable{tissue});
             return tissue;
           }),
           "name"_a, "stiffness"_a, "damping"_a = 0.0, "hardness"_a = 0.0, "density"_a = 1000.0,
           "elasticity"_a = 0.0,
           "stiffness: k of a contact with this tissue alone [N/m]. damping: c [N s/m].\n"
           "hardness: resistance to cutting [Pa]. density [kg/m^3]. elasticity: Young's modulus\n"
           "of a body that deforms [Pa]; 0: not known. Raises ValueError that names the field.")
      .def_readonly("name", &Tissue::name)
      .def_readonly("stiffness", &Tissue::stiffness, "[N/m]")
      .def_readonly("damping", &Tissue::damping, "[N s/m]")
      .def_readonly("hardness", &Tissue::hardness, "[Pa]")
      .def_readonly("density", &Tissue::density, "[kg/m^3]")
      .def_readonly("elasticity", &Tissue::elasticity, "[Pa]")
      .def("__eq__", [](const Tissue& a, const Tissue& b) { return a == b; })
      .def("__repr__", [](const Tissue& t) { return "Tissue('" + t.name + "')"; });
  module.def("dental_tissues", &dentalTissues, "enamel"_a = 2e4,
             "A list of tissues: enamel, dentin, pulp, caries. enamel: its stiffness [N/m], which\n"
             "scales those of the others.");
}

void bindRoundSolids(py::module_& module) {
  py::class_<Sphere>(module, "Sphere", "A ball about the origin.")
      .def(made<Sphere, double>(), "radius"_a, "radius [m].")
      .def_readonly("radius", &Sphere::radius, "[m]");
  py::class_<Ellipsoid>(module, "Ellipsoid", "An ellipsoid about the origin.")
      .def(made<Ellipsoid, Vec3>(), "semi_axes"_a, "semi_axes: along x, y, z, (3,) [m].")
      .def_property_readonly("semi_axes", copied(&Ellipsoid::semiAxes), "[m]");
  py::class_<Capsule>(module, "Capsule", "All within `radius` of a segment on the axis z.")
      .def(made<Capsule, double, double>(), "radius"_a, "half_height"_a,
           "radius [m]. half_height: half the length of the segment [m].")
      .def_readonly("radius", &Capsule::radius, "[m]")
      .def_readonly("half_height", &Capsule::halfHeight, "[m]");
  py::class_<Cylinder>(module, "Cylinder", "A cylinder about the axis z.")
      .def(made<Cylinder, double, double>(), "radius"_a, "half_height"_a,
           "radius [m]. half_height [m].")
      .def_readonly("radius", &Cylinder::radius, "[m]")
      .def_readonly("half_height", &Cylinder::halfHeight, "[m]");
  py::class_<Cone>(module, "Cone", "A cone about the axis z, its tip at +half_height.")
      .def(made<Cone, double, double>(), "radius"_a, "half_height"_a,
           "radius of its base at -half_height [m]. half_height [m].")
      .def_readonly("radius", &Cone::radius, "[m]")
      .def_readonly("half_height", &Cone::halfHeight, "[m]");
}

void bindSolids(py::module_& module) {
  py::class_<HalfSpace>(module, "HalfSpace", "Material where normal . x < offset.")
      .def(py::init([](const Vec3& normal, double offset) {
             if (!normal.allFinite() || normal.norm() < 1e-12 || !std::isfinite(offset))
               throw std::invalid_argument(
                   "half-space: give a normal that is not 0, and finite "
                   "numbers");
             return HalfSpace{normal.normalized(), offset};
           }),
           "normal"_a = Vec3::UnitZ().eval(), "offset"_a = 0.0,
           "normal: outward, (3,), which is normalized. offset [m].")
      .def_property_readonly("normal", copied(&HalfSpace::normal), "(3,)")
      .def_readonly("offset", &HalfSpace::offset, "[m]")
      .def(py::pickle([](const HalfSpace& h) { return py::make_tuple(h.normal, h.offset); },
                      [](const py::tuple& parts) {
                        return HalfSpace{parts[0].cast<Vec3>(), parts[1].cast<double>()};
                      }));
  py::class_<Box>(module, "Box", "A box about the origin.")
      .def(made<Box, Vec3>(), "half_extents"_a,
           "half_extents: half its edges along x, y, z, (3,) [m].")
      .def_property_readonly("half_extents", copied(&Box::halfExtents), "[m]");
  bindRoundSolids(module);
  py::class_<PlacedSolid>(module, "PlacedSolid", "A solid, or the matter of a Cloud, at a place.")
      .def(py::init([](const py::object& solid, const py::object& place) {
             return PlacedSolid{solidOf("solid", solid), poseOf("place", place)};
           }),
           "solid"_a, "place"_a = py::none(),
           "solid: Sphere, Box, ... or a Cloud. place: a pose in its owner's frame.")
      .def(
          "depth",
          [](const PlacedSolid& solid, const py::object& points) {
            const Numbers rows = rowsOf("points", points, 3);
            py::array_t<double> out(rows.shape(0));
            for (py::ssize_t i = 0; i < rows.shape(0); ++i)
              out.mutable_at(i) = depthOf(solid, Vec3(rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)));
            return out;
          },
          "points"_a, "Depths of points (n, 3) of the owner's frame [m], positive inside: (n,).");
}

}  // namespace

void bindLaw(py::module_& module) {
  bindLaws(module);
  bindTissues(module);
  bindSolids(module);
}

}  // namespace cloudcontact::python
