// Python: running worlds.
#include <algorithm>
#include <map>

#include "io/options.h"
#include "io/solid_text.h"
#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/python_words.h"
#include "python/scripted_world.h"
#include "python/turns.h"
#include "python/unlocked.h"
#include "python/world_body.h"
#include "scene/scene_file.h"
#include "scene/shape_cache.h"
#include "scene/shape_store.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using namespace program;
using Scripted = std::shared_ptr<ScriptedWorld>;

// What reads a world while no other thread steps it.
template <typename Of>
auto inTurn(Of of) {
  return [of](const ScriptedWorld& w) {
    const Turn turn(&w);
    return of(w);
  };
}
void takeTissues(CommonOptions& options, const py::object& tissues) {
  if (tissues.is_none()) return;
  if (py::isinstance<py::str>(tissues))
    options.tissues.table = tissues.cast<std::string>();
  else
    options.tissues.made = tissues.cast<TissueTable>();
}

void takeLaw(CommonOptions& options, const py::object& law) {
  if (law.is_none()) return;
  options.law = law.cast<Law>();
  validate(options.law);
  if (const auto* k = std::get_if<KelvinVoigt>(&options.law))
    options.stiffness = k->stiffness, options.damping = k->damping;
  if (const auto* f = std::get_if<Foundation>(&options.law))
    options.stiffness = f->stiffness, options.damping = f->damping;
}

// A length [m], or "exact".
void takeTolerance(CommonOptions& options, const py::object& tolerance) {
  options.exact = py::isinstance<py::str>(tolerance);
  if (options.exact && tolerance.cast<std::string>() != "exact")
    throw std::invalid_argument("tolerance: a length [m], or \"exact\"");
  options.tolerance = options.exact ? 0 : tolerance.cast<double>();
}

// The keyword arguments of World.
void takeWords(WorldSettings& settings, const py::kwargs& words) {
  CommonOptions& o = settings.common;
  const std::map<std::string, std::function<void(const py::object&)>> known = {
      {"method", [&](const py::object& v) { o.method = readMethod(v.cast<std::string>()); }},
      {"backend", [&](const py::object& v) { o.backend = readBackend(v.cast<std::string>()); }},
      {"threads", [&](const py::object& v) { o.threads = v.cast<int>(); }},
      {"unit", [&](const py::object& v) { o.metersPerUnit = unitOf(v); }},
      {"shell", [&](const py::object& v) { o.shell = v.cast<std::optional<double>>(); }},
      {"law", [&](const py::object& v) { takeLaw(o, v); }},
      {"friction", [&](const py::object& v) { o.friction = v.cast<std::optional<double>>(); }},
      {"tissues", [&](const py::object& v) { takeTissues(o, v); }},
      {"samples", [&](const py::object& v) { o.samples = v.cast<std::optional<int>>(); }},
      {"reuse", [&](const py::object& v) { o.reuse = v.cast<std::optional<double>>(); }},
      {"tolerance", [&](const py::object& v) { takeTolerance(o, v); }},
      {"iterations",
       [&](const py::object& v) { settings.iterations = v.cast<std::optional<int>>(); }},
      {"cache",
       [&](const py::object& v) {
         if (!v.cast<bool>()) o.cache.reset(), settings.store.reset();
       }},
      {"sleep", [&](const py::object& v) { settings.sleep = v.cast<bool>(); }}};
  for (const auto& [name, value] : words) {
    const auto at = known.find(name.cast<std::string>());
    if (at == known.end()) {
      std::vector<std::string> names = {"scene", "voxel", "progress"};
      for (const auto& [word, take] : known) names.push_back(word);
      throw py::type_error(unknownWord("World", name.cast<std::string>(), names));
    }
    try {
      at->second(py::reinterpret_borrow<py::object>(value));
    } catch (const py::cast_error&) {
      throw py::type_error("World(): " + at->first + " is of a wrong type: " +
                           py::str(py::type::of(value).attr("__name__")).cast<std::string>());
    }
  }
}

}  // namespace

