// CloudDispatcher gives manifolds equal to those of Bullet's own dispatcher to the bit, in the same
// order, for any number of threads. Results for queries that changed are searched again, and
// failures are counted once.
#include "bullet/dispatch_stage.h"

#include <cloudcontact/bullet/cuttable_body.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "workpiece/cut_cases.h"

namespace cloudcontact::testing::cloud_dispatcher_test {
namespace {

constexpr double kVoxel = 1e-3;

btVector3 v(double x, double y, double z) {
  return {btScalar(x), btScalar(y), btScalar(z)};
}

const std::shared_ptr<const SurfaceField>& nutField() {
  static const auto field = fieldOf(plainNut(24e-3, 12e-3, 10e-3), kVoxel);
  return field;
}
const std::shared_ptr<const SurfaceField>& ballField() {
  static const auto field = fieldOf(sphereMesh(8e-3, 1e-5), kVoxel);
  return field;
}

std::unique_ptr<CloudShape> nut() {
  return exactCloud(nutField());
}

// Turned nuts above one another, which fall into a heap.
void pour(Stage& stage, int count) {
  Random random(7);
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond q = random.rotation();
    const Vec3 aside = 12e-3 * (random.inCube() - Vec3::Constant(0.5));
    stage.add(nut(), 0.03,
              btTransform(
                  btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())),
                  v(aside.x(), aside.y(), 0.015 + 0.018 * i)));
  }
}

struct Outcome {
  std::vector<std::uint64_t> hashes;
  CloudContactStatistics counted;
  double hitRate = 0;
};

// How a scene is set up, and what happens before each step.
struct Scene {
  int steps = 240;
  std::function<void(Stage&)> build;
  std::function<void(Stage&, int)> before = [](Stage&, int) {};
  CloudContactSettings settings = {};
};

Outcome play(const Scene& scene, int threads) {
  Stage stage(threads, scene.settings);
  scene.build(stage);
  Outcome outcome;
  for (int i = 0; i < scene.steps; ++i) {
    scene.before(stage, i);
    stage.step();
    outcome.hashes.push_back(stage.hash());
  }
  outcome.counted = stage.clouds.statistics();
  outcome.hitRate = stage.hitRate();
  return outcome;
}

// `leastUsed`: the least fraction of the results searched ahead that Bullet then uses.
void expectSame(const Scene& scene, double leastUsed = 0.99) {
  const Outcome serial = play(scene, 0);
  EXPECT_GT(serial.counted.contacts, 0u);
  for (const int count : {1, 2, 3, 8}) {
    const Outcome found = play(scene, count);
    const auto first = std::mismatch(serial.hashes.begin(), serial.hashes.end(),
                                     found.hashes.begin(), found.hashes.end())
                           .first;
    EXPECT_EQ(first, serial.hashes.end())
        << count << " threads: step " << first - serial.hashes.begin();
    EXPECT_EQ(found.counted.pairs, serial.counted.pairs);
    EXPECT_EQ(found.counted.samples, serial.counted.samples);
    EXPECT_EQ(found.counted.contacts, serial.counted.contacts);
    // A search ahead that the walk makes again counts twice, and its memory may have grown.
    if (!(found.hitRate < 1)) {
      for (const WorkCounts::Named& each : WorkCounts::all())
        EXPECT_EQ(found.counted.work.*each.count, serial.counted.work.*each.count) << each.name;
      EXPECT_EQ(found.counted.bytes, serial.counted.bytes);
    }
    EXPECT_EQ(found.counted.failures, serial.counted.failures) << found.counted.lastFailure;
    if (count > 1) {
      EXPECT_GE(found.hitRate, leastUsed);
    } else {
      EXPECT_TRUE(std::isnan(found.hitRate)) << "one thread has nothing to share out";
    }
  }
}

TEST(CloudDispatcher, AHeapOfNuts) {
  Scene scene;
  scene.build = [](Stage& stage) {
    stage.addGround();
    pour(stage, 10);
  };
  expectSame(scene);
}

TEST(CloudDispatcher, ShapesOfEveryKindAndASoftSheet) {
  Scene scene;
  scene.build = [](Stage& stage) {
    stage.addGround();
    pour(stage, 3);
    stage.add(exactCloud(ballField()), 0.02, at(v(0.02, 0, 0.01)));
    stage.add(std::make_unique<btBoxShape>(v(0.008, 0.008, 0.008)), 0.05, at(v(0, 0.02, 0.03)));
    stage.add(std::make_unique<btSphereShape>(btScalar(0.008)), 0.05, at(v(0.01, 0, 0.09)));
    stage.add(std::make_unique<btCapsuleShape>(btScalar(0.005), btScalar(0.01)), 0.05,
              at(v(-0.01, 0.01, 0.11)));
    btSoftBody& sheet =
        stage.keep(btSoftBodyHelpers::CreatePatch(stage.world.getWorldInfo(), v(-0.02, -0.02, 0.07),
                                                  v(0.02, -0.02, 0.07), v(-0.02, 0.02, 0.07),
                                                  v(0.02, 0.02, 0.07), 9, 9, 0, true),
                   0.005);
    sheet.m_cfg.piterations = 4;
  };
  // The sheet pushes bodies during Bullet's walk, after their pairs were searched.
  expectSame(scene, 0.5);
}

