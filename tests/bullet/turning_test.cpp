// Contacts of a pair that turns while it slides do not depend on the step: a spike of a ton falls
// over on another's tip, and slides down it with its flank. With long steps it was 0.8 voxel deep
// in it, with short ones 0.5, since no row sees how a turning flank closes on the tip.
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::turning_test {
namespace {

constexpr double kVoxel = 0.05, kHigh = 3, kMiddle = 0.75, kMass = 1000;

// A pyramid on a square of 1 m, its center of mass at the origin.
Mesh spike() {
  Mesh mesh;
  for (const auto& [x, y] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
    mesh.vertices.emplace_back(x, y, -kMiddle);
  mesh.vertices.emplace_back(0, 0, kHigh - kMiddle);
  mesh.triangles = {{2, 1, 0}, {3, 2, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

const btVector3 kTip(0, 0, btScalar(kHigh - kMiddle));

// How deep the tip of `one` is in `other` [voxels].
double tipIn(const btRigidBody& one, const btRigidBody& other) {
  const btVector3 tip = other.getWorldTransform().invXform(one.getWorldTransform() * kTip);
  const double out = std::hypot(kHigh, 0.5);
  double depth = tip.z() + kMiddle;
  for (int axis = 0; axis < 2; ++axis)
    depth = std::min(depth, (0.5 * (kTip.z() - tip.z()) - kHigh * std::abs(tip[axis])) / out);
  return depth / kVoxel;
}

// The deepest that either tip gets in a second, from `aside` [m] beside the tip below. `exact`: as
// clouds, else as hulls.
double deepest(double step, double aside, bool exact) {
  static const auto field = fieldOf(spike(), kVoxel);
  CloudContactSettings settings;
  const double k = kMass * 9.81 / 0.005;  // sags by a tenth of a voxel
  settings.law = KelvinVoigt{k, 2 * std::sqrt(k * kMass)};
  BulletWorld scene(settings);
  NewtonSolver sweeps;
  scene.world.setConstraintSolver(&sweeps);
  const auto spikeShape = [&] {
    return exact ? exactCloud(field) : std::make_unique<CloudShape>(field);
  };
  btRigidBody& below = scene.add(spikeShape(), 0, at({0, 0, 0}));
  const btQuaternion over(btVector3(1, 0, 0), SIMD_PI);
  const btVector3 above(btScalar(aside), btScalar(0.7 * aside),
                        btScalar(2 * (kHigh - kMiddle) + 0.01));
  btRigidBody& falls = scene.add(spikeShape(), kMass, at(above, over));
  for (btRigidBody* body : {&below, &falls}) body->setFriction(0.5);
  double most = -1;
  for (double time = 0; time < 1; time += step) {
    scene.step(step);
    most = std::max({most, tipIn(below, falls), tipIn(falls, below)});
  }
  scene.world.setConstraintSolver(&scene.solver);
  EXPECT_EQ(scene.clouds.statistics().shapes > 0, !exact);
  return most;
}

TEST(Turning, AFallingSpikeIsNoDeeperWithLongSteps) {
  for (const double aside : {1e-4, 1e-3, 2e-3, 3e-3})
    for (const double step : {1. / 60, 1. / 100})
      for (const bool exact : {true, false})
        EXPECT_LT(deepest(step, aside, exact), 0.55) << aside << ' ' << step << ' ' << exact;
}

}  // namespace
}  // namespace cloudcontact::testing::turning_test
