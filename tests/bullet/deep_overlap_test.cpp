// Bodies that are placed in each other leave by the nearest way, slowly, and come to rest.
#include <gtest/gtest.h>

#include <numbers>

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include "bullet/triangle_grounds.h"

namespace cloudcontact::testing::deep_overlap_test {
namespace {

constexpr double kHalf = 0.03;  // of the small body's edges

using ShapePtr = std::unique_ptr<btCollisionShape>;

ShapePtr small(const std::string& name) {
  static const auto cube = fieldOf(boxMesh({0.06, 0.06, 0.06}), kVoxel);
  static const auto ball = fieldOf(test::sphereMesh(kHalf, 3), kVoxel);
  if (name == "cloud cube") return exactCloud(cube);
  if (name == "cloud ball") return exactCloud(ball);
  const btScalar h = btScalar(kHalf);
  if (name == "box") return std::make_unique<btBoxShape>(btVector3(h, h, h));
  if (name == "cylinder") return std::make_unique<btCylinderShapeZ>(btVector3(h, h, h));
  return std::make_unique<btSphereShape>(h);
}

// Their top is at z = 0.1.
ShapePtr large(const std::string& name) {
  static const auto block = fieldOf(boxMesh({0.4, 0.4, 0.2}), kVoxel);
  if (name == "cloud") return exactCloud(block);
  if (name == "plane")
    return std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0.1));
  return std::make_unique<btBoxShape>(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.1)));
}

struct Overlap {
  std::string small, large;
  double depth;  // in half-edges
  double step;
  btTransform turned = btTransform::getIdentity();  // of the large body
};

void leaves(const Overlap& overlap, double most) {
  CloudContactSettings settings;
  settings.leavingSpeed = most;
  BulletWorld world(settings);
  world.world.setGravity({0, 0, 0});
  world.add(large(overlap.large), 0, overlap.turned);
  const btVector3 start(btScalar(0.01), btScalar(0.013),
                        btScalar(0.1 + kHalf * (1 - overlap.depth)));
  btRigidBody& body = world.add(small(overlap.small), 0.5, overlap.turned * at(start));
  double fastest = 0;
  for (int i = 0; i < 2 / overlap.step; ++i) {
    world.step(overlap.step);
    fastest = std::max(fastest, double(body.getLinearVelocity().length()));
  }
  const btVector3 end = overlap.turned.invXform(body.getWorldTransform().getOrigin());
  const auto where = overlap.small + " in " + overlap.large + ", " + std::to_string(overlap.depth) +
                     " deep, step " + std::to_string(overlap.step);
  EXPECT_GT(end.z(), 0.1 + kHalf - 0.2 * kVoxel) << where;
  EXPECT_LE(fastest, 1.01 * most) << where;
  if (overlap.depth < 0.3) return;  // less than two voxels are the spring's
  EXPECT_LT(std::hypot(end.x() - start.x(), end.y() - start.y()), 0.5 * kVoxel) << where;
  EXPECT_LT(body.getLinearVelocity().length(), 0.03) << where;
  EXPECT_LT(body.getAngularVelocity().length(), 0.05) << where;
}

TEST(DeepOverlap, LeavesTheNearestWay) {
  for (const double depth : {0.1, 0.3, 0.6, 0.9, 1.0, 1.1, 1.5, 2.0, 2.5, 3.0}) {
    for (const char* body : {"cloud cube", "cloud ball", "box", "cylinder", "ball"})
      for (const double step : {1.0 / 60, 1.0 / 240}) leaves({body, "cloud", depth, step}, 1);
    for (const char* body : {"cloud cube", "cloud ball"})
      for (const char* ground : {"box", "plane"}) leaves({body, ground, depth, 1.0 / 60}, 1);
  }
}

TEST(DeepOverlap, TheSpeedIsTheSettings) {
  for (const double most : {0.2, 0.5})
    for (const double depth : {0.6, 2.0}) leaves({"cloud cube", "cloud", depth, 1.0 / 60}, most);
}

TEST(DeepOverlap, WhereverTheWorldIsTurned) {
  const btTransform turned = at({btScalar(0.3), btScalar(-0.2), btScalar(0.7)},
                                btQuaternion(btVector3(1, 2, btScalar(0.5)).normalized(), 1));
  for (const double depth : {0.9, 2.0}) leaves({"cloud cube", "cloud", depth, 1.0 / 60, turned}, 1);
}

// Out of the nearest side, not up.
TEST(DeepOverlap, LeavesBySide) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  world.add(large("cloud"), 0, at({0, 0, 0}));
  btRigidBody& body = world.add(small("cloud ball"), 0.5, at({btScalar(0.16), 0, 0}));
  for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
  const btVector3 end = body.getWorldTransform().getOrigin();
  EXPECT_GT(end.x(), 0.2 + kHalf - 0.2 * kVoxel);
  EXPECT_LT(std::hypot(end.y(), end.z()), kVoxel);
}

