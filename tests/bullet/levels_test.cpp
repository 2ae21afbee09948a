// Pairs of clouds with levels (CloudShape::setFidelity): coarse where that holds the tolerance,
// fine where a contact asks for it; the same on any number of threads.
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/query.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "bullet/bullet_world.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing::levels_test {
namespace {

constexpr double kVoxel = 0.5e-3, kStep = 1. / 240;

Cloud cloudOf(const Mesh& mesh, double voxel = kVoxel) {
  DigitizeSettings how;
  how.voxelSize = voxel;
  how.threads = 1;
  return digitize(mesh, how);
}

std::shared_ptr<const FieldLevels> levelsOf(const Mesh& mesh, double voxel = kVoxel) {
  FieldSettings how;
  how.threads = 1;
  return std::make_shared<const FieldLevels>(cloudOf(mesh, voxel), how);
}

const auto& slabLevels() {
  static const auto levels = levelsOf(boxMesh({60e-3, 60e-3, 16e-3}));
  return levels;
}

// No shape that recognizedShape() knows: three edges of different length, one corner cut off, is
// too much; an ellipsoid does.
Mesh eggMesh() {
  Mesh mesh = sphereMesh(12e-3, 1e-6);
  for (Vec3& v : mesh.vertices) v = v.cwiseProduct(Vec3(1, 1.4, 0.9));
  return mesh;
}

CloudContactSettings keepingReports() {
  CloudContactSettings settings;
  settings.keepReports = true;
  return settings;
}

// An egg on a slab, both of levels.
struct Scene : BulletWorld {
  explicit Scene(double tolerance, const CloudContactSettings& settings = keepingReports())
      : BulletWorld(settings), levels(levelsOf(eggMesh())) {
    auto under = std::make_unique<CloudShape>(slabLevels());
    auto above = std::make_unique<CloudShape>(levels);
    if (tolerance > 0)
      for (CloudShape* one : {under.get(), above.get()}) one->setFidelity({tolerance});
    shape = above.get();
    slab = under.get();
    add(std::move(under), 0, at({0, 0, btScalar(-8e-3)}));
    egg = &add(std::move(above), 0.02, at({0, 0, btScalar(10.8e-3)}));
  }
  double energy() const {
    const btVector3 w = egg->getWorldTransform().getBasis().transpose() * egg->getAngularVelocity();
    return 0.5 * 0.02 * double(egg->getLinearVelocity().length2()) +
           0.5 * double((w * egg->getLocalInertia()).dot(w)) +
           0.02 * 9.81 * double(egg->getWorldTransform().getOrigin().z());
  }
  void run(double seconds) {
    for (int i = 0; i < seconds / kStep; ++i) step(kStep);
  }
  std::shared_ptr<const FieldLevels> levels;
  CloudShape *shape = nullptr, *slab = nullptr;
  btRigidBody* egg = nullptr;
};

TEST(Levels, NothingChangesWithoutATolerance) {
  Scene scene(0);
  scene.run(0.1);
  const std::vector<PairReport> pairs = scene.clouds.pairs();
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].coarser, 0u);
  EXPECT_DOUBLE_EQ(pairs[0].voxel[0], kVoxel);
  EXPECT_TRUE(scene.levels->isBuilt(0));
  EXPECT_FALSE(scene.levels->isBuilt(1));
}

TEST(Levels, AContactTakesTheCoarsestThatHoldsTheTolerance) {
  Scene scene(0.2e-3);
  ASSERT_EQ(scene.shape->recognized(), nullptr);
  scene.run(0.5);
  const std::vector<PairReport> pairs = scene.clouds.pairs();
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].coarser, pairs[0].answers());
  EXPECT_GE(pairs[0].voxel[0], 2 * kVoxel);
  EXPECT_GE(pairs[0].voxel[1], 2 * kVoxel);
  EXPECT_LE(pairs[0].error, 0.2e-3);
  EXPECT_GT(pairs[0].error, 0);
  EXPECT_FALSE(scene.levels->isBuilt(0)) << "a fine field that no pair asks for is never built";
  Scene fine(0);
  fine.run(0.5);
  const double height = double(scene.egg->getWorldTransform().getOrigin().z());
  EXPECT_NEAR(height, double(fine.egg->getWorldTransform().getOrigin().z()), 0.2e-3);
}

