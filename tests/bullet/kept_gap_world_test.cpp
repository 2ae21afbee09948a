// Pairs that stay apart are not searched while their gap lasts (kept_gap.h), and go the way that
// they go if every step meets them anew.
#include <gtest/gtest.h>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::kept_gap_world_test {
namespace {

constexpr double kVoxel = 0.01, kStep = 1. / 240;

// Two rods in a cross, which fall past and onto a beam; most of the time their boxes meet.
struct Rods : BulletWorld {
  Rods() {
    const auto rod = fieldOf(boxMesh({0.6, 0.08, 0.08}), kVoxel);
    const btQuaternion leans(btVector3(0, 1, 0), btScalar(0.7));
    addCloud(rod, 0, at({0, 0, 0}, leans));
    bodies[0] = &addCloud(rod, 1, at({btScalar(0.1), btScalar(0.25), btScalar(0.5)}, leans));
    bodies[1] = &addCloud(rod, 1, at({btScalar(-0.05), btScalar(-0.02), btScalar(0.9)}));
    for (btRigidBody* body : bodies) body->setAngularVelocity({1, 2, 3});
  }
  btRigidBody* bodies[2];
};

TEST(KeptGapWorld, GoesAsIfEveryStepMetAnew) {
  Rods kept, anew;
  int steps = 0;
  for (; steps < 240 && kept.points().empty(); ++steps) {
    for (btRigidBody* body : anew.bodies)
      anew.broadphase.getOverlappingPairCache()->cleanProxyFromPairs(body->getBroadphaseHandle(),
                                                                     &anew.dispatcher);
    kept.step(kStep), anew.step(kStep);
    ASSERT_EQ(kept.points().size(), anew.points().size()) << "step " << steps;
    for (int k = 0; k < 2; ++k)
      ASSERT_TRUE(kept.bodies[k]->getWorldTransform() == anew.bodies[k]->getWorldTransform())
          << "step " << steps;
  }
  EXPECT_GT(steps, 40);
  EXPECT_LT(steps, 240);
  const std::size_t searched = kept.clouds.statistics().pairs,
                    ofAll = anew.clouds.statistics().pairs;
  EXPECT_GT(ofAll, 60u);
  EXPECT_LT(2 * searched, ofAll);
}

}  // namespace
}  // namespace cloudcontact::testing::kept_gap_world_test