Scripted makeWorld(const py::object& scene, const std::optional<double>& voxel,
                   const py::object& progress, const py::kwargs& words) {
  auto made = std::make_shared<ScriptedWorld>();
  made->scene = py::isinstance<SceneDescription>(scene)
                    ? scene.cast<SceneDescription>()
                    : loadScene(scene.cast<std::filesystem::path>());
  if (made->scene.bodies.empty())
    throw std::invalid_argument("scene '" + made->scene.name + "': has no body; add one");
  if (voxel && (!(*voxel > 0) || !std::isfinite(*voxel)))
    throw std::invalid_argument("voxel: must be above 0 and finite");
  made->settings.common.voxel = voxel;
  made->settings.voxel = voxel.value_or(0);
  made->settings.common.cache = usualCache();
  made->settings.store = commonStore();
  takeWords(made->settings, words);
  try {
    prepare(*made, progress);
  } catch (const BadInput& why) {
    if (py::isinstance<SceneDescription>(scene)) throw BadInput(ofScene(why.what()));
    throw;
  }
  if (made->settings.store) made->settings.store->trim(kUnusedShapes);
  return made;
}

namespace {

// A row of numbers for each body.
template <typename Of>
py::array_t<double> rows(const ScriptedWorld& world, py::ssize_t columns, Of of) {
  const Turn turn(&world);
  const auto n = static_cast<py::ssize_t>(world.world->bodyCount());
  py::array_t<double> array({n, columns});
  for (py::ssize_t i = 0; i < n; ++i) {
    const auto values = of(world.world->state(static_cast<std::size_t>(i)));
    for (py::ssize_t k = 0; k < columns; ++k) array.mutable_at(i, k) = values[k];
  }
  return array;
}

// A contact point with the bodies and the patch that it belongs to.
struct PointRow {
  std::int32_t a = -1, b = -1, patch = -1;
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero(), force = Vec3::Zero();
  double depth = 0;
};

py::array contactsOf(const ScriptedWorld& world) {
  ContactsNow now;
  const Turn turn(&world);
  world.world->contacts(now);
  auto rows = std::make_shared<std::vector<PointRow>>();
  for (std::size_t p = 0; p < now.patches.size(); ++p)
    for (const ContactNow& point : now.of(now.patches[p]))
      rows->push_back({now.patches[p].a, now.patches[p].b, static_cast<std::int32_t>(p),
                       point.position, point.normal, point.force, point.depth});
  const py::dtype type = recordType({{"a", "i4", offsetOf(&PointRow::a)},
                                     {"b", "i4", offsetOf(&PointRow::b)},
                                     {"patch", "i4", offsetOf(&PointRow::patch)},
                                     {"position", "(3,)f8", offsetOf(&PointRow::position)},
                                     {"normal", "(3,)f8", offsetOf(&PointRow::normal)},
                                     {"force", "(3,)f8", offsetOf(&PointRow::force)},
                                     {"depth", "f8", offsetOf(&PointRow::depth)}},
                                    sizeof(PointRow));
  return recordsOf(type, *rows, keeping(rows));
}

py::dict energyOf(const ScriptedWorld& world) {
  const Turn turn(&world);
  const Energy& e = world.world->moment().energy;
  return py::dict("kinetic"_a = e.kinetic, "potential"_a = e.potential, "spring"_a = e.spring,
                  "elastic"_a = e.elastic, "cut_away"_a = e.cutAway, "bodies"_a = e.ofBodies());
}

double stepOf(const ScriptedWorld& world, const std::optional<double>& step) {
  return step.value_or(world.scene.step);
}

void bindStepping(py::class_<ScriptedWorld, Scripted>& world) {
  world
      .def(
          "step",
          [](ScriptedWorld& w, const std::optional<double>& step) {
            const double seconds = stepOf(w, step);
            if (!(seconds > 0) || !std::isfinite(seconds))
              throw std::invalid_argument("step: must be above 0 and finite");
            const Turn turn(&w);
            const Unlocked unlocked;
            w.world->step(seconds);
            w.time += seconds;
          },
          "seconds"_a = py::none(),
          "A step, of the scene's length where none is given [s]. Raises RuntimeError where a\n"
          "state is no longer finite.")
      .def(
          "run",
          [](const py::object& self, double seconds, const std::optional<double>& step,
             int substeps, const std::optional<std::filesystem::path>& replay,
             const py::object& observe, const py::object& progress) {
            auto& w = self.cast<ScriptedWorld&>();
            run(w, self,
                {seconds, stepOf(w, step), substeps, replay ? replay->string() : "", observe},
                progress);
            return replay && replay->extension() == ".html"
                       ? py::module_::import("cloudcontact._view").attr("Replay")(replay->string())
                       : py::object(py::none());
          },
          "seconds"_a, "step"_a = py::none(), "substeps"_a = 1, py::kw_only(),
          "replay"_a = py::none(), "observe"_a = py::none(), "progress"_a = py::none(),
          "Steps for `seconds`, to the nearest whole number of steps; ValueError where that is\n"
          "none of a time above 0. Ctrl-C and what `observe` raises end it after the step; the\n"
          "replay then has what has run. Returns the Replay, which a notebook shows, where\n"
          "`replay` is an .html file.\n\n"
          "step: length of a step [s]; none: the scene's. substeps: parts of each. replay: a file\n"
          "for a replay, .html or .glb. observe: called with the world after each step. progress:\n"
          "see digitize().")
      .def(
          "view",
          [](const py::object& self, const std::optional<double>& seconds,
             const std::optional<double>& step, int substeps, int port, double speed,
             const py::object& observe, const py::object& announce) {
            auto& w = self.cast<ScriptedWorld&>();
            view(w, self, {seconds, stepOf(w, step), substeps, port, speed, observe, announce});
          },
          "seconds"_a = py::none(), "step"_a = py::none(), "substeps"_a = 1, py::kw_only(),
          "port"_a = 0, "speed"_a = 1.0, "observe"_a = py::none(), "announce"_a = py::none(),
          "Steps in real time and shows it in a browser of this machine, as `simulate --view`:\n"
          "pause, step, drag bodies, cut, contacts. For `seconds`, or until Ctrl-C, which ends it\n"
          "without an exception.\n\n"
          "step, substeps, observe: as in run(). port: of 127.0.0.1; 0: a free one. speed: times\n"
          "real time; 0: as fast as it can. announce: called with the address; none: a notebook\n"
          "shows the page, elsewhere the address goes to stderr. Who has the address can steer\n"
          "the world. Raises ValueError where the port cannot be had.")
      .def(
          "stop", [](ScriptedWorld& w) { ++w.stops; },
          "Ends run() and view() of this world after the step that they are in, from another\n"
          "thread or from `observe`; a replay then has what has run.")
      .def("contacts", &contactsOf,
           "Points of the latest step, a structured array (n,): a, b: numbers of the bodies;\n"
           "patch; position (3,) midway between the surfaces [m]; normal (3,) from a to b; force\n"
           "(3,) of a on b with friction [N]; depth [m], positive inside.")
      .def(
          "find_contacts",
          [](ScriptedWorld& w) {
            const Turn turn(&w);
            const Unlocked unlocked;
            w.world->findContacts();
          },
          "Finds the contacts at the current poses, without a step.");
}

void bindReading(py::class_<ScriptedWorld, Scripted>& world) {
  using State = const BodyState&;
  world
      .def_property_readonly(
          "positions",
          [](const ScriptedWorld& w) {
            return rows(w, 3, [](State s) { return s.pose.position; });
          },
          "Of the bodies' frames, (n, 3) [m].")
      .def_property_readonly(
          "orientations",
          [](const ScriptedWorld& w) {
            return rows(w, 4, [](State s) { return Eigen::Vector4d(s.pose.orientation.coeffs()); });
          },
          "Quaternions x y z w, (n, 4).")
      .def_property_readonly(
          "velocities",
          [](const ScriptedWorld& w) {
            return rows(w, 3, [](State s) { return s.linearVelocity; });
          },
          "Of the frames' origins, (n, 3) [m/s].")
      .def_property_readonly(
          "angular_velocities",
          [](const ScriptedWorld& w) {
            return rows(w, 3, [](State s) { return s.angularVelocity; });
          },
          "(n, 3) [rad/s].")
      .def_property_readonly(
          "energy", &energyOf,
          "At the start of the latest step [J]: a dict of kinetic, potential (0\n"
          "at the world's origin), spring, elastic, cut_away, and bodies, all of\n"
          "them but spring and cut_away.")
      .def(
          "penetration",
          [](const ScriptedWorld& w) {
            const Turn turn(&w);
            const Unlocked unlocked;
            return w.world->penetration();
          },
          "The deepest now, measured against the meshes [m].")
      .def_property_readonly("hash", inTurn([](const ScriptedWorld& w) { return w.world->hash(); }),
                             "Of all states: equal runs have equal ones.")
      .def_property_readonly("advice",
                             inTurn([](const ScriptedWorld& w) { return w.world->advice(); }),
                             "What may be wrong with the settings: a list of sentences.");
}

std::vector<std::string> namesOf(const ScriptedWorld& world) {
  const Turn turn(&world);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < world.world->bodyCount(); ++i) names.push_back(world.world->name(i));
  return names;
}

}  // namespace

