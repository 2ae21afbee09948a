// Stability: scenes stepped through time, each with a physical rule and a tolerance.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/options.h"
#include "scene/scene.h"
#include "scene/shape_store.h"
#include "scene/simulation.h"

namespace cloudcontact::program::lab {

// What the steps of a trial's worlds cost, together.
struct TrialCost {
  long steps = 0;
  double narrowPhase = 0;  // [s]
  double wall = 0;         // of whole steps [s]
  // Per step [s]; 0 without steps.
  double narrowPhaseStep() const { return steps > 0 ? narrowPhase / double(steps) : 0; }
  double wallStep() const { return steps > 0 ? wall / double(steps) : 0; }
};

// One way to run a scene.
struct Trial {
  Method method = Method::Cloud;
  double step = 1.0 / 240;  // [s]
  // "stiff": bodies state their stiffness and damping. "auto": none does; clouds take an automatic
  // spring, peers Bullet's rigid constraints.
  std::string mode = "auto";
  std::shared_ptr<ShapeStore> store = {};  // shared by all trials of the scene
  std::optional<int> iterations = {};      // WorldSettings::iterations
  // Called after each step, to observe a single trial.
  std::function<void(double time, const World&)> watch = {};
  std::shared_ptr<TrialCost> cost = {};  // what each world adds its steps to
};

// "cloud 60 stiff": the method's name on the command line, steps per second, mode.
std::string trialName(const Trial& trial);

enum class Outcome { Holds, Fails, Cannot };

struct Verdict {
  Outcome outcome = Outcome::Holds;
  double figure = 0, limit = 0;  // measured value and limit, in the rule's unit
  std::string why;               // a few words, where it fails or cannot run
};

// A scene and its rule. `run` builds a world, steps it and measures. Several threads may call it at
// once: each call has a world of its own.
struct StabilityScene {
  std::string name;   // "stack of 10", unique
  std::string group;  // "Erleben", "stacks", "mechanisms", "motion"
  std::string rule;   // in words, with the figure's unit: "drift [voxels]"
  std::vector<Method> methods;
  std::vector<double> steps;  // [s]; the quick run takes the first
  std::vector<std::string> modes;
  double cost = 1;  // approximate time of a trial [s]; over kQuickCost: not in the quick run
  std::function<Verdict(const Trial&)> run;
  // Its trials run alone, so that what their steps cost compares between methods.
  bool timed = false;
};

constexpr double kQuickCost = 1.5;  // [s]

// Holds if figure <= limit.
Verdict atMost(double figure, double limit, const std::string& otherwise);
// Holds if the figure is within a share of the expected value.
Verdict within(double figure, double expected, double share, const std::string& otherwise);

std::vector<StabilityScene> erlebenScenes();    // the ten of Erleben 2018, and two more
std::vector<StabilityScene> stackScenes();      // stacks, houses, arches, chains, piles, rest
std::vector<StabilityScene> mechanismScenes();  // screws, pegs, gears, bowls, cradles, inclines
std::vector<StabilityScene> motionScenes();     // rolling, spinning, bouncing, tipping, tunneling
// The scenes that are timed: a nut that runs down its bolt, and some of the others.
std::vector<StabilityScene> runningScenes();
std::vector<StabilityScene> allScenes();

struct StabilityRow {
  std::string scene, group, rule;
  Trial trial;
  Verdict verdict;
  double seconds = 0;  // wall time of the trial, with others running beside it
  bool timed = false;  // StabilityScene::timed
  TrialCost cost;
};

struct StabilitySettings {
  bool quick = false;
  int threads = 2;
  std::string only;    // a part of a scene's name; empty: all
  std::string trials;  // a part of trialName(); empty: all
  std::string method;  // the only one, as --method names it; empty: all
  std::optional<int> iterations = {};
  std::function<void(double)> progress;
};

// All trials, in the order of the scenes.
std::vector<StabilityRow> runStability(const StabilitySettings& settings);

}  // namespace cloudcontact::program::lab
