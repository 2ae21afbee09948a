// A cube that lies across the edges of two blocks, turned a little, comes to rest where it touches.
// Samples beyond its own bottom edges must not lift it (tests/contact/edge_sides_test.cpp).
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::edge_rest_test {
namespace {

constexpr double kVoxel = 0.2, kMass = 1000, kStiffness = 5e6, kStep = 1. / 60;

struct Rest {
  double height = 0;   // of the cube's middle above that on rigid blocks [voxels]
  double fastest = 0;  // in the last second [voxels/s]
};

Rest restOn(double degrees, double gap) {
  static const auto field = fieldOf(boxMesh({1, 1, 1}), kVoxel);
  CloudContactSettings settings;
  settings.law = KelvinVoigt{kStiffness, 2 * std::sqrt(kStiffness * kMass)};
  BulletWorld scene(settings);
  NewtonSolver sweeps;
  scene.world.setConstraintSolver(&sweeps);
  const double apart = 0.5 + gap / 2;
  for (const double x : {-apart, apart}) scene.addCloud(field, 0, at({btScalar(x), 0, 0}));
  const btQuaternion turn(btVector3(0, 0, 1), btScalar(degrees * SIMD_PI / 180));
  btRigidBody& cube =
      scene.addCloud(field, kMass, at({btScalar(0.3), 0, btScalar(1 + 0.02 * kVoxel)}, turn));
  Rest rest;
  for (int i = 0; i < 180; ++i) {
    scene.step(kStep);
    if (i >= 120)
      rest.fastest = std::max(rest.fastest, double(cube.getLinearVelocity().length()) / kVoxel);
  }
  rest.height = (cube.getWorldTransform().getOrigin().z() - 1) / kVoxel;
  scene.world.setConstraintSolver(&scene.solver);
  return rest;
}

TEST(EdgeRest, ACubeAcrossTwoBlocksLiesStill) {
  for (const double degrees : {0.0, 0.1, 1.0, 3.0})
    for (const double gap : {0.1, 0.2}) {
      const Rest rest = restOn(degrees, gap);
      EXPECT_LT(std::abs(rest.height), 0.02) << degrees << ' ' << gap;
      EXPECT_LT(rest.fastest, 0.03) << degrees << ' ' << gap;
    }
}

}  // namespace
}  // namespace cloudcontact::testing::edge_rest_test
