// Clouds in a Bullet that is built with BT_THREADSAFE, under its own threads: what they find is
// what one thread finds, to the bit.
#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/bullet/ordered_dispatcher.h>
#include <gtest/gtest.h>

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <LinearMath/btThreads.h>

#include <random>

#include "bullet/triangle_grounds.h"

namespace cloudcontact::testing {
namespace {

static_assert(BT_THREADSAFE, "this Bullet has no threads");

constexpr int kSteps = 120;

// Bullet's world for threads, with solvers of ours in its pool.
class ThreadedWorld {
 public:
  explicit ThreadedWorld(bool threaded) : dispatcher_(make(threaded)) {
    clouds_.attach(*dispatcher_);
    std::vector<btConstraintSolver*> all;  // the pool frees them
    for (int i = 0; i < 4; ++i) all.push_back(new NewtonSolver);
    pool_ = std::make_unique<btConstraintSolverPoolMt>(all.data(), int(all.size()));
    world_ = std::make_unique<btDiscreteDynamicsWorldMt>(dispatcher_.get(), &broadphase_,
                                                         pool_.get(), nullptr, &configuration_);
    recommendedSettings(*world_);
    world_->setGravity({0, 0, btScalar(-9.81)});
    fill();
  }
  ~ThreadedWorld() {
    for (auto& body : bodies_) world_->removeRigidBody(body.get());
  }

  void step() { world_->stepSimulation(btScalar(1) / 240, 0, btScalar(1) / 240); }
  std::uint64_t hash() const {
    Hash sum;
    for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher_->getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k) addTo(sum, manifold.getContactPoint(k));
    }
    for (const auto& body : bodies_) {
      sum.add(body->getWorldTransform().getOrigin());
      sum.add(body->getLinearVelocity());
      sum.add(body->getAngularVelocity());
    }
    return sum.value();
  }
  const CloudContact& clouds() const { return clouds_; }

 private:
  std::unique_ptr<btCollisionDispatcher> make(bool threaded) {
    constexpr int kGrain = 2;
    if (threaded)
      return std::make_unique<OrderedDispatcher<btCollisionDispatcherMt>>(&configuration_, kGrain);
    return std::make_unique<OrderedDispatcher<btCollisionDispatcher>>(&configuration_);
  }
  void add(std::unique_ptr<btCollisionShape> shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    if (mass > 0) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_->addRigidBody(bodies_.back().get());
  }
  // Heaps of clouds, compounds of clouds and Bullet's shapes on a terrain.
  void fill() {
    Kept ground = bvhShape(groundMesh(40));
    data_ = std::move(ground.data);
    add(std::move(ground.shape), 0, at({0, 0, 0}));
    std::mt19937 random(3);
    const auto number = [&random] { return btScalar(random() % 1000) / 1000; };
    for (int i = 0; i < 48; ++i) {
      const btVector3 place(btScalar(0.25 * (i % 4) - 0.4) + btScalar(0.02) * number(),
                            btScalar(0.25 * (i / 4 % 4) - 0.4) + btScalar(0.02) * number(),
                            btScalar(0.06 + 0.1 * (i / 16)));
      const btTransform pose = at(place, btQuaternion({1, 2, 3}, number()));
      const auto& field = testClouds()[std::size_t(i % 2)].field;
      if (i % 8 == 5) {
        add(std::make_unique<btBoxShape>(btVector3(btScalar(0.04), btScalar(0.03), btScalar(0.03))),
            0.5, pose);
      } else if (i % 8 == 6) {
        auto compound = std::make_unique<btCompoundShape>();
        for (const double x : {-0.04, 0.04}) {
          shapes_.push_back(std::make_unique<CloudShape>(field));
          compound->addChildShape(at({btScalar(x), 0, 0}), shapes_.back().get());
        }
        add(std::move(compound), 0.8, pose);
      } else {
        add(std::make_unique<CloudShape>(field), 0.5, pose);
      }
    }
  }

  CloudContact clouds_;  // first: it must outlive the dispatcher
  btDefaultCollisionConfiguration configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  btDbvtBroadphase broadphase_;
  std::unique_ptr<btConstraintSolverPoolMt> pool_;
  std::unique_ptr<btDiscreteDynamicsWorldMt> world_;
  std::vector<std::shared_ptr<void>> data_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

std::vector<std::uint64_t> hashes(bool threaded, std::uint64_t& contacts) {
  ThreadedWorld world(threaded);
  std::vector<std::uint64_t> all;
  for (int i = 0; i < kSteps; ++i) {
    world.step();
    all.push_back(world.hash());
  }
  contacts = world.clouds().statistics().contacts;
  EXPECT_EQ(world.clouds().statistics().failures, 0u) << world.clouds().statistics().lastFailure;
  return all;
}

TEST(ThreadedBullet, FindsWhatOneThreadFinds) {
  std::uint64_t contacts = 0, found = 0;
  btSetTaskScheduler(btGetSequentialTaskScheduler());
  const auto serial = hashes(false, contacts);
  EXPECT_GT(contacts, 10000u);
  const std::unique_ptr<btITaskScheduler> scheduler(btCreateDefaultTaskScheduler());
  ASSERT_NE(scheduler, nullptr);
  btSetTaskScheduler(scheduler.get());
  for (const int threads : {1, 2, 4}) {
    scheduler->setNumThreads(threads);
    EXPECT_EQ(hashes(true, found), serial) << threads << " threads";
    EXPECT_EQ(found, contacts);
  }
  btSetTaskScheduler(btGetSequentialTaskScheduler());
}

}  // namespace
}  // namespace cloudcontact::testing
