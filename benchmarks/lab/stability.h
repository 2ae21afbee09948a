// Stability where methods fail: scenes stepped through time, each with a physical rule and a
// margin.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/options.h"
#include "scene/scene.h"
#include "scene/shape_store.h"
#include "scene/simulation.h"

namespace cloudcontact::program::lab {

// One way to run a scene.
struct Trial {
  Method method = Method::Cloud;
  double step = 1.0 / 240;  // [s]
  // "stiff": bodies state their stiffness and damping (the law). "auto": nobody states one; the
  // method's own way (for clouds an automatic spring, for peers Bullet's rigid rows).
  std::string mode = "auto";
  std::shared_ptr<ShapeStore> store = {};  // of all trials of the scene
  int iterations = 10;                     // of Bullet's solver, its own default
  // Called after each step, to follow one trial closely.
  std::function<void(double time, const World&)> watch = {};
};

// "cloud 60 stiff": the method's name on the command line, steps a second, the mode.
std::string trialName(const Trial& trial);

enum class Outcome { Holds, Fails, Cannot };

struct Verdict {
  Outcome outcome = Outcome::Holds;
  double figure = 0, limit = 0;  // what was measured and what it may be, in the rule's unit
  std::string why;               // in a few words, where it fails or cannot
};

// A scene and its rule. `run` builds a world, steps it and measures; it is called from several
// threads at once, each call with a world of its own.
struct StabilityScene {
  std::string name;   // "stack of 10", unique
  std::string group;  // "Erleben", "stacks", "mechanisms", "motion"
  std::string rule;   // what must hold, in words, with the figure's unit: "drift [voxels]"
  std::vector<Method> methods;
  std::vector<double> steps;  // [s]; the first is the one that the quick mode takes
  std::vector<std::string> modes;
  double cost =
      1;  // seconds of work that a trial takes, about: those over kQuickCost are not quick
  std::function<Verdict(const Trial&)> run;
};

constexpr double kQuickCost = 1.5;  // [s]

// A figure that must not pass its limit.
Verdict atMost(double figure, double limit, const std::string& otherwise);
// A figure within a share of what it should be.
Verdict within(double figure, double expected, double share, const std::string& otherwise);

std::vector<StabilityScene> erlebenScenes();    // the ten of Erleben 2018, sizes in DESIGN.md
std::vector<StabilityScene> stackScenes();      // stacks, houses, arches, chains, piles, rest
std::vector<StabilityScene> mechanismScenes();  // screws, pegs, gears, bowls, cradles, inclines
std::vector<StabilityScene> motionScenes();     // rolling, spinning, bouncing, tipping, tunnelling

struct StabilityRow {
  std::string scene, group, rule;
  Trial trial;
  Verdict verdict;
  double seconds = 0;  // that the trial took, others beside it
};

struct StabilitySettings {
  bool quick = false;
  int threads = 2;
  std::string only;    // a part of a scene's name; empty: all
  std::string trials;  // of `trialName`; empty: all
  int iterations = 10;
  std::function<void(double)> progress;
};

// All trials, in the order of the scenes.
std::vector<StabilityRow> runStability(const StabilitySettings& settings);

}  // namespace cloudcontact::program::lab