// Two clouds and a box in a compound, and that in another, turned.
void addCompound(Stage& stage, double height) {
  auto* const inner = stage.own(std::make_unique<btCompoundShape>());
  inner->addChildShape(btTransform(btQuaternion(v(1, 0, 0), btScalar(0.3)), v(0.012, 0, 0)),
                       stage.own(nut()));
  inner->addChildShape(at(v(-0.012, 0, 0)), stage.own(exactCloud(ballField())));
  auto outer = std::make_unique<btCompoundShape>();
  outer->addChildShape(btTransform(btQuaternion(v(0, 1, 0), btScalar(0.2)), v(0, 0, 0.002)), inner);
  outer->addChildShape(at(v(0, 0, 0.012)),
                       stage.own(std::make_unique<btBoxShape>(v(0.006, 0.006, 0.006))));
  btRigidBody& body = stage.add(std::move(outer), 0.08, at(v(0.001, 0.002, height)));
  body.setAngularVelocity(v(1, 2, 3));
}

TEST(CloudDispatcher, CompoundsInCompounds) {
  Scene scene;
  scene.build = [](Stage& stage) {
    stage.addGround();
    for (int i = 0; i < 4; ++i) addCompound(stage, 0.02 + 0.035 * i);
    stage.add(nut(), 0.03, at(v(0, 0, 0.17)));
  };
  // A child that parts from its neighbor is searched ahead once more.
  expectSame(scene, 0.95);
}

TEST(CloudDispatcher, BodiesThatAreCut) {
  static const Cloud cloud = cloudOf(
      [](const Vec3& p) {
        return ((p - Vec3(16.25, 16, 12)).cwiseAbs().array() < Vec3(12, 8, 8).array()).all();
      },
      {4, 4, 3}, kVoxel);
  // A trench through the middle, deeper with every cut.
  const auto cut = [](CuttableBody& body, int depth,
                      std::vector<std::unique_ptr<CuttableBody>>& all) {
    std::vector<VoxelCut> cuts;
    for (int z = 20; z > 20 - depth; --z)
      for (int y = 7; y < 26; ++y)
        for (int x = 15; x < 18; ++x) cuts.push_back({{x, y, z}, 0});
    for (auto& piece : body.cut(cuts).fallen) all.push_back(std::move(piece));
  };
  std::vector<std::uint64_t> serial;
  for (const int count : {0, 1, 2, 3, 8}) {
    Stage stage(count);
    stage.addGround();
    std::vector<std::unique_ptr<CuttableBody>> all;
    CuttableBodySettings settings;
    settings.threads = 1;
    for (int i = 0; i < 3; ++i) {
      all.push_back(
          std::make_unique<CuttableBody>(cloud, at(v(-0.016, -0.016, 0.02 * i)), settings));
      all.back()->addTo(stage.world);
      all.back()->body().setActivationState(DISABLE_DEACTIVATION);
    }
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 160; ++i) {
      if (i >= 60 && i % 20 == 0) cut(*all[1], 3 + (i - 60) / 5, all);
      stage.step();
      hashes.push_back(stage.hash());
    }
    if (count == 0) {
      serial = hashes;
      EXPECT_GT(all.size(), 3u) << "one should have fallen apart";
    } else {
      EXPECT_EQ(hashes, serial) << count << " threads";
    }
    if (count > 1) {
      EXPECT_GT(stage.hitRate(), 0.95);
    }
  }
}

TEST(CloudDispatcher, BodiesAddedAndRemoved) {
  Scene scene;
  scene.build = [](Stage& stage) {
    stage.addGround();
    pour(stage, 4);
  };
  scene.before = [](Stage& stage, int step) {
    if (step % 40 == 20) {
      stage.removeLast();
      stage.removeLast();
    }
    if (step % 40 == 30) {
      addCompound(stage, 0.08);
      stage.add(nut(), 0.03, at(v(0.003, 0.001, 0.05)));
    }
  };
  expectSame(scene);
}

int passed = 0;
// Processes every other pair and moves its bodies, so that results ahead are of no use.
void choosy(btBroadphasePair& pair, btCollisionDispatcher& dispatcher,
            const btDispatcherInfo& info) {
  const int sum = pair.m_pProxy0->m_uniqueId + pair.m_pProxy1->m_uniqueId;
  if (sum % 5 == 0) return;
  if (++passed % 7 == 0) {
    auto* const body =
        btRigidBody::upcast(static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject));
    if (body && body->getInvMass() > 0) body->translate(v(1e-5, 0, 0));
  }
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
}

