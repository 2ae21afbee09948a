// Bodies in motion against mechanics: rest, slopes, rolling, falling, momentum, sleep; and runs
// that repeat to the bit.
#include <cloudcontact/law/automatic_spring.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::physics_test {
namespace {

constexpr double kVoxel = 0.01, kGravity = 9.81;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}

btVector3 vector(const Vec3& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

double energy(const btRigidBody& body) {
  const btVector3 spin = body.getAngularVelocity() * body.getWorldTransform().getBasis();
  const btVector3 inverse = body.getInvInertiaDiagLocal();
  double sum = body.getLinearVelocity().length2() / 2 / body.getInvMass() +
               kGravity * body.getWorldTransform().getOrigin().z() / body.getInvMass();
  for (int axis = 0; axis < 3; ++axis) sum += spin[axis] * spin[axis] / 2 / inverse[axis];
  return sum;
}

// A minute at 240 Hz without sleeping, on Bullet's plane and on a cloud with a turned grid.
TEST(Rest, ACubeStaysWhereItIsPut) {
  const auto slab = fieldOf(boxMesh({0.5, 0.4, 0.1}), kVoxel);
  for (const bool onCloud : {false, true}) {
    BulletWorld scene;
    if (onCloud)
      scene.addCloud(slab, 0, at({0, 0, btScalar(-0.05)}, btQuaternion({0, 0, 1}, btScalar(0.3))));
    else
      scene.addGround();
    btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
    for (int i = 0; i < 240; ++i) scene.step(1. / 240);
    const btVector3 settled = cube.getWorldTransform().getOrigin();
    for (int i = 0; i < 60 * 240; ++i) scene.step(1. / 240);
    EXPECT_LT(cube.getWorldTransform().getOrigin().distance(settled), 0.01 * kVoxel)
        << (onCloud ? "on a cloud" : "on a plane");
  }
}

constexpr double kSteps[] = {1. / 60, 1. / 240, 1e-3};

// A box on a slope of the given tangent, at the depth to which it will sag.
struct Slope {
  BulletWorld scene;
  btRigidBody* box;
  Vec3 down;
  double angle;
  double step;

  Slope(double tangent, double friction, double yaw, double length, double height,
        const CloudContactSettings& settings = {})
      : scene(settings), angle(std::atan(tangent)), step(length) {
    const Vec3 normal(-std::sin(angle) * std::cos(yaw), -std::sin(angle) * std::sin(yaw),
                      std::cos(angle));
    down =
        Vec3(-std::cos(angle) * std::cos(yaw), -std::cos(angle) * std::sin(yaw), -std::sin(angle));
    scene.add(std::make_unique<btStaticPlaneShape>(vector(normal), 0), 0, at({0, 0, 0}))
        .setFriction(1);
    const double load = kGravity * std::cos(angle);
    const double sag = settings.law ? load / sharedSpring(*settings.law).stiffness
                                    : automaticSpring(1, kGravity, kVoxel, step).sag(load);
    const btTransform place =
        at(vector((height / 2 - sag) * normal), shortestArcQuat({0, 0, 1}, vector(normal)));
    box = &scene.addCloud(height == 0.2 ? cubeField() : brickField(), 1, place);
    box->setFriction(btScalar(friction));
  }

  static std::shared_ptr<const SurfaceField> brickField() {
    static const auto field = fieldOf(boxMesh({0.4, 0.4, 0.1}), kVoxel);
    return field;
  }

  // The distance that it slides in `seconds` [m].
  double run(double seconds) {
    const btVector3 before = box->getWorldTransform().getOrigin();
    for (int i = 0; i < seconds / step; ++i) scene.step(step);
    return (box->getWorldTransform().getOrigin() - before).dot(vector(down));
  }
};

// g (sin - mu cos) t^2 / 2: the distance of a body that slides from the start, after 3 s.
double freeWay(double tangent, double friction) {
  const double angle = std::atan(tangent);
  return kGravity * (std::sin(angle) - friction * std::cos(angle)) * 9 / 2;
}

// The stiffest spring of the step, with which the cube hardly leans.
TEST(OnASlope, FrictionHoldsAboveTheTangentAndDoesNotBelow) {
  CloudContactSettings hard;
  hard.law = stepLimited(1, 1. / 240);
  for (const double yaw : {0.0, 0.4}) {
    EXPECT_LT(Slope(0.5, 0.51, yaw, 1. / 240, 0.2, hard).run(3), 0.1 * kVoxel) << "yaw " << yaw;
    // It may start late.
    const double gone = Slope(0.5, 0.48, yaw, 1. / 240, 0.2, hard).run(3);
    EXPECT_GT(gone, 0.8 * freeWay(0.5, 0.48)) << "yaw " << yaw;
    EXPECT_LT(gone, 1.02 * freeWay(0.5, 0.48)) << "yaw " << yaw;
  }
}

// A brick hardly leans. With a stated spring and without, at all steps: a sliding brick must not be
// pulled back, and a standing one must not creep once it has settled.
TEST(OnASlope, ABrickDistinguishes049From051AtEveryStepAndWithAnySpring) {
  CloudContactSettings stated;
  stated.law = KelvinVoigt{9810, 2 * std::sqrt(9810)};
  for (const auto& settings : {CloudContactSettings{}, stated})
    for (const double yaw : {0.0, 0.4})
      for (const double step : kSteps) {
        Slope stands(0.5, 0.51, yaw, step, 0.1, settings);
        stands.run(2);
        EXPECT_LT(stands.run(1), 0.1 * kVoxel) << "yaw " << yaw << ' ' << step;
        const double gone = Slope(0.5, 0.49, yaw, step, 0.1, settings).run(3);
        EXPECT_NEAR(gone, freeWay(0.5, 0.49), 0.2 * freeWay(0.5, 0.49))
            << "yaw " << yaw << ' ' << step;
      }
}

TEST(OnASlope, StandingMeansNoCreep) {
  for (const double yaw : {0.0, 0.4})
    for (const double step : kSteps) {
      Slope slope(std::tan(25 * SIMD_RADS_PER_DEG), 0.6, yaw, step, 0.2);
      slope.run(1);
      EXPECT_LT(std::abs(slope.run(10)), 0.01 * kVoxel) << "yaw " << yaw << ' ' << step;
    }
}

TEST(Rolling, ASphereKeepsItsSpeed) {
  const auto ball = fieldOf(sphereMesh(0.2, 1e-5), kVoxel);
  CloudContactSettings settings;
  settings.law = KelvinVoigt{1e4, 200};
  BulletWorld scene(settings);
  scene.addGround();
  btRigidBody& sphere = scene.addCloud(ball, 1, at({0, 0, btScalar(0.2)}));
  sphere.setLinearVelocity({1, 0, 0});
  sphere.setAngularVelocity({0, 5, 0});
  for (int i = 0; i < 720; ++i) scene.step(1. / 240);
  EXPECT_GT(sphere.getLinearVelocity().x(), 0.98);
  EXPECT_LT(sphere.getLinearVelocity().x(), 1.01);
  EXPECT_NEAR(sphere.getWorldTransform().getOrigin().x(), 3, 0.06);
  EXPECT_NEAR(sphere.getAngularVelocity().y() * 0.2, sphere.getLinearVelocity().x(), 0.01);
}

TEST(Rolling, WhereNobodyStatesAStiffnessABallAndACylinderKeep99PercentIn3Seconds) {
  const auto ball = fieldOf(sphereMesh(0.2, 1e-5), kVoxel);
  const auto table = fieldOf(boxMesh({4, 0.6, 0.1}), kVoxel);
  for (const bool cylinder : {false, true})
    for (const double step : kSteps) {
      BulletWorld scene;
      scene.addCloud(table, 0, at({1.5, 0, btScalar(-0.05)}));
      const btTransform place = at({0, 0, btScalar(0.199)});
      btRigidBody& body =
          cylinder
              ? scene.add(std::make_unique<btCylinderShape>(btVector3(0.2f, 0.1f, 0.2f)), 1, place)
              : scene.addCloud(ball, 1, place);
      body.setLinearVelocity({1, 0, 0});
      body.setAngularVelocity({0, 5, 0});
      for (int i = 0; i < 3 / step; ++i) scene.step(step);
      EXPECT_GT(body.getLinearVelocity().x(), 0.99) << (cylinder ? "cylinder " : "ball ") << step;
      EXPECT_LT(body.getLinearVelocity().x(), 1.01) << (cylinder ? "cylinder " : "ball ") << step;
    }
}

TEST(Falling, NeverGainsEnergyOnAnyCornerOrEdge) {
  const btVector3 axes[] = {{1, 2, 3}, {1, 0, 0}, {1, 1, 0}};
  for (const btVector3& axis : axes) {
    BulletWorld scene;
    scene.addGround();
    btRigidBody& cube =
        scene.addCloud(cubeField(), 1,
                       at({0, 0, btScalar(0.4)}, btQuaternion(axis.normalized(), btScalar(0.785))));
    const double start = energy(cube);
    double most = start;
    for (int i = 0; i < 720; ++i) {
      scene.step(1. / 240);
      most = std::max(most, energy(cube));
    }
    EXPECT_LE(most, 1.001 * start);
    EXPECT_LT(energy(cube), 0.5 * start) << "it did not fall";
    EXPECT_GT(cube.getWorldTransform().getOrigin().z(), 0.095) << "it fell through";
  }
}

// A body that moves 1.7 voxels a step gets points a step before it touches, wherever that step
// ends. With points within a voxel only, it would be 0.7 voxel deep at worst.
TEST(Falling, FasterThanAVoxelAStepIsStoppedAtTheSurface) {
  const double step = 1. / 100, half = 0.1;
  const auto slab = fieldOf(boxMesh({0.5, 0.4, 0.1}), kVoxel);
  for (int phase = 0; phase < 8; ++phase) {
    BulletWorld scene;
    scene.world.setGravity({0, 0, 0});
    scene.addCloud(slab, 0, at({0, 0, btScalar(-0.05)}));
    const double gap = (4 + phase / 8.0 * 1.7) * kVoxel;
    btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(half + gap)}));
    cube.setLinearVelocity({0, 0, btScalar(-1.7 * kVoxel / step)});
    double lowest = 1;
    for (int i = 0; i < 20; ++i) {
      scene.step(step);
      lowest = std::min(lowest, double(cube.getWorldTransform().getOrigin().z()) - half);
    }
    EXPECT_GT(lowest, -0.3 * kVoxel) << "phase " << phase;
    EXPECT_LT(lowest, kVoxel) << "it never came";
  }
}