// A finer tolerance needs finer voxels, and holds.
TEST(Levels, VoxelsFollowTheTolerance) {
  double last = 1;
  for (const double tolerance : {0.5e-3, 0.1e-3, 0.02e-3}) {
    Scene scene(tolerance);
    scene.step(kStep);
    const PairReport pair = scene.clouds.pairs().at(0);
    const double voxel = std::max(pair.voxel[0], pair.voxel[1]);
    EXPECT_LE(voxel, last);
    last = voxel;
  }
  EXPECT_LT(last, 4 * kVoxel);
}

TEST(Levels, AWorldHasATolerance) {
  CloudContactSettings settings = keepingReports();
  settings.fidelity.tolerance = 0.2e-3;
  Scene scene(0, settings);
  scene.run(0.1);
  EXPECT_EQ(scene.clouds.pairs().at(0).coarser, scene.clouds.pairs().at(0).answers());
  EXPECT_FALSE(scene.levels->isBuilt(0));
}

// The contact of a ball pressed into a slab, by its closed form, at every tolerance.
TEST(Levels, ContactsAreWithinTheErrorThatTheyState) {
  const double radius = 12e-3;
  const auto ball = levelsOf(sphereMesh(radius, 1e-6));
  int covered = 0, all = 0, coarse = 0;
  Random random(3);
  for (const double tolerance : {0.4e-3, 0.1e-3, 0.05e-3})
    for (int k = 0; k < 12; ++k) {
      CloudContactSettings settings = keepingReports();
      settings.fidelity.tolerance = tolerance;  // a world's makes no shapes of clouds
      settings.law = KelvinVoigt{1e4, 0};
      BulletWorld world(settings);
      auto under = std::make_unique<CloudShape>(slabLevels());
      auto above = std::make_unique<CloudShape>(ball);
      const double depth = random.uniform(0.05e-3, 0.5e-3);
      const Eigen::Quaterniond q = random.rotation();
      world.add(std::move(under), 0, at({0, 0, btScalar(-8e-3)}));
      world.add(
          std::move(above), 1,
          at({btScalar(random.uniform(-8e-3, 8e-3)), 0, btScalar(radius - depth)},
             btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w()))));
      for (int i = 0; i < 40; ++i) world.detect();
      const PairReport pair = world.clouds.pairs().at(0);
      ASSERT_EQ(pair.answers(), 40u);
      EXPECT_LE(pair.error, tolerance);
      covered += std::abs(pair.depth - depth) <= pair.error;
      coarse += pair.coarser > 0;
      ++all;
    }
  EXPECT_GE(covered, 0.95 * all);
  EXPECT_EQ(coarse, all);
}

// A tolerance that changes makes the pair take other voxels while the body rests.
TEST(Levels, ASwitchKeepsRestAndFeedsNoEnergyIn) {
  const double tolerance = 0.4e-3;
  Scene scene(tolerance);
  scene.run(2);
  const double before = scene.energy();
  const PairReport coarse = scene.clouds.pairs().at(0);
  double most = -1, fastest = 0;
  for (CloudShape* one : {scene.shape, scene.slab}) one->setFidelity({0.02e-3});
  for (int i = 0; i < 480; ++i) {
    scene.step(kStep);
    most = std::max(most, scene.energy() - before);
    fastest = std::max(fastest, double(scene.egg->getLinearVelocity().length()));
  }
  const PairReport fine = scene.clouds.pairs().at(0);
  ASSERT_NE(coarse.searched, fine.searched);
  EXPECT_LT(most, 0.02 * 9.81 * tolerance) << "no more than its weight over the tolerance";
  EXPECT_LT(fastest, tolerance / 0.1) << "it moves to its new place slowly";
  EXPECT_LT(double(scene.egg->getLinearVelocity().length()), 1e-3) << "it rocks, undamped";
}

// What a body weighs stays what its contact bears while its levels change, both ways.
TEST(Levels, ASwitchKeepsTheForce) {
  for (const auto& [from, to] : {std::pair(0.4e-3, 0.08e-3), std::pair(0.08e-3, 0.4e-3)}) {
    Scene scene(from);
    scene.run(3);
    for (CloudShape* one : {scene.shape, scene.slab}) one->setFidelity({to});
    double least = 1e9, most = 0;
    for (int i = 0; i < 3; ++i) {
      scene.step(kStep);
      double impulse = 0;
      for (const btManifoldPoint& point : scene.points()) impulse += double(point.m_appliedImpulse);
      least = std::min(least, impulse / (0.02 * 9.81 * kStep));
      most = std::max(most, impulse / (0.02 * 9.81 * kStep));
    }
    EXPECT_GT(least, 0.98);
    EXPECT_LT(most, 1.03);
  }
}

