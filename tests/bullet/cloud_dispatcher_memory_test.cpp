// Once its pairs are known CloudDispatcher allocates nothing in a step.
#include "bullet/dispatch_stage.h"

#include <gtest/gtest.h>

#include "base/counted_new.h"

namespace cloudcontact::testing::cloud_dispatcher_memory_test {
namespace {

constexpr double kVoxel = 1e-3, kAcross = 20e-3, kHeight = 10e-3;

// Pairs of nuts, pressed half a voxel into the ground and each other, some in compounds.
void lay(Stage& stage) {
  const auto field = fieldOf(plainNut(kAcross, kAcross / 2, kHeight), kVoxel);
  stage.addGround();
  for (int i = 0; i < 32; ++i) {
    const btVector3 place(btScalar(1.5 * kAcross * (i / 2 % 4)), btScalar(1.5 * kAcross * (i / 8)),
                          btScalar((kHeight - kVoxel / 2) * (0.5 + i % 2)));
    std::unique_ptr<btCollisionShape> shape = std::make_unique<CloudShape>(field);
    if (i % 4 == 3) {
      auto compound = std::make_unique<btCompoundShape>();
      compound->addChildShape(at({0, 0, 0}), stage.own(std::move(shape)));
      shape = std::move(compound);
    }
    stage.add(std::move(shape), 0.03, at(place));
  }
}

TEST(CloudDispatcherMemory, NothingIsAllocatedInAStep) {
  Stage stage(3);
  lay(stage);
  std::size_t before = 0, contacts = 0;
  for (int k = 0; k < 40; ++k) {
    // Every body to and fro by a tenth of a voxel.
    for (std::size_t i = 1; i < stage.bodies.size(); ++i) {
      const double way = (k % 2 ? 0.1 : -0.1) * kVoxel, angle = 0.7 * double(i);
      stage.bodies[i]->setWorldTransform(
          at(stage.bodies[i]->getWorldTransform().getOrigin() +
             btVector3(btScalar(way * std::cos(angle)), btScalar(way * std::sin(angle)), 0)));
    }
    if (k == 10) before = allocations;
    stage.world.performDiscreteCollisionDetection();
    contacts += static_cast<std::size_t>(stage.dispatcher->getNumManifolds());
  }
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_GT(contacts, 40u * 30);
  EXPECT_GT(stage.hitRate(), 0.99);
}

}  // namespace
}  // namespace cloudcontact::testing::cloud_dispatcher_memory_test
