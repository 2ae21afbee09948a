// What queries serve: a character, a vehicle and a ghost on stairs of a cloud.
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "bullet/query_bodies.h"

namespace cloudcontact::testing::character_query_test {
namespace {

constexpr double kStairVoxel = 0.05;

// Treads along x from x = 0, each up to `end` at `height`, 2 `half` wide, on z = 0.
struct Tread {
  double end, height;
};
using Stairs = std::vector<Tread>;

double heightAt(const Stairs& stairs, double x) {
  for (const Tread& tread : stairs)
    if (x < tread.end) return tread.height;
  return stairs.back().height;
}

Mesh stairsMesh(const Stairs& stairs, double half) {
  std::vector<std::pair<double, double>> outline;  // (x, z), counter-clockwise
  outline.emplace_back(stairs.back().end, 0);
  for (std::size_t i = stairs.size(); i-- > 0;) {
    outline.emplace_back(stairs[i].end, stairs[i].height);
    outline.emplace_back(i > 0 ? stairs[i - 1].end : 0, stairs[i].height);
  }
  outline.emplace_back(0, 0);
  Mesh mesh;
  const int n = static_cast<int>(outline.size());
  for (const double y : {-half, half})
    for (const auto& [x, z] : outline) mesh.vertices.emplace_back(x, y, z);
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    mesh.triangles.emplace_back(i, n + i, n + next);
    mesh.triangles.emplace_back(i, n + next, next);
    if (i == 0 || next == 0) continue;
    mesh.triangles.emplace_back(0, i, next);  // all of it is seen from the lower corner
    mesh.triangles.emplace_back(n, n + next, n + i);
  }
  return mesh;
}

class GhostWorld : public BulletWorld {
 public:
  GhostWorld() { broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&callback_); }

 private:
  btGhostPairCallback callback_;
};

TEST(Character, WalksUpAndDownStairs) {
  const Stairs stairs = {{2, 0.2}, {2.4, 0.4}, {2.8, 0.6}, {3.2, 0.8}, {3.6, 1.0}, {6, 1.2}};
  GhostWorld scene;
  scene.addCloud(fieldOf(stairsMesh(stairs, 1), kStairVoxel), 0, at({0, 0, 0}));
  btCapsuleShapeZ capsule(btScalar(0.25), btScalar(0.8));
  btPairCachingGhostObject ghost;
  ghost.setCollisionShape(&capsule);
  ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
  ghost.setWorldTransform(at({btScalar(0.6), 0, btScalar(1.0)}));
  btKinematicCharacterController character(&ghost, &capsule, btScalar(0.35), {0, 0, 1});
  character.setGravity({0, 0, btScalar(-9.81)});
  scene.world.addCollisionObject(
      &ghost, btBroadphaseProxy::CharacterFilter,
      btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
  scene.world.addAction(&character);
  const auto foot = [&] {
    return ghost.getWorldTransform().getOrigin() - btVector3(0, 0, btScalar(0.65));
  };
  double lowest = 1;  // above the stairs under its axis
  const auto walk = [&](double speed, int steps) {
    character.setWalkDirection({btScalar(speed / 60), 0, 0});
    for (int i = 0; i < steps; ++i) {
      scene.step(1. / 60);
      lowest = std::min<double>(lowest, foot().z() - heightAt(stairs, foot().x()));
    }
  };
  walk(0, 60);
  EXPECT_NEAR(foot().z(), 0.2, 0.05) << "it stands";
  EXPECT_TRUE(character.onGround());
  walk(1.5, 160);
  EXPECT_GT(foot().x(), 4.2) << "it walks up";
  EXPECT_NEAR(foot().z(), 1.2, 0.05);
  walk(-1.5, 160);
  EXPECT_LT(foot().x(), 1.2) << "and down";
  EXPECT_NEAR(foot().z(), 0.2, 0.05);
  EXPECT_GT(lowest, -0.1) << "it was never inside";
  scene.world.removeAction(&character);
  scene.world.removeCollisionObject(&ghost);
}

TEST(Vehicle, DrivesOverStairs) {
  const Stairs stairs = {{6, 0.2}, {7.5, 0.3}, {9, 0.4}, {10.5, 0.5}, {20, 0.6}};
  BulletWorld scene;
  scene.addCloud(fieldOf(stairsMesh(stairs, 2), kStairVoxel), 0, at({0, 0, 0}));
  btRigidBody& chassis =
      scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(1), btScalar(0.6), btScalar(0.2))),
                800, at({3, 0, btScalar(1.2)}));
  btRaycastVehicle::btVehicleTuning tuning;
  btDefaultVehicleRaycaster raycaster(&scene.world);
  btRaycastVehicle vehicle(tuning, &chassis, &raycaster);
  vehicle.setCoordinateSystem(1, 2, 0);
  for (const double x : {0.8, -0.8})
    for (const double y : {0.6, -0.6}) {
      btWheelInfo& wheel = vehicle.addWheel({btScalar(x), btScalar(y), 0}, {0, 0, -1}, {0, -1, 0},
                                            btScalar(0.3), btScalar(0.35), tuning, x > 0);
      wheel.m_suspensionStiffness = 30;
      wheel.m_wheelsDampingRelaxation = 3;
      wheel.m_wheelsDampingCompression = 4;
      wheel.m_frictionSlip = 5;
      wheel.m_rollInfluence = btScalar(0.1);
    }
  scene.world.addVehicle(&vehicle);
  int grounded = 0, steps = 0;
  double most = 0, least = 10;
  while (steps < 600 && chassis.getWorldTransform().getOrigin().x() < 14) {
    const double speed = chassis.getLinearVelocity().x();
    for (int wheel = 2; wheel < 4; ++wheel)
      vehicle.applyEngineForce(btScalar(steps > 60 && speed < 3 ? 800 : 0), wheel);
    scene.step(1. / 60);
    ++steps;
    if (steps < 60) continue;  // it settles
    for (int wheel = 0; wheel < 4; ++wheel)
      grounded += vehicle.getWheelInfo(wheel).m_raycastInfo.m_isInContact;
    const btVector3 place = chassis.getWorldTransform().getOrigin();
    const double above = place.z() - heightAt(stairs, place.x());
    most = std::max(most, above);
    least = std::min(least, above);
  }
  const btVector3 place = chassis.getWorldTransform().getOrigin();
  EXPECT_GT(place.x(), 13.9) << "it drives";
  EXPECT_GT(grounded, 4 * (steps - 60) * 9 / 10) << "wheels find the cloud";
  EXPECT_GT(least, 0.35);
  EXPECT_LT(most, 0.8);
  scene.world.removeVehicle(&vehicle);
}