TEST(Levels, ARestingPairDoesNotFlip) {
  Scene scene(0.1e-3);
  scene.run(1);
  scene.clouds.resetStatistics();
  scene.run(3);
  EXPECT_LE(scene.clouds.statistics().refined, 2u);
  EXPECT_LT(double(scene.egg->getLinearVelocity().length()), 2e-3);
}

// Pairs of a heap by any number of threads, with a budget that does not suffice.
struct Heap {
  Heap(int threads, double budget, double tolerance = 0.05e-3)
      : clouds(settingsOf(tolerance, budget)), dispatcher(&configuration, threads) {
    clouds.attach(dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-9.81)});
    add(std::make_shared<btStaticPlaneShape>(btVector3(0, 0, 1), 0), 0, at({0, 0, 0}));
    auto levels = levelsOf(eggMesh());
    for (int i = 0; i < 12; ++i)
      add(std::make_shared<CloudShape>(levels), 0.02 * (1 + i % 3),
          at({btScalar(0.02 * (i % 2)), btScalar(0.03 * (i / 2 % 2)),
              btScalar(0.012 + 0.026 * (i / 4))},
             btQuaternion({0, 0, 1}, btScalar(0.7 * i))));
  }
  ~Heap() {
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }
  static CloudContactSettings settingsOf(double tolerance, double budget) {
    CloudContactSettings settings = keepingReports();
    settings.fidelity = {tolerance, budget};
    return settings;
  }
  void add(std::shared_ptr<btCollisionShape> shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    shapes.push_back(std::move(shape));
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies.back().get());
  }
  std::uint64_t run(int steps) {
    Fnv1a sum;
    for (int i = 0; i < steps; ++i) {
      world.stepSimulation(btScalar(kStep), 0);
      for (const auto& body : bodies)
        for (const btVector3& v : {body->getWorldTransform().getOrigin(), body->getLinearVelocity(),
                                   body->getAngularVelocity()})
          for (int k = 0; k < 3; ++k) sum.add(&v[k], sizeof v[k]);
    }
    return sum.value();
  }
  CloudContact clouds;
  btDefaultCollisionConfiguration configuration;
  CloudDispatcher dispatcher;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::shared_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

// What no coarser voxels hold costs and does the same as without a tolerance: contacts move with
// their bodies, and what stays apart is not asked again.
TEST(Levels, AToleranceThatNoLevelHoldsChangesNothing) {
  Scene plain(0), fine(1e-9);
  EXPECT_TRUE(fine.levels->isBuilt(0)) << "before the first step";
  for (Scene* scene : {&plain, &fine}) scene->run(1);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(plain.egg->getWorldTransform().getOrigin()[k],
              fine.egg->getWorldTransform().getOrigin()[k]);
    EXPECT_EQ(plain.egg->getAngularVelocity()[k], fine.egg->getAngularVelocity()[k]);
  }
  const PairReport one = plain.clouds.pairs().at(0), same = fine.clouds.pairs().at(0);
  EXPECT_EQ(one.searched, same.searched);
  EXPECT_EQ(one.moved, same.moved);
  EXPECT_GT(same.moved, 0u);
  EXPECT_EQ(same.coarser, 0u);
  Heap free(1, 0, 0), tight(1, 0, 1e-9);
  EXPECT_EQ(free.run(120), tight.run(120));
  EXPECT_LT(double(tight.clouds.statistics().pairs), 1.05 * double(free.clouds.statistics().pairs));
}

// The nut's thread asks for the finest voxels; a ball on the bolt's end does not.
TEST(Levels, AThreadIsFineAndABallOnItIsNot) {
  const Thread thread{8e-3, 2e-3, 1.1e-3};
  const auto bolt = levelsOf(threadedRod(thread, 24e-3), 0.25e-3),
             nut = levelsOf(threadedRing(thread, 8e-3, 12e-3, 0.1e-3), 0.25e-3),
             ball = levelsOf(eggMesh(), 0.25e-3);
  CloudContactSettings settings = keepingReports();
  settings.fidelity.tolerance = 0.1e-3;
  BulletWorld world(settings);
  world.add(std::make_unique<CloudShape>(bolt), 0, at({0, 0, 0}));
  world.add(std::make_unique<CloudShape>(nut), 0.02, at({0, 0, 0}));
  world.add(std::make_unique<CloudShape>(ball), 0.02, at({0, 0, btScalar(22.7e-3)}));
  for (int i = 0; i < 10; ++i) world.step(kStep);
  const std::vector<PairReport> pairs = world.clouds.pairs();
  int threads = 0, balls = 0;
  for (const PairReport& pair : pairs) {
    const bool isBall = pair.voxel[0] > 0.3e-3 || pair.voxel[1] > 0.3e-3;
    (isBall ? balls : threads) += pair.depth != 0;
  }
  EXPECT_EQ(threads, 1);
  EXPECT_EQ(balls, 1);
  EXPECT_FALSE(ball->isBuilt(0));
}

