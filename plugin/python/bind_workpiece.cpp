// Python: the paper's workpiece: base vectors, collisions with a tool, cutting.
#include <cloudcontact/device/device_workpiece.h>
#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/workpiece/collision_finder.h>
#include <cloudcontact/workpiece/cutter.h>

#include <sstream>

#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/turns.h"
#include "python/unlocked.h"
#include "python/voxel_lists.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using VectorsPtr = std::shared_ptr<BaseVectorField>;

// What reads a workpiece while no other thread cuts it.
template <typename Value>
auto inTurn(Value (BaseVectorField::*read)() const) {
  return [read](const BaseVectorField& field) {
    const Turn turn(&field);
    const Unlocked unlocked;
    return std::decay_t<Value>((field.*read)());
  };
}

std::vector<CuttingPart> partsFrom(const py::object& parts) {
  std::vector<CuttingPart> list;
  for (const auto& [area, ability] : parts.cast<std::vector<std::pair<py::object, double>>>())
    list.push_back({placedSolidOf("parts", area), abilityOf(ability)});
  return list;
}

Detection detectionOf(const py::object& area, const std::string& membership, bool hardness,
                      double ability, const py::object& parts, const std::string& depth) {
  Detection tool;
  tool.area = placedSolidOf("area", area);
  validate(tool.area);
  if (membership != "shared" && membership != "whole")
    throw std::invalid_argument("membership: '" + membership +
                                "' is not known; give shared or "
                                "whole");
  tool.membership = membership == "shared" ? Membership::Shared : Membership::Whole;
  tool.hardness = hardness;
  tool.ability = abilityOf(ability);
  if (!parts.is_none()) tool.parts = partsFrom(parts);
  if (depth != "tip" && depth != "nearest")
    throw std::invalid_argument("depth: '" + depth + "' is not known; give tip or nearest");
  tool.depth = depth == "tip" ? DepthTo::Tip : DepthTo::Nearest;
  return tool;
}

WindowSettings windowOf(double voxel, const py::object& window, const py::object& representative,
                        bool smooth) {
  WindowSettings settings = sphereWindow(voxel);
  if (!window.is_none()) {
    settings.area = placedSolidOf("window", window);
    settings.weight = smooth ? WindowWeight::Smooth : WindowWeight::Even;
  }
  if (!representative.is_none())
    settings.representative = vectorOf("representative", representative);
  return settings;
}

VectorsPtr makeVectors(const Cloud& cloud, const TissueTable& tissues, const py::object& window,
                       const py::object& representative, bool smooth) {
  const WindowSettings settings = windowOf(cloud.voxelSize(), window, representative, smooth);
  const Unlocked unlocked;
  return std::make_shared<BaseVectorField>(cloud, tissues, settings);
}

py::tuple vectorsAt(const BaseVectorField& field, const py::object& voxels) {
  const std::vector<VoxelIndex> list = voxelsFrom(voxels);
  const Turn turn(&field);
  std::vector<Vec3> vectors;
  py::array_t<double> fractions(static_cast<py::ssize_t>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const BaseVector v = field.at(list[i]);
    vectors.push_back(v.toRepresentative);
    fractions.mutable_data()[i] = v.fraction;
  }
  return py::make_tuple(arrayOf(vectors), std::move(fractions));
}

py::array coverageAt(const BaseVectorField& field, const py::object& voxels) {
  const std::vector<VoxelIndex> list = voxelsFrom(voxels);
  const Turn turn(&field);
  py::array_t<std::uint8_t> coverage(static_cast<py::ssize_t>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i)
    coverage.mutable_data()[i] = field.coverage(list[i]);
  return coverage;
}

