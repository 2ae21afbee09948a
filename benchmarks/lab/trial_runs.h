// How a stability scene is run and judged: a planned run whose result is checked by rules (judged),
// or a world that the scene steps itself (MovingWorld).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lab/stability.h"
#include "lab/trial_bodies.h"
#include "scene/penetration.h"

namespace cloudcontact::program::lab {

constexpr double kStep60 = 1.0 / 60, kStep240 = 1.0 / 240, kStep1000 = 1e-3;  // [s]

// A body counts as in place within half a voxel: a cloud does not know its surface any better.
constexpr double kInPlace = 0.5;  // [voxels]

struct Plan {
  SceneDescription scene;  // judged() sets the bodies' names and models
  double voxel = 0;        // [m]
  double seconds = 1;
  Spring spring;       // of every pair, in the mode "stiff"
  int instants = 200;  // at which penetration is measured
  // For piles: measures penetration only of bodies near each other.
  bool many = false;
  std::function<void(double time, const World&)> observe;
};

// The result of a run, for its rules. Distances in voxels.
struct RunResult {
  SceneDescription scene;
  SimulationReport report;
  double voxel = 0;

  double moved(int body) const { return moved(body, scene.bodies[body].pose.position); }
  double moved(int body, const Vec3& from) const;  // [voxels]
  double aside(int body) const;                    // horizontal [voxels]
  double turned(int body) const;                   // since the start, about any axis [deg]
  double deepest() const { return report.maxPenetration / voxel; }  // [voxels]
  // Energy gained since the start, as the height by which it would lift all moving bodies.
  double lifted() const;  // [voxels]
};

struct Rule {
  double figure = 0, limit = 0;
  std::string what;  // "tilt [deg]"
};
// At most half a voxel.
Rule penetrationRule(const RunResult& result);
// At most a tenth of a voxel of lift: sag and surface bumps account for that much.
Rule energyRule(const RunResult& result);
// The rotation that moves the end of a lever by half a voxel.
double turnLimit(double voxel, double lever);  // [deg]

// Runs the plan and checks its rules. All must hold; the verdict's figure is the first rule's. A
// world whose state is no longer finite fails.
using Rules = std::function<std::vector<Rule>(const RunResult&)>;
Verdict judged(const Trial& trial, Plan plan, const Rules& rules);

// A world that the scene steps and observes itself. Tracks the bodies' energy.
class MovingWorld {
 public:
  MovingWorld(const SceneDescription& scene, const Trial& trial, double voxel);

  void step();
  // Steps until `seconds` have passed since the start, or `enough` returns true.
  void run(double seconds, const std::function<bool()>& enough = {});

  double time() const { return steps_ * step_; }
  BodyState body(int index) const { return world_.state(std::size_t(index)); }
  const World& world() const { return world_; }
  // Maximum of the bodies' energy since the start of the first step, less their energy there and
  // what its springs hold: where surfaces are about to touch, their noise may press one [J].
  double gained() const { return most_ - start_; }

 private:
  World world_;
  double step_;
  std::function<void(double, const World&)> watch_;
  std::shared_ptr<TrialCost> cost_;
  long steps_ = 0;
  double start_ = 0, most_ = 0;
};

// Turns a verdict that holds into a failure if more than a hundredth of `scale` [J] was gained.
Verdict failIfGains(const Verdict& verdict, double gained, double scale);
// Holds if figure >= limit.
Verdict atLeast(double figure, double limit, const std::string& otherwise);

// Bisection: where `holds` changes from true at `low` to false at `high`. Returns `low` or `high`
// where it does not change between them.
double turningPoint(double low, double high, int halvings,
                    const std::function<bool(double)>& holds);

}  // namespace cloudcontact::program::lab