TEST(CloudDispatcher, AUsersNearCallbackThatMovesBodies) {
  Scene scene;
  scene.build = [](Stage& stage) {
    passed = 0;
    stage.addGround();
    pour(stage, 8);
    stage.dispatcher->setNearCallback(choosy);
  };
  expectSame(scene, 0.2);
}

struct HashPoints : btCollisionWorld::ContactResultCallback {
  Hash* hash;
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    hash->add(point.m_positionWorldOnB);
    hash->add(point.m_distance1);
    return 0;
  }
};

TEST(CloudDispatcher, QueriesBetweenSteps) {
  std::vector<std::uint64_t> hashes;
  Scene scene;
  scene.build = [&hashes](Stage& stage) {
    hashes.emplace_back();
    stage.addGround();
    pour(stage, 6);
    addCompound(stage, 0.16);
  };
  scene.before = [&hashes](Stage& stage, int step) {
    Hash hash;
    HashPoints callback;
    callback.hash = &hash;
    stage.world.contactTest(stage.bodies[1 + static_cast<std::size_t>(step % 6)].get(), callback);
    stage.world.contactPairTest(stage.bodies[7].get(), stage.bodies[0].get(), callback);
    if (step % 10 == 0) stage.world.performDiscreteCollisionDetection();
    hashes.back() ^= hash.value() * static_cast<std::uint64_t>(2 * step + 1);
  };
  expectSame(scene);
  for (const std::uint64_t one : hashes) EXPECT_EQ(one, hashes.front());
}

TEST(CloudDispatcher, FailuresAreCountedOnce) {
  Scene scene;
  scene.steps = 60;
  scene.build = [](Stage& stage) {
    stage.addGround();
    pour(stage, 4);
    // A flat hull has no volume, and a NaN pose is no pose.
    auto flat = std::make_unique<btConvexHullShape>();
    for (const auto& corner : {v(-0.02, -0.02, 0), v(0.02, -0.02, 0), v(0, 0.03, 0)})
      flat->addPoint(corner);
    stage.add(std::move(flat), 0, at(v(0, 0, 0.02)));
  };
  scene.before = [](Stage& stage, int step) {
    if (step != 30) return;
    btTransform lost = stage.bodies[2]->getWorldTransform();
    stage.bodies[2]->setLinearVelocity(v(0, 0, 0));
    lost.getOrigin().setX(std::numeric_limits<btScalar>::quiet_NaN());
    stage.bodies[2]->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    stage.bodies[2]->setWorldTransform(lost);
    stage.bodies[2]->setInterpolationWorldTransform(lost);
    stage.world.setForceUpdateAllAabbs(false);
  };
  const Outcome serial = play(scene, 0), parallel = play(scene, 3);
  EXPECT_GT(serial.counted.failures, 60u);
  EXPECT_EQ(parallel.counted.failures, serial.counted.failures);
  EXPECT_EQ(parallel.counted.lastFailure, serial.counted.lastFailure);
  EXPECT_EQ(parallel.counted.pairs, serial.counted.pairs);
  EXPECT_EQ(parallel.hashes, serial.hashes);
}

int heard = 0;
bool hear(btManifoldPoint&, void*, void*) {
  ++heard;
  return true;
}

// Contacts that were there before are written on all threads. A callback gets its calls in the
// walk's order, so with one the walk writes; so it does beside a soft body, which pushes on the
// way.
TEST(CloudDispatcher, WritesAheadUnlessACallbackListens) {
  const auto play = [](int threads, bool listens) {
    gContactProcessedCallback = listens ? hear : nullptr;
    heard = 0;
    Stage stage(threads);
    stage.addGround();
    pour(stage, 6);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 200; ++i) {
      stage.step();
      hashes.push_back(stage.hash());
    }
    gContactProcessedCallback = nullptr;
    return std::tuple(hashes, stage.written(), heard);
  };
  const auto [serial, none, nobody] = play(0, false);
  EXPECT_EQ(none, 0u);
  const auto [fast, written, silent] = play(3, false);
  EXPECT_GT(written, 500u);
  EXPECT_EQ(silent, 0);
  const auto [slow, waited, calls] = play(3, true);
  EXPECT_EQ(waited, 0u);
  EXPECT_GT(calls, 500);
  EXPECT_EQ(fast, serial);
  EXPECT_EQ(slow, serial);
}

TEST(CloudDispatcher, RefusesNegativeThreads) {
  btDefaultCollisionConfiguration configuration;
  EXPECT_THROW(CloudDispatcher(&configuration, -1), std::invalid_argument);
  EXPECT_GE(CloudDispatcher(&configuration).threads(), 1);
  EXPECT_EQ(CloudDispatcher(&configuration, 5).threads(), 5);
}

}  // namespace
}  // namespace cloudcontact::testing::cloud_dispatcher_test
