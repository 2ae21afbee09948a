// What the scenes of mechanisms and of motion share: bodies, a stepped world, energy, bisection.
#pragma once

#include <functional>
#include <optional>

#include "lab/stability.h"
#include "lab/trial_bodies.h"

namespace cloudcontact::program::lab {

constexpr double kStep60 = 1.0 / 60, kStep240 = 1.0 / 240, kStep1000 = 1e-3;  // [s]

// A body's mass and surface; stiffness and damping are those of its pairs with bodies that state
// none, and hold in the mode "stiff" alone.
struct Matter {
  double mass = 0;  // [kg], 0: static
  double friction = 0.5;
  double stiffness = 0;  // [N/m], 0: states none
  double damping = 0;    // [N s/m]
};
// k, and c at the given damping ratio.
Matter springy(double mass, double friction, double stiffness, double ratio);

bool isStiff(const Trial& trial);
// Bodies of one model do not touch: each gets its own by standing in `scene`.
SceneBody& addBody(SceneDescription& scene, const std::string& name, const SceneGeometry& geometry,
                   const Vec3& position, const Matter& matter, const Trial& trial);
SceneBody& addPlane(SceneDescription& scene, double friction);

// How deep a pair that carries `force` stands in each other when it rests [m].
double sagOf(const Trial& trial, const Matter& matter, double force, double voxel);

// A world that is stepped and watched.
class MovingWorld {
 public:
  MovingWorld(const SceneDescription& scene, const Trial& trial, double voxel);

  void step();
  // Until `seconds` have passed since the start, or `enough` says so.
  void run(double seconds, const std::function<bool()>& enough = {});

  double time() const { return steps_ * step_; }
  BodyState body(int index) const { return world_.state(std::size_t(index)); }
  const World& world() const { return world_; }
  // The most that the bodies' energy has stood above the start's [J].
  double gained() const { return most_ - start_; }

 private:
  World world_;
  double step_;
  std::function<void(double, const World&)> watch_;
  long steps_ = 0;
  double start_ = 0, most_ = 0;
};

// A verdict that holds, but not where a scene gained more than a hundredth of `scale` [J].
Verdict unlessItGains(const Verdict& verdict, double gained, double scale);
// A figure that must reach its limit.
Verdict atLeast(double figure, double limit, const std::string& otherwise);

// Where `holds` turns from true at `low` to false at `high`, after this many halvings; `low` or
// `high` itself where it does not turn between them.
double turningPoint(double low, double high, int halvings,
                    const std::function<bool(double)>& holds);

}  // namespace cloudcontact::program::lab
