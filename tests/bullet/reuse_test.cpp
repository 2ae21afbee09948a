// Contacts that move with their bodies in place of a search (CloudContactSettings::reuseMotion):
// bodies rest, slide and topple as with a search in every step, energy does not grow, and what
// changes between two steps is met.
#include <cloudcontact/law/tissue.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "bullet/bullet_world.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing::reuse_test {
namespace {

constexpr double kVoxel = 0.01, kStep = 1. / 240;

CloudContactSettings reusing(double motion) {
  CloudContactSettings settings;
  settings.reuseMotion = motion;
  return settings;
}

const auto& cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}

const auto& slabField() {
  static const auto field = fieldOf(boxMesh({0.6, 0.4, 0.1}), kVoxel);
  return field;
}

double height(const btRigidBody& body) {
  return double(body.getWorldTransform().getOrigin().z());
}

// A cube on a slab that is a cloud, too.
struct Scene : BulletWorld {
  explicit Scene(double motion, double above = 0.1)
      : BulletWorld(reusing(motion)),
        slab(addCloud(slabField(), 0, at({0, 0, btScalar(-0.05)}))),
        cube(addCloud(cubeField(), 1, at({0, 0, btScalar(above)}, btQuaternion({0, 0, 1}, 0.3f)))) {
  }
  void run(double seconds) {
    for (int i = 0; i < seconds / kStep; ++i) step(kStep);
  }
  std::size_t searches() const {
    const CloudContactStatistics made = clouds.statistics();
    return made.pairs - made.reused;
  }
  // Whether a step searches.
  bool searchesNow() {
    const std::size_t before = searches();
    step(kStep);
    return searches() > before;
  }
  btRigidBody &slab, &cube;
};

// The reports of pairs add up to the statistics, those that have parted included.
TEST(Reuse, ReportsAddUp) {
  CloudContactSettings settings = reusing(0.02);
  settings.keepReports = true;
  BulletWorld world(settings);
  btRigidBody& slab = world.addCloud(slabField(), 0, at({0, 0, btScalar(-0.05)}));
  btRigidBody& cube = world.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
  for (int i = 0; i < 240; ++i) world.step(kStep);
  cube.setLinearVelocity({0, 0, 3});
  for (int i = 0; i < 240; ++i) world.step(kStep);  // flies off and comes back
  cube.setCenterOfMassTransform(at({0, 0, 5}));
  cube.setLinearVelocity({0, 0, 0});
  world.step(kStep);
  world.step(kStep);
  const std::vector<PairReport> pairs = world.clouds.pairs();
  ASSERT_EQ(pairs.size(), 1u) << "one row, though they met twice";
  const PairReport& pair = pairs[0];
  EXPECT_TRUE((pair.a == &slab && pair.b == &cube) || (pair.a == &cube && pair.b == &slab));
  const CloudContactStatistics all = world.clouds.statistics();
  EXPECT_EQ(pair.answers(), all.pairs);
  EXPECT_EQ(pair.moved, all.reused);
  EXPECT_GT(pair.moved, 100u);
  EXPECT_GT(pair.searched, 10u);
  EXPECT_EQ(pair.shapes, 0u);
  EXPECT_NEAR(pair.seconds, all.seconds, 1e-9);
  EXPECT_EQ(pair.samples,
            pair.searched * (slabField()->sampleCount() + cubeField()->sampleCount()));
  EXPECT_LT(pair.work.samples, pair.samples);
  EXPECT_GT(pair.expectedError, 0);
  EXPECT_LT(pair.expectedError, 0.6 * kVoxel);
}

TEST(Reuse, PartedPairsLeaveTheReports) {
  Scene scene(0.02);
  scene.run(0.1);
  EXPECT_EQ(scene.clouds.pairs().size(), 1u);
  scene.cube.setCenterOfMassTransform(at({0, 0, 5}));
  scene.step(kStep);
  scene.step(kStep);
  EXPECT_TRUE(scene.clouds.pairs().empty());
}

TEST(Reuse, ARestingCubeIsHardlySearchedAndRestsAsStill) {
  Scene fresh(0), moved(0.02);
  fresh.run(10);
  moved.run(10);
  EXPECT_EQ(fresh.clouds.statistics().reused, 0u);
  moved.clouds.resetStatistics();
  const double before = height(moved.cube);
  moved.run(10);
  const CloudContactStatistics made = moved.clouds.statistics();
  EXPECT_GT(double(made.reused), 0.95 * double(made.pairs));
  EXPECT_NEAR(height(moved.cube), height(fresh.cube), 0.01 * kVoxel);
  EXPECT_NEAR(height(moved.cube), before, 0.001 * kVoxel);
}

// A slow push, and a fast one.
TEST(Reuse, ACubeSlidesAndTopplesAsWithASearchInEveryStep) {
  for (const double speed : {0.3, 2.0}) {
    Scene fresh(0), moved(0.02);
    double start = 0;
    for (Scene* scene : {&fresh, &moved}) {
      scene->run(0.5);
      scene->cube.setLinearVelocity({btScalar(speed), 0, 0});
      start = 0.5 * speed * speed + 9.81 * height(scene->cube);
      for (int i = 0; i < 120; ++i) {
        scene->step(kStep);
        const double now =
            0.5 * double(scene->cube.getLinearVelocity().length2()) + 9.81 * height(scene->cube);
        EXPECT_LT(now, start + 9.81 * 0.1 * kVoxel);
      }
    }
    const btVector3 x = fresh.cube.getWorldTransform().getOrigin(),
                    y = moved.cube.getWorldTransform().getOrigin();
    EXPECT_GT(double(x.x()), 0.01);
    EXPECT_LT(double((x - y).length()), 0.02 * double(x.length())) << speed;
  }
}

