// Python: many worlds of one scene.
#include <deque>

#include "python/bindings.h"
#include "python/many_worlds.h"
#include "python/numpy_views.h"
#include "python/turns.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using Many = std::shared_ptr<ManyWorlds>;

// All worlds, while no other thread uses any.
struct AllTurns {
  explicit AllTurns(const ManyWorlds& many) : whole(&many) {
    for (const auto& world : many.worlds) each.emplace_back(world.get());
  }
  Turn whole;
  std::deque<Turn> each;
};

Many makeMany(const py::object& scene, std::size_t count, const std::optional<double>& voxel,
              const py::object& progress, const py::kwargs& words) {
  if (count < 1) throw std::invalid_argument("count: must be 1 or more");
  if (words.contains("backend") && words["backend"].cast<std::string>() != "cpu")
    throw std::invalid_argument("backend: many worlds run on the CPU; leave it out");
  const int threads = words.contains("threads") ? words["threads"].cast<int>() : 0;
  // The fields are made on all threads; of the worlds, each runs on one.
  const auto whole = makeWorld(scene, voxel, progress, words);
  py::kwargs own(words);
  own["threads"] = 1;
  auto first = makeWorld(scene, voxel, py::bool_(false), own);
  const Unlocked unlocked;
  return std::make_shared<ManyWorlds>(std::move(first), count, threads);
}

// The numbers of worlds: of one, of some, or where a mask is true; all for None.
std::vector<std::size_t> chosen(const py::object& which, std::size_t count) {
  std::vector<std::size_t> numbers;
  if (which.is_none()) {
    for (std::size_t i = 0; i < count; ++i) numbers.push_back(i);
    return numbers;
  }
  const py::module_ numpy = py::module_::import("numpy");
  py::object list = numpy.attr("atleast_1d")(which);
  if (list.attr("dtype").attr("kind").cast<std::string>() == "b") {
    if (py::len(list) != count)
      throw std::invalid_argument("worlds: the mask has " + std::to_string(py::len(list)) +
                                  " values for " + std::to_string(count) + " worlds");
    list = numpy.attr("flatnonzero")(list);
  }
  const Integers array = integersOf("worlds", list);
  for (py::ssize_t k = 0; k < array.size(); ++k) {
    const std::int32_t i = array.data()[k];
    if (i < 0 || static_cast<std::size_t>(i) >= count)
      throw py::index_error("worlds: there is no world " + std::to_string(i) + " of " +
                            std::to_string(count));
    numbers.push_back(static_cast<std::size_t>(i));
  }
  return numbers;
}

void stepAll(ManyWorlds& many, const std::optional<double>& seconds, int substeps) {
  const double length = seconds.value_or(many.worlds.front()->scene.step);
  if (!(length > 0) || !std::isfinite(length))
    throw std::invalid_argument("seconds: must be above 0 and finite");
  if (substeps < 1) throw std::invalid_argument("substeps: must be 1 or more");
  const AllTurns turns(many);
  const Unlocked unlocked;
  many.step(length, substeps);
}

void resetSome(ManyWorlds& many, const py::object& which) {
  const std::vector<std::size_t> numbers = chosen(which, many.worlds.size());
  const AllTurns turns(many);
  const Unlocked unlocked;
  for (const std::size_t i : numbers) many.restore(i, many.start);
}

py::list statesOf(const ManyWorlds& many, const py::object& which) {
  py::list states;
  const std::vector<std::size_t> numbers = chosen(which, many.worlds.size());
  const AllTurns turns(many);
  for (const std::size_t i : numbers) states.append(many.worlds[i]->world->save());
  return states;
}

void restoreSome(ManyWorlds& many, const std::vector<const program::WorldSave*>& states,
                 const py::object& which) {
  const std::vector<std::size_t> numbers = chosen(which, many.worlds.size());
  if (states.size() != numbers.size())
    throw std::invalid_argument("states: " + std::to_string(states.size()) + " for " +
                                std::to_string(numbers.size()) + " worlds");
  const AllTurns turns(many);
  const Unlocked unlocked;
  for (std::size_t k = 0; k < numbers.size(); ++k) many.restore(numbers[k], *states[k]);
}

// On each body by its contacts in the latest step: force, and torque about its frame's origin.
py::array_t<double> wrenches(const ManyWorlds& many) {
  const std::size_t count = many.worlds.size();
  py::array_t<double> sums({count, many.bodies, std::size_t{6}});
  std::fill_n(sums.mutable_data(), sums.size(), 0.0);
  const AllTurns turns(many);
  program::ContactsNow now;
  for (std::size_t i = 0; i < count; ++i) {
    const program::World& world = *many.worlds[i]->world;
    world.contacts(now);
    const auto add = [&](int body, const Vec3& place, const Vec3& force) {
      if (body < 0 || static_cast<std::size_t>(body) >= many.bodies) return;
      const auto b = static_cast<std::size_t>(body);
      double* const row = sums.mutable_data(i, b, 0);
      const Vec3 torque = (place - world.pose(b).position).cross(force);
      for (int k = 0; k < 3; ++k) row[k] += force[k], row[3 + k] += torque[k];
    };
    for (const program::PatchNow& patch : now.patches)
      for (const program::ContactNow& point : now.of(patch)) {
        add(patch.b, point.position, point.force);
        add(patch.a, point.position, -point.force);
      }
  }
  return sums;
}

