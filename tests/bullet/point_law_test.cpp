// PointLaw: bodies that stand on pointed places rest at any stiffness and step, as those on faces
// do, and no law is changed by it where bodies do not turn.
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"
#include "mesh/feet_meshes.h"

namespace cloudcontact::testing::point_law_test {
namespace {

constexpr double kVoxel = 5e-3, kGravity = 9.81;

std::shared_ptr<const SurfaceField> table() {
  static const auto field = fieldOf(test::feetMesh(test::tipMesh(0.06), 0.2, 0.15), kVoxel);
  return field;
}

struct Stood {
  double spin = 0, gained = 0, sinks = 0;  // [rad/s] in the last half second; [J]; [m]
};

// Tables on each other's tops that have been set down.
Stood stand(double stiffness, double step, int tables) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, 0};
  BulletWorld scene(settings);
  NewtonSolver solver;
  scene.world.setConstraintSolver(&solver);
  scene.addGround();
  std::vector<btRigidBody*> bodies;
  for (int i = 0; i < tables; ++i)
    bodies.push_back(&scene.addCloud(table(), 1, at({0, 0, btScalar(0.06 * i)})));
  const auto energy = [&] {
    double sum = 0;
    for (const btRigidBody* body : bodies)
      sum += 0.5 * body->getLinearVelocity().length2() +
             kGravity * body->getWorldTransform().getOrigin().z();
    return sum;
  };
  const double start = energy();
  Stood stood;
  const int steps = static_cast<int>(std::lround(1.5 / step));
  for (int i = 0; i < steps; ++i) {
    scene.step(step);
    stood.gained = std::max(stood.gained, energy() - start);
    if (i * step < 1) continue;
    for (const btRigidBody* body : bodies)
      stood.spin = std::max(stood.spin, double(body->getAngularVelocity().length()));
  }
  stood.sinks = -bodies.front()->getWorldTransform().getOrigin().z();
  scene.world.setConstraintSolver(&scene.solver);
  return stood;
}

// With the slopes alone it rattles at 0.01 to 0.08 rad/s.
TEST(PointLaw, ATableOnFourTipsRests) {
  for (const double stiffness : {1e5, 1e6, 1e7})
    for (const double step : {1. / 60, 1. / 240}) {
      const Stood stood = stand(stiffness, step, 1);
      EXPECT_LT(stood.spin, 5e-4) << stiffness << ", " << step;
      EXPECT_LT(stood.gained, 1e-6) << stiffness << ", " << step;
      EXPECT_NEAR(stood.sinks, kGravity / stiffness, 0.05 * kGravity / stiffness + 1e-6);
    }
}

}  // namespace
}  // namespace cloudcontact::testing::point_law_test