void bindVectors(py::module_& module) {
  py::class_<BaseVectorField, VectorsPtr> field(
      module, "BaseVectorField",
      "A workpiece that may be cut: of each voxel the base vector Gr - Gc (4) of its window.");
  field
      .def(py::init(&makeVectors), "cloud"_a, "tissues"_a, "window"_a = py::none(),
           "representative"_a = py::none(), "smooth"_a = true,
           "tissues: a list, one for each of the cloud's materials, or one for all. window: C\n"
           "around a voxel whose center is the origin, a solid; none: a smooth ball of 2.5\n"
           "voxels. representative: Gr (3,) [m]. smooth: the window weighs its middle more.\n"
           "Raises ValueError where the cloud is empty or tissues or window do not fit.")
      .def_property_readonly("voxel", &BaseVectorField::voxelSize, "[m]")
      .def_property_readonly("origin", copied(&BaseVectorField::origin),
                             "Lowest corner of voxel (0, 0, 0), (3,) [m].")
      .def_property_readonly(
          "shape",
          [](const BaseVectorField& f) {
            return py::make_tuple(f.size()[0], f.size()[1], f.size()[2]);
          },
          "Voxels along x, y, z.")
      .def_property_readonly("tissues", &BaseVectorField::tissues, "A list of Tissue.")
      .def(
          "at", &vectorsAt, "voxels"_a,
          "Base vectors and fractions of voxels (n, 3): (n, 3) [m], without the hardness of (5'),\n"
          "and the share of each window that is material (n,).")
      .def("coverage", &coverageAt, "voxels"_a, "Of voxels (n, 3): uint8 (n,) [1/255].")
      .def("cloud", inTurn(&BaseVectorField::cloud), "The voxels as they are now: a Cloud.")
      .def("mass_properties", inTurn(&BaseVectorField::mass),
           "By the tissues' densities, as it is now.")
      .def_property_readonly("hash", inTurn(&BaseVectorField::hash), "Equal for equal contents.")
      .def_property_readonly("bytes", inTurn(&BaseVectorField::bytes), "Memory.");
  field
      .def(
          "cut",
          [](BaseVectorField& f, const py::object& voxels, const py::object& coverage) {
            const std::vector<VoxelCut> cuts = cutsFrom(voxels, coverage);
            const Turn turn(&f);
            const Unlocked unlocked;
            return f.cut(cuts);
          },
          "voxels"_a, "coverage"_a = py::none(),
          "Removes material: at most `coverage` (n,) [1/255] remains of voxels (n, 3), nothing\n"
          "where it is not given. Returns how many changed. Raises IndexError where a voxel is\n"
          "outside the grid, before any change.")
      .def(
          "cut_area",
          [](BaseVectorField& f, const py::object& area, const py::object& pose) {
            const PlacedSolid solid = placedSolidOf("area", area);
            const Pose tool = poseOf("pose", pose);
            const Turn turn(&f);
            const Unlocked unlocked;
            return f.cut(cutsOf(f, solid, tool));
          },
          "area"_a, "pose"_a = py::none(),
          "Removes what lies in a solid, whose frame is at `pose` in the workpiece's. Returns how\n"
          "many voxels changed.")
      .def(
          "reserve",
          [](BaseVectorField& f) {
            const Turn turn(&f);
            f.reserve();
          },
          "Takes all memory that cuts can ever need, for loops that must not wait.");
}

py::array voxelsOf(const std::shared_ptr<Collision>& collision) {
  const py::dtype type = recordType({{"voxel", "(3,)i4", offsetOf(&CollisionVoxel::voxel)},
                                     {"share", "f4", offsetOf(&CollisionVoxel::share)},
                                     {"ability", "f4", offsetOf(&CollisionVoxel::ability)},
                                     {"tissue", "u1", offsetOf(&CollisionVoxel::tissue)}},
                                    sizeof(CollisionVoxel));
  return recordsOf(type, collision->voxels, keeping(collision));
}