// An array over the memory of all worlds' rows.
template <BodyRows ManyWorlds::*kRows, bool kWritable = false>
py::array arrayOf(const Many& many) {
  const BodyRows& rows = (*many).*kRows;
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  const auto columns = static_cast<py::ssize_t>(rows.columns),
             bodies = static_cast<py::ssize_t>(many->bodies);
  return viewOf(rows.values.data(),
                {static_cast<py::ssize_t>(many->worlds.size()), bodies, columns},
                {bodies * columns * size, columns * size, size}, py::cast(many), kWritable);
}

std::vector<std::string> namesIn(const ManyWorlds& many) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < many.bodies; ++i)
    names.push_back(many.worlds.front()->world->name(i));
  return names;
}

void bindArrays(py::class_<ManyWorlds, Many>& worlds) {
  worlds
      .def_property_readonly(
          "positions", &arrayOf<&ManyWorlds::positions>,
          "Of the bodies' frames, (worlds, bodies, 3) [m]. This array and those\n"
          "below are the memory that each step fills: copy what you keep.")
      .def_property_readonly("orientations", &arrayOf<&ManyWorlds::orientations>,
                             "Quaternions x y z w, (worlds, bodies, 4).")
      .def_property_readonly("velocities", &arrayOf<&ManyWorlds::velocities>,
                             "Of the frames' origins, (worlds, bodies, 3) [m/s].")
      .def_property_readonly("angular_velocities", &arrayOf<&ManyWorlds::angularVelocities>,
                             "(worlds, bodies, 3) [rad/s].")
      .def_property_readonly("forces", &arrayOf<&ManyWorlds::forces, true>,
                             "Yours, on the centers of mass in each step until you write others,\n"
                             "(worlds, bodies, 3) [N]. Write into it.")
      .def_property_readonly(
          "torques", &arrayOf<&ManyWorlds::torques, true>,
          "Yours, in the world's axes, (worlds, bodies, 3) [N m]. Write into it.")
      .def_property_readonly(
          "times",
          [](const Many& many) {
            return viewOf(many->times.data(), {static_cast<py::ssize_t>(many->times.size())},
                          {static_cast<py::ssize_t>(sizeof(double))}, py::cast(many));
          },
          "Simulated so far, (worlds,) [s].")
      .def("contact_wrenches", &wrenches,
           "On each body by its contacts in the latest step, (worlds, bodies, 6): force [N], and\n"
           "torque about its frame's origin in the world's axes [N m].");
}

}  // namespace

void bindWorlds(py::module_& module) {
  py::class_<ManyWorlds, Many> worlds(
      module, "Worlds",
      "Many worlds of one scene, which share clouds and fields and are stepped on all cores. Each\n"
      "runs as a World by itself does, to the bit.");
  worlds
      .def(py::init(&makeMany), "scene"_a, "count"_a, "voxel"_a = py::none(),
           "progress"_a = py::none(),
           "count: of worlds, at least 1. The rest as for World; threads: of all worlds together,\n"
           "each runs on one. Raises ValueError as World does.")
      .def("__len__", [](const ManyWorlds& many) { return many.worlds.size(); })
      .def(
          "__getitem__",
          [](const ManyWorlds& many, std::size_t i) {
            if (i >= many.worlds.size())
              throw py::index_error("there is no world " + std::to_string(i) + " of " +
                                    std::to_string(many.worlds.size()));
            return many.worlds[i];
          },
          "number"_a, "One of them, a World. After you change it call read().")
      .def_property_readonly("names", &namesIn, "Of the bodies, in the order of the arrays.")
      .def(
          "index",
          [](const ManyWorlds& many, const std::string& name) {
            try {
              return many.worlds.front()->index(name);
            } catch (const std::out_of_range& none) {
              throw py::key_error(none.what());
            }
          },
          "name"_a, "A body's number in the arrays. Raises KeyError.")
      .def("step", &stepAll, "seconds"_a = py::none(), "substeps"_a = 1,
           "A step of all worlds, of the scene's length where none is given [s], in `substeps`\n"
           "parts. Raises RuntimeError, with the world's number, where a state is not finite.")
      .def("reset", &resetSome, "worlds"_a = py::none(),
           "Back to the start: all, or those of these numbers, or of a mask (worlds,).")
      .def("save", &statesOf, "worlds"_a = py::none(), "Their states, a list of WorldState.")
      .def("restore", &restoreSome, "states"_a, "worlds"_a = py::none(),
           "Goes back to states, one for each world (World.restore()).")
      .def(
          "read",
          [](ManyWorlds& many) {
            const AllTurns turns(many);
            for (std::size_t i = 0; i < many.worlds.size(); ++i) many.read(i);
          },
          "Fills the arrays again, after worlds were changed one by one.");
  bindArrays(worlds);
}

}  // namespace cloudcontact::python