// A pin in a hole with less play than the tolerance: coarse surfaces would jam it.
TEST(Levels, ATightFitIsSearchedFiner) {
  const auto pin = levelsOf(cylinderMesh(8e-3, 20e-3, 1e-6));
  const auto hole = levelsOf(revolvedMesh(180, 120, true, [](double angle, double s) {
    const bool inside = s < 0.5;
    const double z = 16e-3 * ((inside ? 2 * s : 2 - 2 * s) - 0.5), r = inside ? 8.1e-3 : 16e-3;
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  }));
  double speeds[2];
  for (const double tolerance : {0.0, 0.4e-3}) {
    CloudContactSettings settings = keepingReports();
    settings.fidelity.tolerance = tolerance;
    BulletWorld world(settings);
    world.add(std::make_unique<CloudShape>(hole), 0, at({0, 0, 0}));
    btRigidBody& moving = world.add(std::make_unique<CloudShape>(pin), 0.02, at({0, 0, 0}));
    moving.setFriction(0);
    for (int i = 0; i < 24; ++i) world.step(kStep);
    speeds[tolerance > 0] = -double(moving.getLinearVelocity().z());
    const PairReport pair = world.clouds.pairs().at(0);
    EXPECT_LT(std::max(pair.voxel[0], pair.voxel[1]), 3 * kVoxel);
  }
  EXPECT_GT(speeds[0], 0.8 * 9.81 * 0.1);
  EXPECT_GT(speeds[1], 0.8 * 9.81 * 0.1);
}

TEST(Levels, OutcomeDoesNotDependOnThreads) {
  for (const double budget : {0.0, 100e-6}) {
    std::uint64_t one = 0;
    std::size_t eased = 0;
    for (const int threads : {1, 2, 5}) {
      Heap heap(threads, budget);
      const std::uint64_t hash = heap.run(120);
      if (threads == 1) one = hash, eased = heap.clouds.statistics().eased;
      EXPECT_EQ(hash, one) << threads << " threads, budget " << budget;
      EXPECT_EQ(heap.clouds.statistics().eased, eased);
    }
  }
}

TEST(Levels, ABudgetMakesTheLeastImportantPairsCoarser) {
  Heap free(1, 0), limited(1, 100e-6);
  free.run(200);
  limited.run(200);
  const CloudContactStatistics all = free.clouds.statistics(), few = limited.clouds.statistics();
  EXPECT_EQ(all.eased, 0u);
  EXPECT_EQ(all.countedSeconds, 0);
  EXPECT_GT(few.eased, 0u);
  EXPECT_LT(few.eased, few.pairs);
  EXPECT_GT(few.countedSeconds, 0);
  std::size_t eased = 0;
  double beyond = 0;
  for (const PairReport& pair : limited.clouds.pairs()) {
    eased += pair.eased;
    if (pair.eased > 0) beyond = std::max(beyond, pair.expectedError);
  }
  EXPECT_EQ(eased, few.eased);
  EXPECT_GT(beyond, 0.05e-3) << "the report says what was given up";
  // A generous one changes nothing.
  Heap generous(1, 1);
  Heap same(1, 0);
  EXPECT_EQ(generous.run(60), same.run(60));
}

TEST(Levels, BadFidelityIsRefused) {
  CloudContactSettings settings;
  settings.fidelity.tolerance = -1;
  EXPECT_THROW(CloudContact{settings}, std::invalid_argument);
  settings.fidelity = {0, -1};
  EXPECT_THROW(CloudContact{settings}, std::invalid_argument);
  CloudShape shape(levelsOf(eggMesh()));
  EXPECT_THROW(shape.setFidelity({-1}), std::invalid_argument);
  EXPECT_THROW(shape.setFidelity({1e-3, 1e-3}), std::invalid_argument);
  EXPECT_THROW(CloudShape(std::shared_ptr<const FieldLevels>()), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::levels_test