void bindCollision(py::module_& module) {
  py::class_<Collision, std::shared_ptr<Collision>>(
      module, "Collision", "The collision voxels B of a tool, and their sums. False without any.")
      .def_property_readonly("voxels", &voxelsOf,
                             "B, a structured array (n,): voxel (3,), share inside D, ability of\n"
                             "the tool there, tissue: index into the workpiece's.")
      .def_readonly("count", &Collision::count, "n: the sum of the shares.")
      .def_property_readonly(
          "mean", copied(&Collision::mean),
          "F: mean base vector (5), (5'), from the workpiece to the tool (3,) [m].")
      .def_property_readonly("normal", &Collision::normal, "Its direction (3,).")
      .def_readonly("stiffness", &Collision::stiffness, "k (1) [N/m]")
      .def_readonly("damping", &Collision::damping, "c (2) [N s/m]")
      .def_property_readonly("center", copied(&Collision::center),
                             "Of the touched surface (3,) [m].")
      .def_readonly("depth", &Collision::depth, "d of the tool where it is now [m].")
      .def_readonly("volume", &Collision::volume, "Of material in D [m^3].")
      .def("__bool__", [](const Collision& c) { return !c.empty(); });
  py::class_<CollisionFinder>(module, "CollisionFinder",
                              "Finds collisions of a tool with a workpiece.")
      .def(py::init<int>(), "threads"_a = 1, "Results do not depend on the number of threads.")
      .def(
          "find",
          [](CollisionFinder& finder, const BaseVectorField& workpiece, const Detection& tool,
             const py::object& toolPose, const py::object& workpiecePose) {
            const Pose at = poseOf("tool_pose", toolPose);
            const Pose of = poseOf("workpiece_pose", workpiecePose);
            const Turn turn(&finder), ofWorkpiece(&workpiece);
            const Unlocked unlocked;
            return std::make_shared<Collision>(finder.find(workpiece, of, tool, at));
          },
          "workpiece"_a, "tool"_a, "tool_pose"_a, "workpiece_pose"_a = py::none(),
          "The Collision, in the world's frame. Raises ValueError where a pose is not finite.");
}

void bindCutting(py::module_& module) {
  py::class_<Cutter>(module, "Cutter", "How a tool cuts, by Archard's law of abrasion.")
      .def(py::init([](double hardness, double efficiency, double edgeSpeed, int mostVoxels,
                       bool keepsOutside) {
             const Cutter cutter{hardness, efficiency, edgeSpeed, mostVoxels, keepsOutside};
             const CuttingProcess check(cutter);
             return cutter;
           }),
           "hardness"_a = Cutter{}.hardness, "efficiency"_a = Cutter{}.efficiency,
           "edge_speed"_a = 0.0, "most_voxels"_a = Cutter{}.mostVoxels, "keeps_outside"_a = false,
           "hardness: of the tool [Pa]. efficiency: share of the plowed volume that comes off.\n"
           "edge_speed: of the edges by the spindle [m/s]. most_voxels: that a step changes.\n"
           "keeps_outside: a groove is no wider than its tool.")
      .def_readonly("hardness", &Cutter::hardness, "[Pa]")
      .def_readonly("efficiency", &Cutter::efficiency)
      .def_readonly("edge_speed", &Cutter::edgeSpeed, "[m/s]");
  py::class_<CuttingProcess>(module, "CuttingProcess", "Removes material from collisions.")
      .def(py::init<const Cutter&>(), "cutter"_a)
      .def(
          "step",
          [](CuttingProcess& process, BaseVectorField& workpiece, const Collision& collision,
             double force, double speed, double seconds) {
            const Turn turn(&process), ofWorkpiece(&workpiece);
            const auto cut = process.step(workpiece, collision, force, speed, seconds);
            return py::make_tuple(cut.voxels, cut.volume);
          },
          "workpiece"_a, "collision"_a, "force"_a, "speed"_a, "seconds"_a,
          "Cuts for `seconds` under `force` [N], the tool sliding at `speed` [m/s]. Returns how\n"
          "many voxels changed and the volume [m^3].");
}

}  // namespace

void bindWorkpiece(py::module_& module) {
  bindVectors(module);
  py::class_<Detection>(module, "Detection",
                        "How a tool detects: its area D, and what it cuts with.")
      .def(py::init(&detectionOf), "area"_a, "membership"_a = "shared", "hardness"_a = true,
           "ability"_a = 1.0, "parts"_a = py::none(), "depth"_a = "tip",
           "area: D, a solid or Cloud in the tool's frame. membership: \"shared\" (a voxel counts\n"
           "by its share inside D) or \"whole\" (by its center). hardness: h in (5'). ability: to\n"
           "cut, outside `parts`, pairs (solid, ability). depth: to the \"tip\" of D or its\n"
           "\"nearest\" surface.");
  bindCollision(module);
  bindCutting(module);
}

}  // namespace cloudcontact::python
