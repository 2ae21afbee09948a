// Pairs processed by several threads, as by btCollisionDispatcherMt in a Bullet built for threads.
// Also for ThreadSanitizer (preset tsan).
#include "bullet/dispatch_stage.h"

#include <BulletSoftBody/btDefaultSoftBodySolver.h>
#include <gtest/gtest.h>

#include <mutex>
#include <thread>

namespace cloudcontact::testing::parallel_pairs_test {
namespace {

constexpr double kVoxel = 1e-3;

btVector3 v(double x, double y, double z) {
  return {btScalar(x), btScalar(y), btScalar(z)};
}

// Guards what a Bullet built for threads guards, and Debian's does not.
class GuardedDispatcher : public btCollisionDispatcher {
 public:
  using btCollisionDispatcher::btCollisionDispatcher;
  btPersistentManifold* getNewManifold(const btCollisionObject* a,
                                       const btCollisionObject* b) override {
    const std::lock_guard lock(mutex_);
    return btCollisionDispatcher::getNewManifold(a, b);
  }
  void releaseManifold(btPersistentManifold* manifold) override {
    const std::lock_guard lock(mutex_);
    btCollisionDispatcher::releaseManifold(manifold);
  }

 private:
  std::mutex mutex_;
};

// Pairs of objects and their algorithms; made serially, processed by several threads.
class Pairs {
 public:
  Pairs() {
    clouds_.attach(dispatcher_);
    info_.m_timeStep = btScalar(1) / 240;
  }
  ~Pairs() {
    for (Pair& pair : pairs_) {
      pair.algorithm->~btCollisionAlgorithm();
      dispatcher_.freeCollisionAlgorithm(pair.algorithm);
    }
  }

  btRigidBody& body(std::unique_ptr<btCollisionShape> shape, const btTransform& place) {
    btRigidBody::btRigidBodyConstructionInfo info(1, nullptr, shape.get(), {1, 1, 1});
    info.m_startWorldTransform = place;
    shapes_.push_back(std::move(shape));
    return *bodies_.emplace_back(std::make_unique<btRigidBody>(info));
  }
  void pair(btCollisionObject& a, btCollisionObject& b) {
    const Wraps wraps(a, b);
    pairs_.push_back(
        {&a, &b,
         dispatcher_.findAlgorithm(&wraps.a, &wraps.b, nullptr, BT_CONTACT_POINT_ALGORITHMS)});
  }
  void process(int threads) {
    std::vector<std::jthread> workers;
    for (int w = 0; w < threads; ++w)
      workers.emplace_back([this, w, threads] {
        for (std::size_t i = static_cast<std::size_t>(w); i < pairs_.size();
             i += static_cast<std::size_t>(threads)) {
          const Wraps wraps(*pairs_[i].a, *pairs_[i].b);
          btManifoldResult result(&wraps.a, &wraps.b);
          pairs_[i].algorithm->processCollision(&wraps.a, &wraps.b, info_, &result);
        }
      });
  }
  // By pair, because the order of the manifolds depends on the threads.
  std::uint64_t hash() {
    Hash sum;
    for (Pair& pair : pairs_) {
      btManifoldArray manifolds;
      pair.algorithm->getAllContactManifolds(manifolds);
      for (int i = 0; i < manifolds.size(); ++i)
        for (int k = 0; k < manifolds[i]->getNumContacts(); ++k)
          addTo(sum, manifolds[i]->getContactPoint(k));
    }
    return sum.value();
  }
  CloudContactStatistics statistics() const { return clouds_.statistics(); }

 private:
  struct Pair {
    btCollisionObject *a, *b;
    btCollisionAlgorithm* algorithm;
  };
  struct Wraps {
    Wraps(const btCollisionObject& first, const btCollisionObject& second)
        : a(nullptr, first.getCollisionShape(), &first, first.getWorldTransform(), -1, -1),
          b(nullptr, second.getCollisionShape(), &second, second.getWorldTransform(), -1, -1) {}
    btCollisionObjectWrapper a, b;
  };