void bindWorld(py::module_& module) {
  bindWorldBody(module);
  py::class_<ScriptedWorld, Scripted> world(module, "World", "A scene that runs in Bullet.");
  world
      .def(
          py::init(&makeWorld), "scene"_a, "voxel"_a = py::none(), "progress"_a = py::none(),
          "scene: a Scene, or an SDFormat or URDF file. voxel: edge of a voxel [m]; none: the\n"
          "least that is suggested for a moving body (Mesh.suggested_voxel). progress: see\n"
          "digitize().\n\n"
          "Further keywords: method (\"cloud\", \"paper\", or Bullet's \"gjk\", \"gimpact\",\n"
          "\"hacd\", \"primitive\"), backend (\"cpu\", \"opencl\"), threads (0: all cores), unit\n"
          "(of the files of a scene file), shell [m], law, friction (of all pairs), tissues (a\n"
          "list of Tissue, \"dental\" or a JSON file), samples, reuse [voxels],\n"
          "tolerance ([m], or \"exact\"), iterations (of the solver), sleep, cache (True: worlds\n"
          "that live at the same time share clouds and fields, and files keep these between runs,\n"
          "see CLOUDCONTACT_CACHE; False: neither). Raises ValueError that names the body, file\n"
          "or setting.")
      .def("__len__", inTurn([](const ScriptedWorld& w) { return w.world->bodyCount(); }))
      .def(
          "__getitem__",
          [](const Scripted& w, const std::string& name) {
            const Turn turn(w.get());
            try {
              return WorldBody{w, w->index(name)};
            } catch (const std::out_of_range& none) {
              throw py::key_error(none.what());
            }
          },
          "name"_a, "A WorldBody by its name. Raises KeyError.")
      .def("__contains__",
           [](const ScriptedWorld& w, const std::string& name) {
             const std::vector<std::string> names = namesOf(w);
             return std::find(names.begin(), names.end(), name) != names.end();
           })
      .def("__iter__", [](const ScriptedWorld& w) { return py::iter(py::cast(namesOf(w))); })
      .def_property_readonly("names", &namesOf, "Of the bodies, in the order of the arrays.")
      .def_property_readonly("time", inTurn([](const ScriptedWorld& w) { return w.time; }),
                             "Simulated so far [s].")
      .def_property_readonly(
          "voxel", [](const ScriptedWorld& w) { return w.settings.voxel; }, "[m]");
  bindStepping(world);
  bindWorldJoint(module, world);
  bindWorldStates(module, world);
  bindReading(world);
}

}  // namespace cloudcontact::python