TEST(Ghost, SeesStairsAndTouchesThem) {
  const Stairs stairs = {{1, 0.2}, {2, 0.5}};
  GhostWorld scene;
  btRigidBody& cloud =
      scene.addCloud(fieldOf(stairsMesh(stairs, 0.5), kStairVoxel), 0, at({0, 0, 0}));
  btSphereShape ball(btScalar(0.2));
  btPairCachingGhostObject ghost;
  ghost.setCollisionShape(&ball);
  ghost.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
  scene.world.addCollisionObject(&ghost, btBroadphaseProxy::DefaultFilter,
                                 btBroadphaseProxy::AllFilter);
  const auto moveTo = [&](double x, double z) {
    ghost.setWorldTransform(at({btScalar(x), 0, btScalar(z)}));
    scene.detect();
  };
  // The deepest contact of the pairs of the ghost's own list.
  const auto distance = [&] {
    double least = 1;
    btManifoldArray manifolds;
    btHashedOverlappingPairCache& pairs = *ghost.getOverlappingPairCache();
    scene.dispatcher.dispatchAllCollisionPairs(&pairs, scene.world.getDispatchInfo(),
                                               &scene.dispatcher);
    for (int i = 0; i < pairs.getNumOverlappingPairs(); ++i)
      if (btCollisionAlgorithm* const pair = pairs.getOverlappingPairArray()[i].m_algorithm)
        pair->getAllContactManifolds(manifolds);
    for (int i = 0; i < manifolds.size(); ++i)
      for (int k = 0; k < manifolds[i]->getNumContacts(); ++k)
        least = std::min<double>(least, manifolds[i]->getContactPoint(k).getDistance());
    return least;
  };
  moveTo(0.5, 0.35);
  ASSERT_EQ(ghost.getNumOverlappingObjects(), 1);
  EXPECT_EQ(ghost.getOverlappingObject(0), &cloud);
  EXPECT_NEAR(distance(), -0.05, 0.1 * kStairVoxel);
  const btVector3 low(btScalar(0.5), 0, 0), high(btScalar(0.5), 0, btScalar(0.9));
  btCollisionWorld::ClosestRayResultCallback ray(high, low);
  ghost.rayTest(high, low, ray);
  ASSERT_TRUE(ray.hasHit());
  EXPECT_NEAR(ray.m_hitPointWorld.z(), 0.2, 0.05 * kStairVoxel);
  btCollisionWorld::ClosestConvexResultCallback sweep(high, low);
  ghost.convexSweepTest(&ball, at(high), at(low), sweep);
  ASSERT_TRUE(sweep.hasHit());
  EXPECT_NEAR(0.9 * (1 - sweep.m_closestHitFraction), 0.4, 0.1 * kStairVoxel);
  moveTo(0.5, 2);
  EXPECT_EQ(ghost.getNumOverlappingObjects(), 0);
  scene.world.removeCollisionObject(&ghost);
}

}  // namespace
}  // namespace cloudcontact::testing::character_query_test