  CloudContact clouds_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  GuardedDispatcher dispatcher_{&configuration_};
  btDispatcherInfo info_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<Pair> pairs_;
};

const std::shared_ptr<const SurfaceField>& ballField() {
  static const auto field = fieldOf(sphereMesh(8e-3, 1e-5), kVoxel);
  return field;
}

// One cloud in the middle, pressed by twelve clouds, hulls, and a flat shape without contact.
std::vector<btRigidBody*> crowd(Pairs& pairs) {
  btRigidBody& middle = pairs.body(exactCloud(ballField()), at(v(0, 0, 0)));
  std::vector<btRigidBody*> all{&middle};
  for (int i = 0; i < 12; ++i) {
    std::unique_ptr<btCollisionShape> shape = exactCloud(ballField());
    if (i % 3 == 1) {
      auto hull = std::make_unique<btConvexHullShape>();
      for (int c = 0; c < 8; ++c)
        hull->addPoint(v(c & 1 ? 8e-3 : -8e-3, c & 2 ? 8e-3 : -8e-3, c & 4 ? 8e-3 : -8e-3));
      shape = std::move(hull);
    }
    const double angle = 0.5 * i;
    btRigidBody& other = pairs.body(
        std::move(shape), at(v(15.5e-3 * std::cos(angle), 15.5e-3 * std::sin(angle), 1e-3)));
    all.push_back(&other);
    pairs.pair(middle, other);
  }
  auto flat = std::make_unique<btConvexHullShape>();
  for (const auto& corner : {v(-0.02, -0.02, 0), v(0.02, -0.02, 0), v(0, 0.03, 0)})
    flat->addPoint(corner);
  pairs.pair(middle, pairs.body(std::move(flat), at(v(0, 0, 0))));
  return all;
}

TEST(ParallelPairs, SameContactsAndCountsForAnyNumberOfThreads) {
  std::vector<std::uint64_t> hashes;
  std::vector<CloudContactStatistics> counted;
  for (const int threads : {1, 4}) {
    Pairs pairs;
    const std::vector<btRigidBody*> bodies = crowd(pairs);
    for (int step = 0; step < 12; ++step) {
      for (btRigidBody* body : bodies) body->translate(v(0, 0, 1e-5 * (step % 3)));
      bodies[0]->setLinearVelocity(v(0, 0, 0.01 * step));
      pairs.process(threads);
    }
    hashes.push_back(pairs.hash());
    counted.push_back(pairs.statistics());
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_EQ(counted[0].failures, 12u);
  EXPECT_EQ(counted[1].failures, counted[0].failures);
  EXPECT_EQ(counted[1].pairs, counted[0].pairs);
  EXPECT_EQ(counted[1].samples, counted[0].samples);
  EXPECT_EQ(counted[0].pairs, 12u * 12);
}

// Two sheets on one cloud: they push it while pairs with other clouds read its motion.
TEST(ParallelPairs, SoftBodiesPushWhileOthersRead) {
  Pairs pairs;
  const std::vector<btRigidBody*> bodies = crowd(pairs);
  btSoftBodyWorldInfo world;
  btDefaultSoftBodySolver solver;
  std::vector<std::unique_ptr<btSoftBody>> sheets;
  for (int i = 0; i < 2; ++i) {
    const double z = 7e-3 + 1e-4 * i;
    sheets.emplace_back(btSoftBodyHelpers::CreatePatch(world, v(-5e-3, -5e-3, z), v(5e-3, -5e-3, z),
                                                       v(-5e-3, 5e-3, z), v(5e-3, 5e-3, z), 9, 9, 0,
                                                       true));
    sheets.back()->setTotalMass(btScalar(0.01), true);
    sheets.back()->setSoftBodySolver(&solver);
    pairs.pair(*sheets.back(), *bodies[0]);
    pairs.pair(*sheets.back(), *bodies[1]);
  }
  for (int step = 0; step < 12; ++step) {
    for (auto& sheet : sheets) sheet->predictMotion(btScalar(1) / 240);
    pairs.process(4);
  }
  const btVector3 pushed = bodies[0]->getLinearVelocity();
  EXPECT_LT(pushed.z(), 0) << "the sheets lie on it";
  EXPECT_TRUE(std::isfinite(pushed.length()));
  EXPECT_EQ(pairs.statistics().failures, 12u) << pairs.statistics().lastFailure;
}

}  // namespace
}  // namespace cloudcontact::testing::parallel_pairs_test
