// Worlds go back to states that they had, and on from there to the bit.
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/bullet/world_state.h>
#include <gtest/gtest.h>

#include "base/document_sample.h"

#include "bullet/saved_world.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace cloudcontact::testing::world_state_test {
namespace {

using namespace saved_world;

constexpr int kSteps = 240;

// The hashes after each step, and states before some of them.
struct Recorded {
  std::vector<std::uint64_t> hashes;
  std::map<int, WorldState> states;
};

template <typename World>
Recorded ran(World& world, const std::vector<int>& saved) {
  Recorded run;
  for (int i = 0; i < kSteps; ++i) {
    if (std::find(saved.begin(), saved.end(), i) != saved.end())
      run.states[i] = saveState(world.world, world.clouds);
    world.step();
    run.hashes.push_back(world.hash());
  }
  return run;
}

template <typename World>
void goesOn(World& world, const Recorded& run, int from, int to) {
  restoreState(world.world, world.clouds, run.states.at(from));
  for (int i = from; i < to; ++i) {
    world.step();
    ASSERT_EQ(world.hash(), run.hashes[std::size_t(i)]) << "step " << i << " from " << from;
  }
}

// Clouds, plates and balls of either kind that are dropped on each other, so that pairs meet and
// part in all steps.
struct Heap : FileWorld {
  explicit Heap(bool newton) {
    if (newton) world.setConstraintSolver(&solver2);
    ground.setMargin(0);
    add(ground, 0, at({0, 0, 0}));
    for (int i = 0; i < 24; ++i) {
      btCollisionShape& shape = i % 3 == 0   ? static_cast<btCollisionShape&>(cloud)
                                : i % 3 == 1 ? static_cast<btCollisionShape&>(round)
                                             : static_cast<btCollisionShape&>(box);
      const btQuaternion turn(btVector3(1, btScalar(0.5), btScalar(0.25)).normalized(),
                              btScalar(0.7 * i));
      add(shape, 1 + i % 4,
          at({btScalar(0.4 * (i % 3)), btScalar(0.3 * (i % 2)), btScalar(0.9 + 0.8 * i)}, turn))
          .setFriction(btScalar(0.5));
    }
  }
  ~Heap() {
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }
  btRigidBody& add(btCollisionShape& shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
    info.m_startWorldTransform = place;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies.back().get());
    return *bodies.back();
  }

  NewtonSolver solver2;
  btStaticPlaneShape ground{btVector3(0, 0, 1), 0};
  CloudShape cloud{cube()}, round{ball()};
  btBoxShape box{btVector3(btScalar(0.5), btScalar(0.375), btScalar(0.25))};
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

TEST(WorldState, GoesOnAsTheRunThatWasNotStopped) {
  SavedWorld world;
  const Recorded run = ran(world, {0, 1, 60, 61, 200});
  for (const int from : {60, 200, 0, 61, 1, 60}) goesOn(world, run, from, kSteps);
  EXPECT_EQ(world.clouds.statistics().failures, 0u) << world.clouds.statistics().lastFailure;
}

// Saving leaves no trace, and a state may be put back at any time.
TEST(WorldState, GoesBackAHundredTimesInAHeap) {
  for (const bool newton : {false, true}) {
    Heap world(newton), other(newton);
    std::vector<int> all(kSteps);
    std::iota(all.begin(), all.end(), 0);
    const Recorded run = ran(world, all);
    EXPECT_EQ(ran(other, {}).hashes, run.hashes);
    EXPECT_GT(world.dispatcher.getNumManifolds(), 20);
    for (int i = 0; i < 100; ++i) {
      const int from = 37 * i % kSteps;
      goesOn(world, run, from, std::min(from + 12, kSteps));
    }
  }
}

TEST(WorldState, GoesOnInAnotherWorldOfTheSameBodies) {
  Heap world(true);
  const Recorded run = ran(world, {0, 70, 150});
  for (const int from : {150, 0, 70}) {
    Heap fresh(true);
    goesOn(fresh, run, from, kSteps);
  }
}

// Bullet drops pairs a while after their boxes part. Until then they are part of a state, with the
// places of their manifolds, and come back with it.
TEST(WorldState, KeepsPairsThatAreAboutToBeDropped) {
  SavedWorld world;
  world.first->setLinearVelocity({4, 3, 6});
  std::vector<WorldState> states;
  std::vector<int> pairs;
  for (int i = 0; i < 160; ++i) {
    states.push_back(saveState(world.world, world.clouds));
    pairs.push_back(world.world.getPairCache()->getNumOverlappingPairs());
    world.step();
  }
  EXPECT_LT(*std::min_element(pairs.begin() + 10, pairs.end()), pairs[5]);
  for (std::size_t from = 0; from < states.size(); ++from) {
    restoreState(world.world, world.clouds, states.back());
    restoreState(world.world, world.clouds, states[from]);
    ASSERT_EQ(saveState(world.world, world.clouds).bytes, states[from].bytes) << from;
  }
}

// What stands moves by nothing, and what sleeps sleeps on.
TEST(WorldState, KeepsSleepAndTimeLeftOver) {
  Heap world(true);
  for (int i = 0; i < 5; ++i) world.world.stepSimulation(btScalar(0.011), 4, btScalar(1.0 / 128));
  world.body(3).forceActivationState(ISLAND_SLEEPING);
  world.body(4).applyCentralForce({1, 2, 3});
  const WorldState state = saveState(world.world, world.clouds);
  const auto on = [&] {
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 20; ++i) {
      world.world.stepSimulation(btScalar(0.011), 4, btScalar(1.0 / 128));
      hashes.push_back(world.hash());
    }
    return hashes;
  };
  const std::vector<std::uint64_t> first = on();
  for (int i = 0; i < 50; ++i) world.step();
  restoreState(world.world, world.clouds, state);
  EXPECT_EQ(world.body(3).getActivationState(), ISLAND_SLEEPING);
  EXPECT_EQ(world.body(4).getTotalForce().y(), 2);
  EXPECT_EQ(saveState(world.world, world.clouds).bytes, state.bytes);
  EXPECT_EQ(on(), first);
}

