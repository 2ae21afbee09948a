// Python: the haptic loop.
#include <cloudcontact/workpiece/haptic_loop.h>

#include <algorithm>
#include <cmath>

#include "python/bindings.h"
#include "python/long_work.h"
#include "python/numpy_views.h"
#include "python/turns.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;

HapticSettings settingsOf(const Detection& tool, double step, double handStiffness,
                          double handDamping, double release, double mostForce,
                          const std::optional<Law>& law, bool perTissue,
                          const std::optional<Cutter>& cutter) {
  HapticSettings settings;
  settings.tool = tool;
  settings.step = step;
  settings.handStiffness = handStiffness;
  settings.handDamping = handDamping;
  settings.release = release;
  settings.mostForce = mostForce;
  settings.law = law;
  settings.perTissue = perTissue;
  settings.cutter = cutter;
  return settings;
}

// A loop with the workpiece that it may cut, which outlives it.
struct OwnedLoop {
  BaseVectorField& workpiece;
  HapticLoop loop;

  HapticOutput tick(const HapticInput& input) {
    const Turn turn(this), ofWorkpiece(&workpiece);
    return loop.tick(input);
  }
};

HapticInput inputOf(const Pose& hand, const Vec3& velocity) {
  return {hand, velocity};
}

// What a run of ticks gives, a row a tick.
struct TickColumns {
  py::array_t<double> force, torque, tool, depth, cut;
  explicit TickColumns(py::ssize_t n)
      : force({n, py::ssize_t{3}}),
        torque({n, py::ssize_t{3}}),
        tool({n, py::ssize_t{3}}),
        depth(n),
        cut(n) {}
};

py::dict runTicks(OwnedLoop& loop, const py::object& hand, const py::object& velocity,
                  const py::object& progress) {
  const std::vector<Pose> poses = posesOf("hand", hand);
  const auto n = static_cast<py::ssize_t>(poses.size());
  Numbers speeds;
  if (!velocity.is_none()) speeds = rowsOf("velocity", velocity, 3);
  if (!std::all_of(speeds.data(), speeds.data() + speeds.size(),
                   [](double v) { return std::isfinite(v); }))
    throw std::invalid_argument("velocity: not finite; give finite numbers");
  if (!velocity.is_none() && speeds.shape(0) != n)
    throw std::invalid_argument("velocity: give as many rows as hand has");
  TickColumns out(n);
  double* const columns[] = {out.force.mutable_data(), out.torque.mutable_data(),
                             out.tool.mutable_data()};
  double *depth = out.depth.mutable_data(), *cut = out.cut.mutable_data();
  Pacer pacer(progress, "haptic loop");
  {
    const Unlocked unlocked;
    for (py::ssize_t i = 0; i < n; ++i) {
      const Vec3 v = velocity.is_none() ? Vec3::Zero().eval()
                                        : Vec3(Eigen::Map<const Vec3>(speeds.data() + 3 * i));
      const HapticOutput now = loop.tick(inputOf(poses[static_cast<std::size_t>(i)], v));
      Eigen::Map<Vec3>(columns[0] + 3 * i) = now.onHand.force;
      Eigen::Map<Vec3>(columns[1] + 3 * i) = now.onHand.torque;
      Eigen::Map<Vec3>(columns[2] + 3 * i) = now.tool.position;
      depth[i] = now.depth;
      cut[i] = now.cutVolume;
      pacer.report(double(i + 1) / double(n));
    }
  }
  pacer.finish();
  return py::dict("force"_a = out.force, "torque"_a = out.torque, "tool"_a = out.tool,
                  "depth"_a = out.depth, "cut_volume"_a = out.cut);
}

void bindOutput(py::module_& module) {
  py::class_<HapticOutput>(module, "HapticOutput", "Of a tick.")
      .def_property_readonly(
          "force", [](const HapticOutput& o) { return o.onHand.force; }, "On the hand (3,) [N].")
      .def_property_readonly(
          "torque", [](const HapticOutput& o) { return o.onHand.torque; },
          "About the hand's position (3,) [N m].")
      .def_property_readonly("tool", copied(&HapticOutput::tool),
                             "Pose of the tool, never deeper than its embedding depth.")
      .def_readonly("depth", &HapticOutput::depth, "d [m]")
      .def_readonly("stiffness", &HapticOutput::stiffness, "k of (1) [N/m]")
      .def_readonly("cut_voxels", &HapticOutput::cutVoxels, "In this tick.")
      .def_readonly("cut_volume", &HapticOutput::cutVolume, "In this tick [m^3].")
      .def_readonly("energy", &HapticOutput::energy, "Net work of the hand since the start [J].")
      .def_readonly("least_energy", &HapticOutput::leastEnergy, "Its minimum [J].")
      .def_readonly("withheld", &HapticOutput::withheld,
                    "Of the force, so that the energy stays above zero [N].");
}

}  // namespace

void bindHaptics(py::module_& module) {
  bindOutput(module);
  const HapticSettings usual;
  py::class_<OwnedLoop>(
      module, "HapticLoop",
      "Pose of the hand in, force on the hand out, 1,000 times a second or more. The tool may cut\n"
      "the workpiece, which changes.")
      .def(py::init([](BaseVectorField& workpiece, const Detection& tool, const py::object& place,
                       double step, double handStiffness, double handDamping, double release,
                       double mostForce, const std::optional<Law>& law, bool perTissue,
                       const std::optional<Cutter>& cutter) {
             const Turn turn(&workpiece);
             return std::unique_ptr<OwnedLoop>(new OwnedLoop{
                 workpiece, HapticLoop(workpiece, poseOf("workpiece_pose", place),
                                       settingsOf(tool, step, handStiffness, handDamping, release,
                                                  mostForce, law, perTissue, cutter))});
           }),
           py::keep_alive<1, 2>(), "workpiece"_a, "tool"_a, "workpiece_pose"_a = py::none(),
           py::kw_only(), "step"_a = usual.step, "hand_stiffness"_a = usual.handStiffness,
           "hand_damping"_a = usual.handDamping, "release"_a = usual.release,
           "most_force"_a = usual.mostForce, "law"_a = py::none(), "per_tissue"_a = false,
           "cutter"_a = py::none(),
           "step: time between ticks [s]. hand_stiffness: of the spring between hand and tool\n"
           "[N/m]. hand_damping [N s/m]. release: time constant of the force's decay where\n"
           "material goes [s]. most_force [N]. law: in place of Kelvin-Voigt with the tissues' k\n"
           "and c. per_tissue: its values are multiples of those. cutter: none only touches.\n"
           "Raises ValueError that names the setting.")
      .def(
          "tick",
          [](OwnedLoop& loop, const py::object& hand, const py::object& velocity) {
            const Pose pose = poseOf("hand", hand);
            const Vec3 v =
                velocity.is_none() ? Vec3::Zero().eval() : vectorOf("velocity", velocity);
            return loop.tick(inputOf(pose, v));
          },
          "hand"_a, "velocity"_a = py::none(),
          "The HapticOutput at a pose of the hand; velocity: of its position (3,) [m/s].")
      .def("run", &runTicks, "hand"_a, "velocity"_a = py::none(), "progress"_a = py::none(),
           "A tick for each row of hand (n, 3) or (n, 7) and velocity (n, 3). Returns a dict of\n"
           "arrays: force, torque, tool (its position), all (n, 3), depth and cut_volume (n,).");
}

}  // namespace cloudcontact::python
