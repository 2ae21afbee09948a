// Fast bodies with Bullet's CCD motion threshold: nothing passes a thin wall.
#include <gtest/gtest.h>

#include <limits>
#include <random>

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include "bullet/triangle_grounds.h"
#include "contact/first_touch.h"

namespace cloudcontact::testing::sweep_test {
namespace {

constexpr double kStep = 1.0 / 60;
constexpr double kWall = 2 * kVoxel;  // thickness
constexpr double kHalf = 0.3;         // of the wall's sides

struct Shot {
  const char* name;
  std::unique_ptr<btCollisionShape> (*make)();
};

template <typename Shape, typename... Args>
std::unique_ptr<btCollisionShape> shape(Args&&... args) {
  return std::make_unique<Shape>(std::forward<Args>(args)...);
}

const auto& nut() {
  static const auto field = fieldOf(plainNut(0.08, 0.04, 0.03), kVoxel);
  return field;
}
const auto& cube() {
  static const auto field = fieldOf(boxMesh({0.06, 0.05, 0.04}), kVoxel);
  return field;
}
const auto& ball() {
  static const auto field = fieldOf(test::sphereMesh(0.03, 3), kVoxel);
  return field;
}
const auto& wallField() {
  static const auto field = fieldOf(boxMesh({kWall, 2 * kHalf, 2 * kHalf}), kVoxel);
  return field;
}

const Shot kClouds[] = {{"ball", [] { return shape<CloudShape>(ball()); }},
                        {"box", [] { return shape<CloudShape>(cube()); }},
                        {"nut", [] { return shape<CloudShape>(nut()); }}};
const Shot kBullets[] = {
    {"Bullet's ball", [] { return shape<btSphereShape>(btScalar(0.03)); }},
    {"Bullet's box",
     [] { return shape<btBoxShape>(btVector3(btScalar(0.03), btScalar(0.025), btScalar(0.02))); }}};

double energyOf(const btRigidBody& body) {
  const btMatrix3x3 inertia = body.getInvInertiaTensorWorld().inverse();
  const btVector3 w = body.getAngularVelocity();
  return 0.5 / body.getInvMass() * body.getLinearVelocity().length2() + 0.5 * w.dot(inertia * w);
}

// Walls across x, their middle at x = 0.
Kept wallOf(const std::string& name) {
  const btVector3 half{btScalar(kWall / 2), btScalar(kHalf), btScalar(kHalf)};
  if (name == "cloud") return {std::make_unique<CloudShape>(wallField())};
  if (name == "Bullet's box") return {std::make_unique<btBoxShape>(half)};
  if (name == "plane")
    return {std::make_unique<btStaticPlaneShape>(btVector3(-1, 0, 0), btScalar(kWall / 2))};
  if (name == "hull") {
    auto hull = std::make_unique<btConvexHullShape>();
    for (int k = 0; k < 8; ++k)
      hull->addPoint(half * btVector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    return {std::move(hull)};
  }
  const Mesh closed = test::boxMesh({-kWall / 2, -kHalf, -kHalf}, {kWall / 2, kHalf, kHalf});
  if (name == "closed mesh") return bvhShape(closed);
  Mesh sheet;  // of one side
  sheet.vertices = {{0, -kHalf, -kHalf}, {0, kHalf, -kHalf}, {0, kHalf, kHalf}, {0, -kHalf, kHalf}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  return bvhShape(sheet);
}

struct Flight {
  double speed, distance, spin;
};

// Shoots a body along x at a wall.
void shoot(const Shot& shot, const std::string& wall, const Flight& flight) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  Kept fixed = wallOf(wall);
  world.add(std::move(fixed.shape), 0, at({0, 0, 0}));
  btRigidBody& body = world.add(shot.make(), 0.5,
                                at({btScalar(-flight.distance), btScalar(0.03), btScalar(-0.02)}));
  body.setCcdMotionThreshold(btScalar(0.01));
  body.setCcdSweptSphereRadius(btScalar(0.015));
  body.setLinearVelocity({btScalar(flight.speed), 0, 0});
  body.setAngularVelocity({0, btScalar(flight.spin), btScalar(0.7 * flight.spin)});
  const double before = energyOf(body);
  for (int i = 0; i < 30; ++i) {
    world.step(kStep);
    const auto where = [&] {
      return std::string(shot.name) + " on " + wall + " at " + std::to_string(flight.speed) +
             " m/s from " + std::to_string(flight.distance) + " m, spin " +
             std::to_string(flight.spin) + ", step " + std::to_string(i);
    };
    ASSERT_LT(body.getWorldTransform().getOrigin().x(), -0.01) << where();
    ASSERT_LE(energyOf(body), before * (1 + 1e-4)) << where();
  }
  EXPECT_EQ(world.clouds.statistics().failures, 0u) << world.clouds.statistics().lastFailure;
}

void shootFromAfar(const Shot& shot, const std::string& wall) {
  for (const double speed : {10.0, 100.0, 1000.0})
    for (const double part : {0.0, 0.37, 0.93})
      for (const double spin : {0.0, 20.0})
        shoot(shot, wall, {speed, 0.1 + part * speed * kStep, spin});
}

TEST(Sweep, NoFastCloudPassesAWall) {
  for (const Shot& shot : kClouds)
    for (const char* wall : {"cloud", "Bullet's box", "plane", "hull", "closed mesh", "sheet"})
      shootFromAfar(shot, wall);
}

TEST(Sweep, BulletsFastBodiesDoNotPassACloud) {
  for (const Shot& shot : kBullets) shootFromAfar(shot, "cloud");
}

// Slanting shots at a wall that can move, with any spin.
TEST(Sweep, NoDirectionPasses) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int k = 0; k < 150; ++k) {
    const Shot& shot = kClouds[k % 3];
    BulletWorld world;
    world.world.setGravity({0, 0, 0});
    btRigidBody& wall = world.addCloud(wallField(), k % 2 ? 0 : 1e6, at({0, 0, 0}));
    const double speed = std::pow(10, 2 + any(random)),
                 after = (0.05 + std::abs(any(random))) * kStep;
    const Vec3 flight = speed * Vec3(1, 1.5 * any(random), 1.5 * any(random)).normalized();
    const Vec3 start = Vec3(-0.08, 0.1 * any(random), 0.1 * any(random)) - after * flight;
    btRigidBody& body = world.add(shot.make(), 0.5, at(bullet(start)));
    body.setCcdMotionThreshold(btScalar(0.01));
    body.setLinearVelocity(bullet(flight));
    body.setAngularVelocity(bullet(100 * Vec3(any(random), any(random), any(random))));
    for (int i = 0; i < 20; ++i) {
      world.step(kStep);
      const btVector3 place =
          (wall.getWorldTransform().inverse() * body.getWorldTransform()).getOrigin();
      if (std::max(std::abs(place.y()), std::abs(place.z())) > kHalf - 0.05) break;
      ASSERT_LT(place.x(), 0) << shot.name << " " << k << ", step " << i << ", " << speed << " m/s";
    }
  }
}

// Without the threshold the body is through in one step: the test above sees what it says.
TEST(Sweep, WithoutAThresholdItPasses) {
  BulletWorld world;
  world.world.setGravity({0, 0, 0});
  world.addCloud(wallField(), 0, at({0, 0, 0}));
  btRigidBody& body = world.addCloud(cube(), 0.5, at({btScalar(-0.5), 0, 0}));
  body.setLinearVelocity({100, 0, 0});
  world.step(kStep);
  EXPECT_GT(body.getWorldTransform().getOrigin().x(), 0.5);
}

ContactBody bodyAt(const Vec3& place) {
  ContactBody body;
  body.pose.position = place;
  body.motion.center = place;
  return body;
}

// Beside a plane that turns, whose points far away have no speed limit.
TEST(Sweep, APlaneMayTurn) {
  FirstTouch touch(std::make_shared<ContactWorkspace>());
  const Solid plane = HalfSpace{{0, 0, 1}, 0};
  ContactBody ground = bodyAt({0, 0, 0}), shot = bodyAt({0, 0, 0.5});
  ground.shape = &plane;
  shot.field = ball().get();
  shot.motion.linear = {0, 0, -60};
  ground.motion.angular = {0.1, 0, 0};
  const auto found = touch.find(ground, shot, 0, kStep);
  ASSERT_TRUE(found);
  EXPECT_NEAR(60 * found->time, 0.47 + 0.5 * kVoxel, kVoxel);
  shot.motion.linear.z() = -std::numeric_limits<double>::infinity();
  EXPECT_FALSE(touch.find(ground, shot, 0, kStep));
}

// A shot against gravity, which takes a part of its speed before it meets a thin ceiling.
TEST(Sweep, GravityCounts) {
  for (const double pull : {-300.0, 300.0}) {
    BulletWorld world;
    world.world.setGravity({btScalar(pull), 0, 0});
    world.addCloud(wallField(), 0, at({0, 0, 0}));
    btRigidBody& body = world.addCloud(cube(), 0.5, at({btScalar(-0.2), 0, 0}));
    body.setCcdMotionThreshold(btScalar(0.01));
    body.setLinearVelocity({20, 0, 0});
    world.step(kStep);
    EXPECT_NEAR(body.getWorldTransform().getOrigin().x(), -0.03 - kWall / 2, 0.7 * kVoxel) << pull;
  }
}

// The time at which a ball meets a plane, a box and a ball, by closed forms.
TEST(Sweep, TheTouchIsWhereItMustBe) {
  const auto workspace = std::make_shared<ContactWorkspace>();
  FirstTouch touch(workspace);
  ContactBody shot = bodyAt({-5, 0, 0});
  shot.field = ball().get();
  shot.motion = {{300, 0, 0}, {0, 0, 4}, {-5, 0, 0}};
  const auto check = [&](const ContactBody& other, double way) {
    const auto found = touch.find(shot, other, 0, kStep);
    ASSERT_EQ(found.has_value(), way < 300 * kStep);
    if (found) {
      EXPECT_NEAR(300 * found->time, way + 0.5 * kVoxel, 0.3 * kVoxel);
      EXPECT_LT(touch.searches(), 20u);
    }
    const auto swapped = touch.find(other, shot, 0, kStep);
    ASSERT_EQ(swapped.has_value(), found.has_value());
    if (!found) return;
    EXPECT_NEAR(swapped->time, found->time, 0.1 * kVoxel / 300);
  };
  const Solid plane = HalfSpace{{-1, 0, 0}, -1.2}, box = Box{{0.1, 0.2, 0.2}}, sphere = Sphere{0.5};
  const auto solid = [](const Solid& shape, const Vec3& place = Vec3::Zero()) {
    ContactBody body = bodyAt(place);
    body.shape = &shape;
    return body;
  };
  ContactBody other = bodyAt({-1, 0.03, 0});
  other.field = ball().get();
  check(solid(plane), 5 + 1.2 - 0.03);
  check(solid(box), 5 - 0.1 - 0.03);
  check(solid(sphere), 5 - 0.5 - 0.03);
  check(other, 4 - std::sqrt(0.0027));
  check(solid(sphere, {0, 0.535, 0}), 1e9);  // passes beside
  check(solid(sphere, {0.6, 0, 0}), 1e9);    // ends before it
}

// Friction aside, a fast body that slides along a floor is stopped by the wall ahead and by nothing
// before.
TEST(Sweep, SlidesOnAndMeetsTheWall) {
  BulletWorld world;
  world.addGround();
  world.addCloud(wallField(), 0, at({1, 0, btScalar(kHalf)}));
  btRigidBody& body = world.addCloud(cube(), 0.5, at({-1, 0, btScalar(0.02)}));
  body.setFriction(0);
  body.setCcdMotionThreshold(btScalar(0.01));
  body.setLinearVelocity({50, 0, 0});
  world.step(kStep);
  EXPECT_NEAR(body.getWorldTransform().getOrigin().x(), -1 + 50 * kStep, 1e-3);
  for (int i = 0; i < 60; ++i) {
    world.step(kStep);
    ASSERT_LT(body.getWorldTransform().getOrigin().x(), 1 - 0.025);
    ASSERT_NEAR(body.getWorldTransform().getOrigin().z(), 0.02, 0.5 * kVoxel);
  }
}

}  // namespace
}  // namespace cloudcontact::testing::sweep_test