TEST(Momentum, TwoFreeBodiesInContactKeepTheirs) {
  BulletWorld scene;
  scene.world.setGravity({0, 0, 0});
  btRigidBody& a = scene.addCloud(cubeField(), 1, at({0, 0, 0}));
  btRigidBody& b = scene.addCloud(
      cubeField(), 3,
      at({btScalar(0.3), btScalar(0.05), btScalar(0.02)}, btQuaternion({0, 0, 1}, btScalar(0.3))));
  for (btRigidBody* body : {&a, &b}) {
    body->setFriction(btScalar(0.7));
    body->setDamping(0, 0);
  }
  b.setLinearVelocity({-1, btScalar(0.2), 0});
  const auto linear = [&] { return a.getLinearVelocity() + b.getLinearVelocity() * 3; };
  const auto angular = [&] {
    btVector3 sum(0, 0, 0);
    for (const btRigidBody* body : {&a, &b})
      sum += body->getWorldTransform().getOrigin().cross(body->getLinearVelocity()) /
                 body->getInvMass() +
             body->getInvInertiaTensorWorld().inverse() * body->getAngularVelocity();
    return sum;
  };
  const btVector3 linearBefore = linear(), angularBefore = angular();
  double exchanged = 0;
  for (int i = 0; i < 240; ++i) {
    scene.step(1. / 240);
    exchanged = std::max<double>(exchanged, a.getLinearVelocity().length());
  }
  ASSERT_GT(exchanged, 0.1) << "they never met";
  EXPECT_NEAR((linear() - linearBefore).length(), 0, 10 * kRounding);
  // Friction acts on each body's own surface, so its two arms differ by the depth.
  EXPECT_NEAR((angular() - angularBefore).length(), 0, 0.01);
}

