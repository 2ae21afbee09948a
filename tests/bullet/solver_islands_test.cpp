// NewtonSolver: what happens to bodies does not depend on others that they never meet.
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include "bullet/bullet_world.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::testing::solver_islands_test {
namespace {

constexpr double kVoxel = 0.1;

std::shared_ptr<const SurfaceField> cube() {
  static const auto field = fieldOf(boxMesh({1, 1, 1}), kVoxel);
  return field;
}

// As high and wide as the cube, a plate with four feet below and four above: a patch for each.
std::shared_ptr<const SurfaceField> table() {
  static const auto field = [] {
    Mesh all = test::boxMesh({-0.5, -0.5, -0.2}, {0.5, 0.5, 0.2});
    for (const double x : {-0.5, 0.25})
      for (const double y : {-0.5, 0.25})
        all = test::joined(all, test::boxMesh({x, y, -0.5}, {x + 0.25, y + 0.25, 0.5}));
    return fieldOf(all, kVoxel);
  }();
  return field;
}

// The state, after a second, of a tower that rocks: a cube, a table and a cube, beside `others`.
std::uint64_t tower(int others) {
  BulletWorld scene;
  NewtonSolver solver;
  scene.world.setConstraintSolver(&solver);
  std::vector<btRigidBody*> bodies;
  scene.addGround();
  for (int n = 0; n <= others; ++n)
    for (int i = 0; i < 3; ++i) {
      btRigidBody& body =
          scene.addCloud(i == 1 ? table() : cube(), 1 + i,
                         at({btScalar(0.03 * i), btScalar(10 * n), btScalar(0.5 + i)}));
      body.setLinearVelocity({btScalar(0.3 * i), btScalar(0.2 + 0.05 * n), 0});
      bodies.push_back(&body);
    }
  for (int n = 0; n < 60; ++n) scene.step(1.0 / 60);
  Hash hash;
  for (int i = 0; i < 3; ++i) {
    hash.add(bodies[i]->getWorldTransform().getOrigin());
    hash.add(bodies[i]->getWorldTransform().getRotation());
    hash.add(bodies[i]->getLinearVelocity());
    hash.add(bodies[i]->getAngularVelocity());
  }
  return hash.value();
}

TEST(SolverIslands, BodiesDoNotFeelOthersThatTheyNeverMeet) {
  const std::uint64_t alone = tower(0);
  for (const int others : {1, 2, 5, 9}) EXPECT_EQ(tower(others), alone) << others;
}

}  // namespace
}  // namespace cloudcontact::testing::solver_islands_test
