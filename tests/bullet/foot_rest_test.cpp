// A peg with a chamfered foot that is dropped a little tilted onto a plane comes to rest. The
// normals of the foot's rim lean outwards as a ball's do, but it does not roll on them: its points
// must stand apart, or each step sees only afterwards how far the peg has turned, and it rocks for
// ever, and more and more.
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bullet/bullet_world.h"
#include "mesh/turned_mesh.h"

namespace cloudcontact::testing::foot_rest_test {
namespace {

constexpr double kRadius = 0.004, kHeight = 0.05, kChamfer = 0.0005, kMass = 0.02;

struct Rest {
  double spin = 0;  // root mean square in the last half second [rad/s]
  double tilt = 0;  // of the axis at the end [rad]
};

Rest rest(double voxel, double step, double stiffness) {
  const double r = kRadius, h = kHeight / 2, c = kChamfer;
  const auto field = fieldOf(
      test::turnedMesh({{0, -h}, {r - c, -h}, {r, c - h}, {r, h - c}, {r - c, h}, {0, h}}, 144),
      voxel);
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, std::sqrt(stiffness * kMass)};
  BulletWorld scene(settings);
  NewtonSolver solver;
  scene.world.setConstraintSolver(&solver);
  scene.addGround();
  const btQuaternion tilt(btVector3(btScalar(0.89), btScalar(-0.45), 0), btScalar(0.00224));
  btRigidBody& peg = scene.addCloud(field, kMass, at({0, 0, btScalar(h + 0.0005)}, tilt));
  Rest found;
  const int steps = static_cast<int>(3 / step);
  int last = 0;
  for (int i = 0; i < steps; ++i) {
    scene.step(step);
    if (i * step < 2.5) continue;
    found.spin += double(peg.getAngularVelocity().length2());
    ++last;
  }
  found.spin = std::sqrt(found.spin / last);
  found.tilt = std::acos(std::min(1.0, double(peg.getWorldTransform().getBasis()[2].z())));
  scene.world.setConstraintSolver(&scene.solver);
  return found;
}

// On springs that its weight presses by a hundredth of a voxel, half critically damped. On stiffer
// ones it stands on single bumps of the fits, and may rock on those (docs/limits.md).
TEST(FootRest, AChamferedPegStandsStill) {
  for (const double voxel : {0.0004, 0.0005, 0.0006})
    for (const double step : {0.001, 1. / 240, 1. / 120}) {
      const Rest found = rest(voxel, step, 2e4);
      EXPECT_LT(found.spin, 0.002) << voxel << ' ' << step;
      EXPECT_LT(found.tilt, 0.005) << voxel << ' ' << step;
    }
}

}  // namespace
}  // namespace cloudcontact::testing::foot_rest_test