// Bodies that fall deep into a soft spring come back as they do without the setting.
TEST(DeepOverlap, WhatMotionMadeIsTheSprings) {
  const auto rebound = [](double most) {
    CloudContactSettings settings;
    settings.law = KelvinVoigt{2e4, 0};
    settings.leavingSpeed = most;
    BulletWorld world(settings);
    world.world.setGravity({0, 0, 0});
    world.add(large("cloud"), 0, at({0, 0, 0}));
    btRigidBody& body = world.add(small("cloud cube"), 0.5, at({0, 0, btScalar(0.16)}));
    body.setLinearVelocity({0, 0, -3});  // 15 mm deep
    for (int i = 0; i < 500; ++i) world.step(1e-3);
    return double(body.getLinearVelocity().z());
  };
  EXPECT_GT(rebound(0.1), 2);
  EXPECT_EQ(rebound(0.1), rebound(std::numeric_limits<double>::infinity()));
}

// Two free bodies: their momentum stays.
TEST(DeepOverlap, MomentumStays) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  btRigidBody& one = world.add(large("cloud"), 2, at({0, 0, 0}));
  btRigidBody& other = world.add(small("cloud cube"), 0.5, at({0, 0, btScalar(0.07)}));
  for (int i = 0; i < 30; ++i) {
    world.step(1.0 / 60);
    const btVector3 sum = one.getLinearVelocity() * 2 + other.getLinearVelocity() * btScalar(0.5);
    ASSERT_LT(sum.length(), 1e-5);
  }
  EXPECT_GT(other.getWorldTransform().getOrigin().z() - one.getWorldTransform().getOrigin().z(),
            0.1);
}

// A body that a joint holds in another one stays there, and is not shaken.
TEST(DeepOverlap, WhatIsHeldStaysHeld) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  btRigidBody& block = world.add(large("cloud"), 0, at({0, 0, 0}));
  btRigidBody& body = world.add(small("cloud cube"), 0.5, at({0, 0, btScalar(0.1)}));
  btFixedConstraint joint(block, body, at({0, 0, btScalar(0.1)}), at({0, 0, 0}));
  world.world.addConstraint(&joint, false);
  for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
  double fastest = 0;
  for (int i = 0; i < 60; ++i) {
    world.step(1.0 / 60);
    fastest = std::max(fastest, double(body.getLinearVelocity().length()));
  }
  EXPECT_LT(fastest, 0.05);
  EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), 0.1, kVoxel);
  world.world.removeConstraint(&joint);
}

// A body that rests on another one and is put into it leaves, too.
TEST(DeepOverlap, AfterATeleport) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  world.add(large("cloud"), 0, at({0, 0, 0}));
  btRigidBody& body = world.add(small("cloud cube"), 0.5, at({0, 0, btScalar(0.1299)}));
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  ASSERT_FALSE(world.points().empty());
  body.setWorldTransform(at({0, 0, btScalar(0.11)}));
  body.setLinearVelocity({0, 0, 0});
  double fastest = 0;
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 60);
    fastest = std::max(fastest, double(body.getLinearVelocity().length()));
  }
  EXPECT_GT(body.getWorldTransform().getOrigin().z(), 0.1 + kHalf - 0.2 * kVoxel);
  EXPECT_LT(fastest, 0.3);
  EXPECT_LT(body.getLinearVelocity().length(), 0.03);
}

// Sleep does not end it.
TEST(DeepOverlap, LeavesAwake) {
  CloudContactSettings settings;
  settings.leavingSpeed = 0.02;
  BulletWorld world(settings);
  world.world.setGravity({0, 0, 0});
  world.add(large("cloud"), 0, at({0, 0, 0}));
  btRigidBody& body = world.add(small("cloud cube"), 0.5, at({0, 0, btScalar(0.05)}));
  body.forceActivationState(ACTIVE_TAG);
  for (int i = 0; i < 6 * 60; ++i) world.step(1.0 / 60);
  EXPECT_GT(body.getWorldTransform().getOrigin().z(), 0.1 + kHalf - kVoxel);
}

// A sensor's contacts are what they are.
TEST(DeepOverlap, SensorsPushNothing) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  btRigidBody& block = world.add(large("cloud"), 0, at({0, 0, 0}));
  block.setCollisionFlags(block.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  btRigidBody& body = world.add(small("cloud cube"), 0.5, at({0, 0, btScalar(0.11)}));
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  EXPECT_EQ(body.getWorldTransform().getOrigin().z(), btScalar(0.11));
  for (const btManifoldPoint& point : world.points()) EXPECT_LT(point.m_positionWorldOnB.z(), 0.12);
}

TEST(DeepOverlap, TheSettingMustBePositive) {
  CloudContactSettings settings;
  settings.leavingSpeed = 0;
  EXPECT_THROW(CloudContact{settings}, std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::deep_overlap_test
