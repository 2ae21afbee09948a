// Python: joints of running worlds, and motors.
#include <cmath>

#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/scripted_world.h"
#include "python/turns.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using namespace program;
using Scripted = std::shared_ptr<ScriptedWorld>;

// An axis of a joint, the first where it has none that moves.
struct WorldJoint {
  Scripted world;
  std::size_t joint = 0, axis = 0;
};

template <typename Of>
auto ofJoint(Of of) {
  return [of](const WorldJoint& j) {
    const Turn turn(j.world.get());
    return of(*j.world->world, j);
  };
}

const SceneJoint& sceneOf(const World& world, const WorldJoint& j) {
  return world.describedJoint(j.joint);
}
const SceneAxis& axisOf(const World& world, const WorldJoint& j) {
  return sceneOf(world, j).at(j.axis);
}

WorldJoint jointOf(const Scripted& world, const std::string& name, std::size_t axis) {
  const Turn turn(world.get());
  const World& w = *world->world;
  for (std::size_t i = 0; i < w.jointCount(); ++i) {
    const SceneJoint& joint = w.describedJoint(i);
    if (joint.name != name) continue;
    if (axis >= std::max<std::size_t>(1, joint.axes()))
      throw py::index_error("joint '" + name + "': has no axis " + std::to_string(axis));
    return {world, i, axis};
  }
  throw py::key_error("no joint '" + name + "'");
}

void setMotor(const WorldJoint& j, const std::optional<JointMotor>& motor) {
  const Turn turn(j.world.get());
  j.world->world->setMotor(j.joint, j.axis, motor.value_or(JointMotor()));
}

std::string textOf(const JointMotor& m) {
  const auto number = [](double x) { return py::repr(py::float_(x)).cast<std::string>(); };
  return "Motor(position=" + number(m.position) + ", velocity=" + number(m.velocity) +
         ", stiffness=" + number(m.stiffness) + ", damping=" + number(m.damping) +
         ", force=" + number(m.force) + ", most=" + number(m.most) + ")";
}

void bindMotor(py::module_& module) {
  py::class_<JointMotor>(
      module, "Motor",
      "What drives a joint: it pushes by force + stiffness (position - place) + damping\n"
      "(velocity - speed), by `most` at most, and by no more than the joint's effort. So it is a\n"
      "servo, a speed or a force. No gain is too high for a step. An infinite damping moves the\n"
      "joint at `velocity` as long as `most` is enough. [rad, m], a second; [N m, N]. It does\n"
      "not change: give the joint another one.")
      .def(py::init([](double position, double velocity, double stiffness, double damping,
                       double force, double most) {
             return JointMotor{position, velocity, stiffness, damping, force, most};
           }),
           py::kw_only(), "position"_a = 0.0, "velocity"_a = 0.0, "stiffness"_a = 0.0,
           "damping"_a = 0.0, "force"_a = 0.0, "most"_a = HUGE_VAL)
      .def_readonly("position", &JointMotor::position, "Where to [rad, m].")
      .def_readonly("velocity", &JointMotor::velocity, "How fast [rad/s, m/s].")
      .def_readonly("stiffness", &JointMotor::stiffness, "[N m/rad, N/m]")
      .def_readonly("damping", &JointMotor::damping, "[N m s/rad, N s/m]")
      .def_readonly("force", &JointMotor::force, "[N m, N]")
      .def_readonly("most", &JointMotor::most, "[N m, N]")
      .def("__repr__", &textOf)
      .def(py::pickle(
          [](const JointMotor& m) {
            return py::make_tuple(m.position, m.velocity, m.stiffness, m.damping, m.force, m.most);
          },
          [](const py::tuple& t) {
            return JointMotor{t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>(),
                              t[3].cast<double>(), t[4].cast<double>(), t[5].cast<double>()};
          }));
}

void bindJointState(py::class_<WorldJoint>& joint) {
  joint
      .def_property_readonly(
          "position", ofJoint([](const World& w, const WorldJoint& j) {
            return w.axis(j.joint, j.axis).place;
          }),
          "Of the child as seen from the parent, from the start on, turns and all [rad, m].")
      .def_property_readonly("velocity", ofJoint([](const World& w, const WorldJoint& j) {
                               return w.axis(j.joint, j.axis).speed;
                             }),
                             "[rad/s, m/s]")
      .def_property_readonly("direction", ofJoint([](const World& w, const WorldJoint& j) {
                               return w.axis(j.joint, j.axis).direction;
                             }),
                             "Of the axis now, in the world (3,).")
      .def_property_readonly("origin", ofJoint([](const World& w, const WorldJoint& j) {
                               return w.joint(j.joint).origin;
                             }),
                             "Where the joint is now, on the child (3,) [m].")
      .def_property_readonly(
          "force",
          ofJoint([](const World& w, const WorldJoint& j) { return w.joint(j.joint).force; }),
          "On the child from the parent in the latest step, with motors and springs (3,) [N].")
      .def_property_readonly("torque", ofJoint([](const World& w, const WorldJoint& j) {
                               return w.joint(j.joint).torque;
                             }),
                             "Likewise, about the origin (3,) [N m].")
      .def_property("motor", ofJoint([](const World& w, const WorldJoint& j) {
                      return w.motor(j.joint, j.axis);
                    }),
                    &setMotor, "A Motor, from the next step on; None: none.");
}

}  // namespace

void bindWorldJoint(py::module_& module, py::class_<ScriptedWorld, Scripted>& world) {
  bindMotor(module);
  py::class_<WorldJoint> joint(module, "WorldJoint",
                               "A joint of a World, and one of its axes. A fixed joint and a ball\n"
                               "have no place, speed and motor: these raise IndexError.");
  joint
      .def_property_readonly(
          "name", ofJoint([](const World& w, const WorldJoint& j) { return sceneOf(w, j).name; }),
          "Of World.joint().")
      .def_property_readonly("kind", ofJoint([](const World& w, const WorldJoint& j) {
                               return nameOf(sceneOf(w, j).kind);
                             }),
                             "\"fixed\", \"revolute\" ...")
      .def_readonly("axis", &WorldJoint::axis, "0, or 1 for the second of a universal joint.")
      .def_property_readonly(
          "lower", ofJoint([](const World& w, const WorldJoint& j) { return axisOf(w, j).lower; }),
          "Limit [rad, m], or None.")
      .def_property_readonly(
          "upper", ofJoint([](const World& w, const WorldJoint& j) { return axisOf(w, j).upper; }),
          "Likewise.")
      .def_property_readonly("effort", ofJoint([](const World& w, const WorldJoint& j) {
                               return axisOf(w, j).effort;
                             }),
                             "The most that a motor pushes [N m, N].");
  bindJointState(joint);
  world
      .def(
          "joint", &jointOf, "name"_a, "axis"_a = 0,
          "A WorldJoint by its name. axis: 1 is the second of a universal joint. Raises KeyError,\n"
          "IndexError.")
      .def_property_readonly(
          "joints",
          [](const ScriptedWorld& w) {
            const Turn turn(&w);
            std::vector<std::string> names;
            for (std::size_t i = 0; i < w.world->jointCount(); ++i)
              names.push_back(w.world->describedJoint(i).name);
            return names;
          },
          "Names, in their order.");
}

}  // namespace cloudcontact::python
