// Python: states of running worlds.
#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/scripted_world.h"
#include "python/turns.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using namespace program;
using Scripted = std::shared_ptr<ScriptedWorld>;

WorldSave savedOf(const ScriptedWorld& world) {
  const Turn turn(&world);
  const Unlocked unlocked;
  return world.world->save();
}

void restore(ScriptedWorld& world, const WorldSave& save) {
  const Turn turn(&world);
  const Unlocked unlocked;
  world.world->restore(save);
  world.time = save.time;
}

Scripted copyOf(const ScriptedWorld& world) {
  auto made = std::make_shared<ScriptedWorld>();
  made->scene = world.scene;
  made->settings = world.settings;
  const WorldSave save = savedOf(world);
  prepare(*made, py::bool_(false));
  restore(*made, save);
  return made;
}

// Of a state, for other processes.
py::tuple pickled(const WorldSave& save) {
  py::list loads;
  for (const BodyLoad& load : save.loads) loads.append(py::make_tuple(load.force, load.torque));
  const ContactMoment& m = save.moment;
  const Energy& e = m.energy;
  py::list drives;
  for (const DriveStart& drive : save.drives)
    drives.append(py::make_tuple(drive.pose, drive.time, drive.linear, drive.angular));
  py::list joints;
  for (const JointSave& joint : save.joints)
    joints.append(py::make_tuple(joint.places, joint.motors, joint.load.force, joint.load.torque,
                                 joint.load.arm));
  return py::make_tuple(py::bytes(save.bullet.bytes), save.time, save.latestStep, loads, drives,
                        save.volumes, m.pairs, m.contacts, m.deepest,
                        py::make_tuple(e.kinetic, e.potential, e.spring, e.elastic, e.cutAway),
                        joints);
}

WorldSave unpickled(const py::tuple& from) {
  WorldSave save;
  save.bullet.bytes = from[0].cast<std::string>();
  save.time = from[1].cast<double>(), save.latestStep = from[2].cast<double>();
  for (const py::handle load : from[3]) {
    const auto pair = load.cast<py::tuple>();
    save.loads.push_back({pair[0].cast<Vec3>(), pair[1].cast<Vec3>()});
  }
  for (const py::handle drive : from[4]) {
    const auto d = drive.cast<py::tuple>();
    save.drives.push_back(
        {d[0].cast<Pose>(), d[1].cast<double>(), d[2].cast<Vec3>(), d[3].cast<Vec3>()});
  }
  save.volumes = from[5].cast<std::vector<double>>();
  save.moment.pairs = from[6].cast<int>(), save.moment.contacts = from[7].cast<int>();
  save.moment.deepest = from[8].cast<double>();
  const auto e = from[9].cast<py::tuple>();
  save.moment.energy = {e[0].cast<double>(), e[1].cast<double>(), e[2].cast<double>(),
                        e[3].cast<double>(), e[4].cast<double>()};
  for (const py::handle joint : from[10]) {
    const auto j = joint.cast<py::tuple>();
    save.joints.push_back({j[0].cast<std::array<double, 2>>(),
                           j[1].cast<std::array<JointMotor, 2>>(),
                           {j[2].cast<Vec3>(), j[3].cast<Vec3>(), j[4].cast<Vec3>()}});
  }
  return save;
}

}  // namespace

void bindWorldStates(py::module_& module, py::class_<ScriptedWorld, Scripted>& world) {
  py::class_<WorldSave>(module, "WorldState",
                        "A state of a World, from save(). It pickles; restore it in worlds of the\n"
                        "same scene and the same build.")
      .def_readonly("time", &WorldSave::time, "Simulated then [s].")
      .def_property_readonly(
          "nbytes", [](const WorldSave& s) { return s.bullet.bytes.size(); }, "Of memory.")
      .def(py::pickle(&pickled, &unpickled));
  world
      .def("save", &savedOf,
           "The state between two steps, a WorldState: bodies, contacts with their impulses, "
           "joints\n"
           "with their motors, applied forces and time. Raises ValueError where a body deforms.")
      .def("restore", &restore, "state"_a,
           "Goes back to a state of this world, or of another one of the same scene. The world "
           "goes\n"
           "on as it did from there, to the bit. Raises ValueError where the state is of another\n"
           "scene, or where a body was cut since.")
      .def("copy", &copyOf,
           "Another World of the same scene and settings, in this state. It shares clouds and\n"
           "fields with this one.")
      .def("__copy__", &copyOf)
      .def("__deepcopy__", [](const ScriptedWorld& w, const py::dict&) { return copyOf(w); });
}

}  // namespace cloudcontact::python
