// Python: bodies of running worlds.
#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/scripted_world.h"
#include "python/turns.h"
#include "python/unlocked.h"
#include "python/voxel_lists.h"
#include "python/world_body.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using namespace program;

template <typename Of>
auto ofBody(Of of) {
  return [of](const WorldBody& b) {
    const Turn turn(b.world.get());
    return std::invoke(of, *b.world->world, b.index);
  };
}

void requireCuttable(const World& world, std::size_t body) {
  if (!world.isCuttable(body))
    throw std::invalid_argument("body '" + world.name(body) +
                                "': is not cuttable; add it with cuttable=True");
}

// A value of the body that a program sets and reads.
template <auto kMember>
auto described() {
  return [](const WorldBody& b) {
    const Turn turn(b.world.get());
    return std::invoke(kMember, b.world->world->described(b.index));
  };
}
template <auto kMember>
auto changed() {
  return [](const WorldBody& b, const std::optional<double>& value) {
    const Turn turn(b.world.get());
    SceneBody like = b.world->world->described(b.index);
    std::invoke(kMember, like) = value;
    if (!like.stiffness && kMember == &SceneBody::stiffness) like.damping.reset();
    b.world->world->change(b.index, like);
  };
}

py::object velocitiesOfDrive(const WorldBody& b) {
  const Turn turn(b.world.get());
  const std::optional<SceneDrive>& drive = b.world->world->described(b.index).drive;
  return drive ? py::make_tuple(Vec3(drive->linear), Vec3(drive->angular)) : py::object(py::none());
}

void setDrive(const WorldBody& b, const py::sequence& velocities) {
  if (py::len(velocities) != 2)
    throw std::invalid_argument("drive: give two velocities, linear and angular");
  const Vec3 linear = vectorOf("drive", velocities[0]), angular = vectorOf("drive", velocities[1]);
  const Turn turn(b.world.get());
  SceneBody like = b.world->world->described(b.index);
  if (!like.drive) like.drive = SceneDrive();
  like.drive->linear = linear, like.drive->angular = angular;
  b.world->world->change(b.index, like);
}

void bindChanges(py::class_<WorldBody>& body) {
  body.def_property(
          "friction", described<&SceneBody::friction>(), changed<&SceneBody::friction>(),
          "Coulomb's; None: the other body's. May be set, as what follows: from the next\n"
          "step on.")
      .def_property("restitution", described<&SceneBody::restitution>(),
                    changed<&SceneBody::restitution>(), "0 to 1, or None.")
      .def_property("stiffness", described<&SceneBody::stiffness>(),
                    changed<&SceneBody::stiffness>(),
                    "Of its contacts [N/m]; None: as hard as the step allows, without damping.")
      .def_property("damping", described<&SceneBody::damping>(), changed<&SceneBody::damping>(),
                    "Beside a stiffness [N s/m], or None.")
      .def_property("mass", ofBody(&World::mass), changed<&SceneBody::mass>(),
                    "[kg]; 0 where nothing moves it. What is set changes the inertia alike.")
      .def_property(
          "drive", &velocitiesOfDrive, &setDrive,
          "Velocities (linear, angular) that nothing changes, of a body that was added with\n"
          "a drive, else None. What is set holds from where the body is.");
}

}  // namespace

void bindWorldBody(py::module_& module) {
  py::class_<WorldBody> body(module, "WorldBody", "A body of a World, as it is now.");
  bindChanges(body);
  body.def_property_readonly("name", ofBody(&World::name))
      .def_readonly("index", &WorldBody::index, "Its number in the world's arrays.")
      .def_property(
          "pose", [](const WorldBody& b) { return b.state().pose; },
          [](const WorldBody& b, const py::object& pose) {
            const Turn turn(b.world.get());
            b.world->world->place(b.index, poseOf("pose", pose));
          },
          "Of its frame: a Pose. What is set moves it there, with the velocity that it has.")
      .def_property_readonly(
          "position", [](const WorldBody& b) { return b.state().pose.position; }, "(3,) [m]")
      .def_property_readonly(
          "orientation",
          [](const WorldBody& b) { return Eigen::Vector4d(b.state().pose.orientation.coeffs()); },
          "Quaternion x y z w, (4,).")
      .def_property(
          "velocity", [](const WorldBody& b) { return b.state().linearVelocity; },
          [](const WorldBody& b, const py::object& velocity) {
            const Vec3 v = vectorOf("velocity", velocity);
            const Turn turn(b.world.get());
            World& w = *b.world->world;
            w.setMotion(b.index, v, w.state(b.index).angularVelocity);
          },
          "Of the frame's origin (3,) [m/s]; may be set.")
      .def_property(
          "angular_velocity", [](const WorldBody& b) { return b.state().angularVelocity; },
          [](const WorldBody& b, const py::object& velocity) {
            const Vec3 v = vectorOf("angular_velocity", velocity);
            const Turn turn(b.world.get());
            World& w = *b.world->world;
            w.setMotion(b.index, w.state(b.index).linearVelocity, v);
          },
          "(3,) [rad/s]; may be set: the frame's origin keeps its velocity.")
      .def_property(
          "applied_force", ofBody([](const World& w, std::size_t i) { return w.load(i).force; }),
          [](const WorldBody& b, const py::object& newtons) {
            const Vec3 force = vectorOf("applied_force", newtons);
            const Turn turn(b.world.get());
            b.world->world->setLoad(b.index, {force, b.world->world->load(b.index).torque});
          },
          "Yours, on the center of mass in each step until it is set again (3,) [N].")
      .def_property(
          "applied_torque", ofBody([](const World& w, std::size_t i) { return w.load(i).torque; }),
          [](const WorldBody& b, const py::object& newtonMeters) {
            const Vec3 torque = vectorOf("applied_torque", newtonMeters);
            const Turn turn(b.world.get());
            b.world->world->setLoad(b.index, {b.world->world->load(b.index).force, torque});
          },
          "Yours, in the world's axes, in each step until it is set again (3,) [N m].")
      .def_property_readonly("asleep", [](const WorldBody& b) { return b.state().asleep; })
      .def_property_readonly("cuttable", ofBody(&World::isCuttable))
      .def_property_readonly("matter", ofBody([](const World& w, std::size_t i) {
                               requireCuttable(w, i);
                               return Cloud(w.matter(i));
                             }),
                             "Of a body that can be cut: its Cloud now.")
      .def_property_readonly(
          "cut_volume", ofBody([](const World& w, std::size_t i) { return w.cutOf(i).volume; }),
          "Removed so far [m^3].")
      .def(
          "cut",
          [](const WorldBody& b, const py::object& voxels, const py::object& coverage) {
            const std::vector<VoxelCut> cuts = cutsFrom(voxels, coverage);
            const Turn turn(b.world.get());
            requireCuttable(*b.world->world, b.index);
            const Unlocked unlocked;
            b.world->world->cut(b.index, cuts);
          },
          "voxels"_a, "coverage"_a = py::none(),
          "Removes voxels (n, 3) of `matter` between steps, as Cloud.cut(). Parts that fall off\n"
          "become bodies behind the others.");
}

}  // namespace cloudcontact::python
