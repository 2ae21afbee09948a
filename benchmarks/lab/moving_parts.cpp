// A stepped world, energy and bisection.
#include "lab/moving_parts.h"

#include <cloudcontact/law/automatic_spring.h>

#include <cmath>
#include <sstream>

namespace cloudcontact::program::lab {
Matter springy(double mass, double friction, double stiffness, double ratio) {
  return {mass, friction, stiffness, 2 * ratio * std::sqrt(stiffness * mass)};
}

bool isStiff(const Trial& trial) {
  return trial.mode == "stiff";
}

SceneBody& addBody(SceneDescription& scene, const std::string& name, const SceneGeometry& geometry,
                   const Vec3& position, const Matter& matter, const Trial& trial) {
  SceneBody body;
  body.name = name;
  body.model = int(scene.bodies.size());
  body.pose.position = position;
  body.isStatic = matter.mass == 0;
  if (matter.mass > 0) body.mass = matter.mass;
  body.friction = matter.friction;
  if (isStiff(trial) && matter.stiffness > 0) {
    body.stiffness = matter.stiffness;
    body.damping = matter.damping;
  }
  body.collisions.push_back({name, Pose(), geometry});
  scene.bodies.push_back(std::move(body));
  return scene.bodies.back();
}

SceneBody& addPlane(SceneDescription& scene, double friction) {
  return addBody(scene, "floor", ScenePlane{}, Vec3::Zero(), {0, friction}, {});
}

double sagOf(const Trial& trial, const Matter& matter, double force, double voxel) {
  if (isStiff(trial)) return force / matter.stiffness;
  if (trial.method != Method::Cloud) return 0;  // Bullet's rigid rows
  return automaticSpring(matter.mass, matter.mass * kGravity, voxel, trial.step).sag(force);
}

MovingWorld::MovingWorld(const SceneDescription& scene, const Trial& trial, double voxel)
    : world_(scene, worldSettings(trial, voxel)), step_(trial.step), watch_(trial.watch) {}

void MovingWorld::step() {
  world_.step(step_);
  const double energy = world_.moment().energy.ofBodies();
  if (steps_++ == 0) start_ = most_ = energy;
  most_ = std::max(most_, energy);
  if (watch_) watch_(time(), world_);
}

void MovingWorld::run(double seconds, const std::function<bool()>& enough) {
  while (time() < seconds - 0.5 * step_ && !(enough && enough())) step();
}

Verdict unlessItGains(const Verdict& verdict, double gained, double scale) {
  if (verdict.outcome != Outcome::Holds || gained <= 0.01 * scale) return verdict;
  std::ostringstream why;
  why.precision(2);
  why << "gained " << 100 * gained / scale << " % energy";
  return {Outcome::Fails, verdict.figure, verdict.limit, why.str()};
}

Verdict atLeast(double figure, double limit, const std::string& otherwise) {
  const bool holds = figure >= limit;  // not so for NaN
  return {holds ? Outcome::Holds : Outcome::Fails, figure, limit, holds ? "" : otherwise};
}

double turningPoint(double low, double high, int halvings,
                    const std::function<bool(double)>& holds) {
  if (!holds(low)) return low;
  if (holds(high)) return high;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace cloudcontact::program::lab