TEST(Sleep, ACubeFallsAsleepKeepsItsContactAndWakes) {
  BulletWorld scene;
  scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
  cube.forceActivationState(ACTIVE_TAG);
  for (int i = 0; i < 1200 && cube.isActive(); ++i) scene.step(1. / 240);
  ASSERT_FALSE(cube.isActive());
  const auto asleep = scene.points();
  EXPECT_FALSE(asleep.empty());
  const auto pairs = scene.clouds.statistics().pairs;
  for (int i = 0; i < 10; ++i) scene.step(1. / 240);
  EXPECT_EQ(scene.clouds.statistics().pairs, pairs) << "a sleeping pair costs nothing";
  EXPECT_EQ(scene.points().size(), asleep.size());
  cube.activate(true);
  cube.applyCentralImpulse({0, 0, 1});
  for (int i = 0; i < 24; ++i) scene.step(1. / 240);
  EXPECT_GT(cube.getWorldTransform().getOrigin().z(), 0.12);
}

TEST(Determinism, TheSameSceneTwiceIsTheSameToTheBit) {
  const auto run = [] {
    BulletWorld scene;
    scene.addGround();
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < 4; ++i)
      cubes.push_back(&scene.addCloud(
          cubeField(), 1,
          at({btScalar(0.03 * i), btScalar(0.01 * i), btScalar(0.15 + 0.25 * i)},
             btQuaternion(btVector3(1, btScalar(i), 2).normalized(), btScalar(0.1 * i)))));
    for (int i = 0; i < 200; ++i) scene.step(1. / 240);
    std::vector<btScalar> state;
    for (const btRigidBody* cube : cubes)
      for (int axis = 0; axis < 3; ++axis) {
        state.push_back(cube->getWorldTransform().getOrigin()[axis]);
        state.push_back(cube->getLinearVelocity()[axis]);
        state.push_back(cube->getAngularVelocity()[axis]);
      }
    return state;
  };
  const auto first = run(), second = run();
  EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(btScalar)), 0);
}

}  // namespace
}  // namespace cloudcontact::testing::physics_test
