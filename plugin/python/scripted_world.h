// A running world as Python holds it: with its scene, its settings and its time.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "python/long_work.h"
#include "scene/world.h"

namespace cloudcontact::python {

// Clouds and fields that no world uses any more, of which the next may be made: a script that makes
// one world after another, each of other bodies, does not keep them all.
constexpr std::size_t kUnusedShapes = 8;

struct ScriptedWorld {
  program::SceneDescription scene;
  program::WorldSettings settings;
  std::unique_ptr<program::World> world;
  double time = 0;            // [s]
  std::atomic<int> stops{0};  // how often a run was asked to end

  ScriptedWorld() = default;
  ~ScriptedWorld();  // and trims the store
  // Throws std::out_of_range where there is no such body.
  std::size_t index(const std::string& name) const;
};

// A stretch of time.
struct RunWords {
  double seconds = 0, step = 0;  // [s]
  int substeps = 1;
  std::string replay;  // a file; empty: none
  py::object observe;  // called with the world after each step, unless None
};

// A live view.
struct ViewWords {
  std::optional<double> seconds = {};  // none: until Ctrl-C
  double step = 0;                     // [s]
  int substeps = 1, port = 0;
  double speed = 1;              // times real time; 0: as fast as it can
  py::object observe, announce;  // announce: called with the address; None: _view.announce
};

// Adds joints to the class World, and the classes of joints and motors.
void bindWorldJoint(py::module_& module,
                    py::class_<ScriptedWorld, std::shared_ptr<ScriptedWorld>>& world);
// Adds saving and restoring to the class World, and the class of states.
void bindWorldStates(py::module_& module,
                     py::class_<ScriptedWorld, std::shared_ptr<ScriptedWorld>>& world);

// A World of Python, from what its constructor is given.
std::shared_ptr<ScriptedWorld> makeWorld(const py::object& scene,
                                         const std::optional<double>& voxel,
                                         const py::object& progress, const py::kwargs& words);
// Makes the world with progress. Voxel 0: the default of the scene.
void prepare(ScriptedWorld& world, const py::object& progress);
void run(ScriptedWorld& world, const py::object& self, const RunWords& words,
         const py::object& progress);
// Runs the world in the browser. Ctrl-C ends it as the end of the time does. Both end early when
// `stops` counts up, and when the interpreter ends.
void view(ScriptedWorld& world, const py::object& self, const ViewWords& words);

}  // namespace cloudcontact::python
