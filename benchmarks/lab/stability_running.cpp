// A nut that runs down its bolt without friction, as far and as fast as its energy lets it: where
// methods reach the same end, their cost a step compares.
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "lab/trial_runs.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program::lab {
namespace running {

constexpr double kPi = std::numbers::pi;
constexpr double kVoxel = 0.25e-3, kSeconds = 0.5;
constexpr double kPlay = 0.1e-3;  // radial clearance of the threads [m]
constexpr double kMass = 0.0324;  // of an M16 nut in steel [kg]

struct NutScene {
  SceneDescription description;
  double perRadian = 0;     // [m] that the nut goes down while it turns by 1 rad
  double acceleration = 0;  // [rad/s^2]
};

// m g p = (I + m p^2) a, with p the way per radian.
double freeAcceleration(const Mesh& nut, double perRadian) {
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  const MassProperties body = digitize(nut, settings).massProperties();
  const double about = body.inertia(2, 2) / body.mass * kMass;
  return kMass * kGravity * perRadian / (about + kMass * perRadian * perRadian);
}

NutScene nutScene(const Trial& trial) {
  Thread thread;
  // Fewer triangles for peers, whose time depends on them.
  thread.segments = usesClouds(trial.method) ? 96 : 48;
  Thread nutThread = thread;
  nutThread.clearance = kPlay;
  const auto bolt = std::make_shared<const Mesh>(boltMesh(thread, 24e-3));
  const auto nut = std::make_shared<const Mesh>(nutMesh(nutThread, 8e-3, 24e-3));
  NutScene scene;
  scene.perRadian = thread.lead() / (2 * kPi);
  scene.acceleration = freeAcceleration(*nut, scene.perRadian);
  // A whole number of pitches up, less the axial play and a tenth of a voxel: the flanks are about
  // to touch, and no spring is pressed at the start.
  const double start = 12e-3 - kPlay * std::tan(thread.flankAngle / 2) + 0.1 * kVoxel;
  addBody(scene.description, "bolt", meshNamed("bolt", bolt), Vec3::Zero(), {0, 0}, trial);
  addBody(scene.description, "nut", meshNamed("nut", nut), Vec3(0, 0, start),
          springMatter(kMass, 0, 2e4, 0.5), trial);
  return scene;
}

Verdict runsDown(const Trial& trial) {
  if (trial.method == Method::Gjk) throw std::runtime_error("cannot: a nut's hull has no hole");
  const NutScene scene = nutScene(trial);
  MovingWorld motion(scene.description, trial, kVoxel);
  const double start = motion.body(1).pose.position.z();
  double angle = 0, last = 0;
  while (motion.time() < kSeconds - 0.5 * trial.step) {
    motion.step();
    const Vec3 x = motion.body(1).pose.orientation * Vec3::UnitX();
    const double now = std::atan2(x.y(), x.x());
    angle += std::remainder(now - last, 2 * kPi);
    last = now;
  }
  const double expected = -scene.acceleration * kSeconds * kSeconds / 2;
  const double fell = start - motion.body(1).pose.position.z();
  if (std::abs(fell + angle * scene.perRadian) > 0.5 * kVoxel)
    return {Outcome::Fails, angle, expected, "leaves its thread"};
  const Verdict verdict = within(
      angle, expected, 0.05, std::abs(angle) < std::abs(expected) ? "is held back" : "runs ahead");
  return failIfGains(verdict, motion.gained(), kMass * kGravity * fell);
}

}  // namespace running

std::vector<StabilityScene> runningScenes() {
  return {{"nut down its bolt",
           "mechanisms",
           "a nut without friction turns in 0.5 s as far as its energy says, within 5 %, and "
           "stays on its thread within half a voxel [rad]",
           {Method::Cloud, Method::Paper, Method::Gimpact, Method::Gjk},
           {kStep1000, kStep240},
           {"stiff", "auto"},
           kQuickCost,
           running::runsDown,
           true}};
}

}  // namespace cloudcontact::program::lab
