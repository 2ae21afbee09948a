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
  double spin = 0, gained = 0, height = 0;  // [rad/s] in the last half second; [J]; [m]
};

// A table of 1 kg that is set down.
Stood stand(double stiffness, double step) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, 0};
  BulletWorld scene(settings);
  NewtonSolver solver;
  scene.world.setConstraintSolver(&solver);
  scene.addGround();
  const btRigidBody& body = scene.addCloud(table(), 1, at({0, 0, btScalar(kCenter)}));
  Stood stood;
  const int steps = static_cast<int>(std::lround(1.5 / step));
  for (int i = 0; i < steps; ++i) {
    scene.step(step);
    stood.height = body.getWorldTransform().getOrigin().z();
    stood.gained = std::max(stood.gained, 0.5 * body.getLinearVelocity().length2() +
                                              kGravity * (stood.height - kCenter));
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

}  // namespace
}  // namespace cloudcontact::testing::point_law_test
