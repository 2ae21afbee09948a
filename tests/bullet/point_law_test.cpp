// PointLaw: a body that stands on tips rests at any stiffness and step, sunk by its weight over its
// stiffness.
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"
#include "mesh/feet_meshes.h"

namespace cloudcontact::testing::point_law_test {
namespace {

constexpr double kVoxel = 5e-3, kGravity = 9.81;

constexpr double kHigh = 0.06, kCenter = 0.75 * kHigh;  // of the tips' pyramids [m]

std::shared_ptr<const SurfaceField> table() {
  Pose down;
  down.position.z() = -kCenter;
  static const auto field =
      fieldOf(test::feetMesh(transformed(test::tipMesh(kHigh), down), 0.2, 0.15), kVoxel);
  return field;
}

struct Stood {
  double spin = 0;    // [rad/s] in the last half second
  double gained = 0;  // [J]
  double height = 0;  // [m] at the end
  double lowest = 1;  // [m] after the first half second
};

// A table of 1 kg that is set down, turned about the vertical.
Stood stand(double stiffness, double step, double turned = 0) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, 0};
  BulletWorld scene(settings);
  NewtonSolver solver;
  scene.world.setConstraintSolver(&solver);
  scene.addGround();
  const btRigidBody& body = scene.addCloud(
      table(), 1, at({0, 0, btScalar(kCenter)}, btQuaternion({0, 0, 1}, btScalar(turned))));
  Stood stood;
  const int steps = static_cast<int>(std::lround(1.5 / step));
  for (int i = 0; i < steps; ++i) {
    scene.step(step);
    stood.height = body.getWorldTransform().getOrigin().z();
    stood.gained = std::max(stood.gained, 0.5 * body.getLinearVelocity().length2() +
                                              kGravity * (stood.height - kCenter));
    if (i * step >= 0.5) stood.lowest = std::min(stood.lowest, stood.height);
    if (i * step >= 1)
      stood.spin = std::max(stood.spin, double(body.getAngularVelocity().length()));
  }
  scene.world.setConstraintSolver(&scene.solver);
  return stood;
}

TEST(PointLaw, ATableOnFourTipsRests) {
  const double highest = stand(1e7, 1. / 240).height;
  for (const double stiffness : {1e5, 1e6, 1e7})
    for (const double step : {1. / 60, 1. / 240}) {
      const Stood stood = stand(stiffness, step);
      EXPECT_LT(stood.spin, 5e-4) << stiffness << ", " << step;
      EXPECT_LT(stood.gained, 1e-6) << stiffness << ", " << step;
      const double sag = kGravity / stiffness - kGravity / 1e7;
      EXPECT_NEAR(highest - stood.height, sag, 0.05 * sag + 2e-7) << stiffness << ", " << step;
    }
}

// A foot that is lifted by the noise of the fits is still near: without it the table would fall for
// a step.
TEST(PointLaw, ATableRestsHoweverItIsTurned) {
  for (const double turned : {0.13, 0.26, 0.52, 0.78, 1.04, 1.17, 1.43}) {
    const double highest = stand(1e7, 1. / 240, turned).height;
    for (const double stiffness : {1e5, 1e6, 1e7, 1e8})
      for (const double step : {1. / 60, 1. / 240}) {
        SCOPED_TRACE(::testing::Message() << stiffness << ", " << step << ", " << turned);
        const Stood stood = stand(stiffness, step, turned);
        EXPECT_LT(stood.spin, 1e-3);
        EXPECT_LT(stood.gained, 1e-6);
        EXPECT_GT(stood.lowest, stood.height - 1e-3 * kVoxel);
        const double sag = kGravity / stiffness - kGravity / 1e7;
        EXPECT_NEAR(highest - stood.height, sag, 0.05 * std::abs(sag) + 2e-4 * kVoxel);
      }
  }
}

}  // namespace
}  // namespace cloudcontact::testing::point_law_test
