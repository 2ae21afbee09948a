// Pairs that stay apart are not searched while their gap lasts (kept_gap.h). Their bodies move
// exactly as in a world that keeps no gaps.
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

TEST(KeptGapWorld, MovesAsWithoutKeptGaps) {
  Rods kept, without;
  int steps = 0;
  for (; steps < 240 && kept.points().empty(); ++steps) {
    // Bullet forgets the pairs, and with them what they keep.
    for (btRigidBody* body : without.bodies)
      without.broadphase.getOverlappingPairCache()->cleanProxyFromPairs(body->getBroadphaseHandle(),
                                                                        &without.dispatcher);
    kept.step(kStep), without.step(kStep);
    ASSERT_EQ(kept.points().size(), without.points().size()) << "step " << steps;
    for (int k = 0; k < 2; ++k)
      ASSERT_TRUE(kept.bodies[k]->getWorldTransform() == without.bodies[k]->getWorldTransform())
          << "step " << steps;
  }
  EXPECT_GT(steps, 40);
  EXPECT_LT(steps, 240);
  const std::size_t searched = kept.clouds.statistics().pairs,
                    ofAll = without.clouds.statistics().pairs;
  EXPECT_GT(ofAll, 60u);
  EXPECT_LT(2 * searched, ofAll);
}

}  // namespace
}  // namespace cloudcontact::testing::kept_gap_world_test