// So that what nobody sets there is not 0.
[[gnu::noinline]] void soilStack() {
  volatile unsigned char soil[1 << 16];
  for (volatile unsigned char& byte : soil) byte = 0xA5;
}

// Bullet compares all four numbers of a vector. One that nobody had set once changed friction by a
// rounding, so that equal runs differed.
TEST(WorldState, PointsHaveNoNumberThatNobodySet) {
  Heap world(true);
  int points = 0;
  const auto check = [&](const btManifoldPoint& point) {
    ++points;
    EXPECT_EQ(point.m_lateralFrictionDir1.w(), 0);
    EXPECT_EQ(point.m_lateralFrictionDir2.w(), 0);
    EXPECT_EQ(point.m_normalWorldOnB.w(), 0);
  };
  for (int step = 0; step < 100; ++step) {
    soilStack();
    world.step();
    for (int i = 0; i < world.dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *world.dispatcher.getManifoldByIndexInternal(i);
      if (CloudShape::of(*manifold.getBody0()->getCollisionShape()) ||
          CloudShape::of(*manifold.getBody1()->getCollisionShape()))
        for (int k = 0; k < manifold.getNumContacts(); ++k) check(manifold.getContactPoint(k));
    }
  }
  EXPECT_GT(points, 1000);
}

TEST(WorldState, SampleEqualsTheDocument) {
  Heap heap(true);
  btDiscreteDynamicsWorld& world = heap.world;
  CloudContact& contact = heap.clouds;
  // state begins
  const cloudcontact::WorldState state = cloudcontact::saveState(world, contact);
  world.stepSimulation(0.01, 0);
  cloudcontact::restoreState(world, contact, state);  // as it was, contacts and impulses included
  // state ends
  EXPECT_EQ(saveState(world, contact).bytes, state.bytes);
  expectSample("docs/bullet.md", "state", "tests/bullet/world_state_test.cpp");
}

template <typename Error>
std::string refusal(FileWorld& world, const WorldState& state) {
  try {
    restoreState(world.world, world.clouds, state);
  } catch (const Error& why) {
    return why.what();
  }
  return {};
}

TEST(WorldState, RefusesWhatIsNoStateOfTheWorldAndChangesNothing) {
  Heap heap(false);
  SavedWorld saved;
  for (int i = 0; i < 30; ++i) heap.step(), saved.step();
  const WorldState state = saveState(heap.world, heap.clouds),
                   other = saveState(saved.world, saved.clouds);
  EXPECT_NE(refusal<std::invalid_argument>(heap, other).find("bodies"), std::string::npos);
  heap.body(2).setMassProps(7, {1, 1, 1});
  EXPECT_NE(refusal<std::invalid_argument>(heap, state).find("body 2"), std::string::npos);
  const std::uint64_t before = saved.hash();
  for (const std::size_t at : {std::size_t(3), other.bytes.size() / 2, other.bytes.size() - 1}) {
    WorldState damaged = other;
    damaged.bytes[at] ^= 1;
    EXPECT_FALSE(refusal<std::runtime_error>(saved, damaged).empty());
    damaged.bytes.resize(at);
    EXPECT_FALSE(refusal<std::runtime_error>(saved, damaged).empty());
  }
  EXPECT_FALSE(refusal<std::runtime_error>(saved, {}).empty());
  EXPECT_EQ(saved.hash(), before);
}

}  // namespace
}  // namespace cloudcontact::testing::world_state_test
