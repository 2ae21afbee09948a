// Making and running a world for Python (scripted_world.h).
#include "python/scripted_world.h"

#include <cmath>
#include <stdexcept>

#include "io/errors.h"
#include "python/python_words.h"
#include "python/turns.h"
#include "python/unlocked.h"
#include "replay/recorder.h"
#include "replay/replay_file.h"
#include "scene/scene_clouds.h"
#include "scene/shape_store.h"
#include "scene/simulation.h"
#include "view/live_view.h"
#include "view/page_server.h"

namespace cloudcontact::python {
namespace {

constexpr double kMostSteps = 1e9;

int stepsOf(const RunWords& words) {
  if (!(words.seconds >= 0) || !std::isfinite(words.seconds))
    throw std::invalid_argument("seconds: must be 0 or more and finite");
  if (!(words.step > 0) || !std::isfinite(words.step))
    throw std::invalid_argument("step: must be above 0 and finite");
  if (words.substeps < 1) throw std::invalid_argument("substeps: must be 1 or more");
  if (words.seconds / words.step > kMostSteps)
    throw std::invalid_argument("step: these are over a thousand million; give longer ones");
  if (words.seconds > 0 && words.seconds < 0.5 * words.step)
    throw std::invalid_argument("seconds: less than half a step; give a shorter step");
  return static_cast<int>(std::llround(words.seconds / words.step));
}

void save(const ScriptedWorld& world, program::Recorder& recorder, const RunWords& words) {
  recorder.close(*world.world);
  program::Replay replay = recorder.finish();
  replay.title = world.scene.name;
  replay.setup = program::setupText(world.settings, words.step, words.substeps);
  replay.voxel = program::usesClouds(world.settings.common.method) ? world.settings.voxel : 0;
  program::saveReplay(replay, words.replay);
}

program::LiveViewSettings pageOf(const ScriptedWorld& world, const ViewWords& words) {
  program::LiveViewSettings page;
  page.speed = words.speed;
  page.step = words.step / words.substeps;
  page.title = world.scene.name;
  page.setup = program::setupText(world.settings, words.step, words.substeps);
  page.voxel = program::usesClouds(world.settings.common.method) ? world.settings.voxel : 0;
  return page;
}

// A step, while no other thread uses the world.
void stepBy(ScriptedWorld& world, const RunWords& words, program::Recorder* recorder, double now) {
  const Turn turn(&world);
  for (int s = 0; s < words.substeps; ++s) world.world->step(words.step / words.substeps);
  world.time += words.step;
  if (recorder) recorder->record(now, *world.world);
}

void observed(const py::object& observe, const py::object& self) {
  if (observe.is_none()) return;
  const Locked locked;
  observe(self);
}

// Throws what a signal's handler raises, such as KeyboardInterrupt.
void lookAtSignals() {
  const Locked locked;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

// `stops`: of the world when the run began.
bool goesOn(const ScriptedWorld& world, int stops) {
  return world.stops == stops && !interpreterEnds();
}

// Ends a view, the last word in its turn. Other threads of Python run, and have the world, while
// its pages close.
struct Farewell {
  ScriptedWorld& world;
  std::optional<Turn>& turn;
  std::unique_ptr<program::LiveView>& page;
  std::string why = {};  // of a failure

  ~Farewell() {
    try {
      if (!turn) turn.emplace(&world);
    } catch (const std::exception&) {  // Ctrl-C: the page ends all the same
    }
    const Unlocked unlocked;
    page->end(why);
    turn.reset();
    page.reset();
  }
};

}  // namespace

ScriptedWorld::~ScriptedWorld() {
  world.reset();
  if (settings.store) settings.store->trim(kUnusedShapes);
}

std::size_t ScriptedWorld::index(const std::string& name) const {
  for (std::size_t i = 0; i < world->bodyCount(); ++i)
    if (world->name(i) == name) return i;
  throw std::out_of_range("world '" + scene.name + "': no body '" + name + "'");
}

void prepare(ScriptedWorld& world, const py::object& progress) {
  runLong(progress, "preparing " + world.scene.name, [&](const auto& tell) {
    program::WorldSettings settings = world.settings;
    settings.common.progress = [&](const std::string&) { return tell; };
    if (!settings.common.voxel) {
      settings.voxel = program::defaultVoxel(world.scene, settings.common);
      world.settings.voxel = settings.voxel;
    }
    world.world = std::make_unique<program::World>(world.scene, settings);
  });
}

void run(ScriptedWorld& world, const py::object& self, const RunWords& words,
         const py::object& progress) {
  const int steps = stepsOf(words), stops = world.stops;
  program::Recorder recorder;
  const bool records = !words.replay.empty();
  if (records) program::checkReplay(words.replay);
  Pacer pacer(progress, "simulating " + world.scene.name);
  {
    const Unlocked unlocked;
    if (records) {
      const Turn turn(&world);
      recorder.begin(*world.world, world.scene.name, words.seconds, words.step);
      recorder.record(0, *world.world);
    }
    try {
      for (int n = 1; n <= steps && goesOn(world, stops); ++n) {
        stepBy(world, words, records ? &recorder : nullptr, n * words.step);
        observed(words.observe, self);
        pacer.report(double(n) / steps);
      }
    } catch (...) {  // Ctrl-C, or `observe`: what has run is worth seeing
      if (records) save(world, recorder, words);
      throw;
    }
    if (records) save(world, recorder, words);
  }
  pacer.finish();
}

void view(ScriptedWorld& world, const py::object& self, const ViewWords& words) {
  RunWords run;
  run.step = words.step;
  run.substeps = words.substeps;
  run.seconds = words.seconds.value_or(0.5 * kMostSteps * run.step);  // weeks
  const int steps = stepsOf(run), stops = world.stops;
  if (!(words.speed >= 0) || !std::isfinite(words.speed))
    throw std::invalid_argument("speed: must be 0 or more and finite");
  const Claim claim;  // the page ends before the process does
  auto server = std::make_unique<program::PageServer>(words.port);
  std::optional<Turn> turn(std::in_place, &world);
  auto page = std::make_unique<program::LiveView>(*world.world, world.time, pageOf(world, words),
                                                  std::move(server));
  Farewell farewell{world, turn, page};
  turn.reset();
  const py::object announce = words.announce.is_none()
                                  ? py::module_::import("cloudcontact._view").attr("announce")
                                  : words.announce;
  const auto listens = [&] {
    turn.reset();  // others read the world meanwhile
    lookAtSignals();
    turn.emplace(&world);
    return goesOn(world, stops);
  };
  try {
    announce(page->url());
    const Unlocked unlocked;
    for (int n = 1; n <= steps; ++n) {
      turn.emplace(&world);
      const bool isDue = page->follow(world.time, listens);
      turn.reset();
      if (!isDue || !goesOn(world, stops)) break;
      stepBy(world, run, nullptr, 0);
      observed(words.observe, self);
    }
  } catch (py::error_already_set& raised) {
    if (raised.matches(PyExc_KeyboardInterrupt)) return;
    farewell.why = raised.what();
    throw;
  } catch (const std::exception& failure) {
    farewell.why = inPython(failure.what());
    throw;
  }
}

}  // namespace cloudcontact::python