// Rocks on an edge: the far edge lands where nothing has touched before.
TEST(Reuse, AFarEdgeLands) {
  for (const double motion : {0.0, 0.02}) {
    Scene scene(motion);
    btTransform tilted = scene.cube.getWorldTransform();
    tilted.setRotation(btQuaternion({0, 1, 0}, btScalar(0.05)));
    tilted.setOrigin({0, 0, btScalar(0.105)});
    scene.cube.setWorldTransform(tilted);
    double lowest = 1;
    for (int i = 0; i < 480; ++i) {
      scene.step(kStep);
      lowest = std::min(lowest, height(scene.cube));
    }
    EXPECT_GT(lowest, 0.1 - 0.5 * kVoxel) << motion;
    EXPECT_GT(double(scene.cube.getWorldTransform().getBasis()[2].z()), 0.9999) << motion;
  }
}

// Turned and moved as one, a resting pair needs no search.
TEST(Reuse, APairThatMovesAsOneIsAtRest) {
  Scene scene(0.02);
  scene.run(5);
  scene.world.setGravity({0, 0, 0});
  const btTransform motion(btQuaternion({1, 2, 3}, btScalar(0.7)), {3, -1, 2});
  for (btRigidBody* body : {&scene.slab, &scene.cube}) {
    body->setWorldTransform(motion * body->getWorldTransform());
    body->setLinearVelocity({0, 0, 0});
    body->setAngularVelocity({0, 0, 0});
  }
  scene.world.updateAabbs();
  const std::size_t before = scene.searches();
  scene.detect();
  EXPECT_LE(scene.searches(), before);
  EXPECT_FALSE(scene.points().empty());
}

// Rings that hang from each other, the uppermost held: how fast they still turn in the last second
// of ten [rad/s].
double hangingRingsTurn(double motion) {
  constexpr int kRings = 6;
  constexpr double kBend = 0.06, kWire = 0.02, kFine = 0.0025;
  const auto place = [](double angle, double s) {
    const double turn = 2 * std::numbers::pi * s, r = kBend + kWire * std::cos(turn);
    return Vec3(r * std::cos(angle), r * std::sin(angle), kWire * std::sin(turn));
  };
  static const auto ring = fieldOf(revolvedMesh(96, 40, true, place), kFine);
  BulletWorld world(reusing(motion));
  std::vector<btRigidBody*> rings;
  for (int i = 0; i < kRings; ++i) {
    const btQuaternion up({1, 0, 0}, SIMD_HALF_PI), across({0, 0, 1}, i % 2 ? SIMD_HALF_PI : 0);
    rings.push_back(&world.addCloud(ring, i > 0 ? 1 : 0,
                                    at({0, 0, btScalar(-2 * (kBend - kWire) * i)}, across * up)));
  }
  double fastest = 0;
  for (int k = 0; k < 10 / kStep; ++k) {
    world.step(kStep);
    if (k * kStep < 9) continue;
    for (const btRigidBody* body : rings)
      fastest = std::max(fastest, double(body->getAngularVelocity().length()));
  }
  return fastest;
}

// What hangs rolls on its touch, so a contact that is moved must be as stiff against rolling.
TEST(Reuse, RingsHangAsStillAsWithASearchInEveryStep) {
  const double fresh = hangingRingsTurn(0), moved = hangingRingsTurn(0.02);
  EXPECT_LT(moved, 2 * fresh + 1e-3);
}

TEST(Reuse, WhatChangesBetweenStepsIsSearched) {
  const std::function<void(Scene&)> changes[] = {
      [](Scene& s) { static_cast<CloudShape*>(s.cube.getCollisionShape())->setField(cubeField()); },
      [](Scene& s) {
        static_cast<CloudShape*>(s.slab.getCollisionShape())->setTissues({dentalTissues().front()});
      },
      [](Scene& s) {
        static_cast<CloudShape*>(s.cube.getCollisionShape())->law = KelvinVoigt{5e3, 10};
      },
      [](Scene& s) {
        auto& shape = *static_cast<CloudShape*>(s.cube.getCollisionShape());
        PaperSettings paper;
        paper.window = sphereWindow(shape.cloud().voxelSize());
        shape.usePaper(paper);
      },
      [](Scene& s) {
        s.cube.translate({btScalar(0.1 * kVoxel), 0, 0});
      }};
  for (const auto& change : changes) {
    Scene scene(0.02);
    scene.run(5);
    ASSERT_FALSE(scene.searchesNow());
    change(scene);
    EXPECT_TRUE(scene.searchesNow()) << &change - changes;
  }
}

struct Deepest : btCollisionWorld::ContactResultCallback {
  double distance = 1;
  btScalar addSingleResult(btManifoldPoint& p, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    distance = std::min(distance, double(p.getDistance()));
    return 0;
  }
};

// A query between two steps sees bodies where they are, and leaves the kept contact alone.
TEST(Reuse, AQueryIsFresh) {
  Scene scene(0.02);
  scene.run(5);
  Deepest before, after;
  scene.world.contactPairTest(&scene.cube, &scene.slab, before);
  const btTransform place = scene.cube.getWorldTransform();
  scene.cube.translate({0, 0, btScalar(-0.01 * kVoxel)});
  scene.world.contactPairTest(&scene.cube, &scene.slab, after);
  EXPECT_NEAR(before.distance - after.distance, 0.01 * kVoxel, 0.001 * kVoxel);
  scene.cube.setWorldTransform(place);
}

TEST(Reuse, RefusesAMotionThatIsNone) {
  for (const double motion : {-0.1, double(NAN), double(INFINITY)})
    EXPECT_THROW(CloudContact{reusing(motion)}, std::invalid_argument) << motion;
}

}  // namespace
}  // namespace cloudcontact::testing::reuse_test
