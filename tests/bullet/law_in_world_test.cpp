// The Kelvin-Voigt law in Bullet's solver against the exact backward Euler recurrence, m g / k, and
// the formula for springs in series.
#include <cloudcontact/law/automatic_spring.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::law_in_world_test {
namespace {

constexpr double kVoxel = 0.01, kGravity = 9.81;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}

// Depth of the cube's ideal face below the ground.
double depthOf(const btRigidBody& cube) {
  return 0.1 - cube.getWorldTransform().getOrigin().z();
}

TEST(LawInWorld, AFallingCubeFollowsTheBackwardEulerRecurrence) {
  // m (v+ - v) = -m g h + h max(0, k (d - h v+) - c v+), d the depth before the step, without a
  // free parameter. Springs from soft and undamped to stiff and overdamped.
  const KelvinVoigt materials[] = {{500, 0}, {2e4, 30}, {1e5, 2000}};
  for (const KelvinVoigt& law : materials) {
    CloudContactSettings settings;
    settings.law = law;
    BulletWorld scene(settings);
    scene.world.getSolverInfo().m_numIterations = 100;
    scene.addGround();
    const double mass = 2, step = 1e-3;
    btRigidBody& cube = scene.addCloud(cubeField(), mass, at({0, 0, btScalar(0.101)}));
    double depth = depthOf(cube), speed = 0;  // upward
    double worst = 0, deepest = 0;
    for (int i = 0; i < 400; ++i) {
      const double free = speed - kGravity * step;
      const double held = (mass * free + step * law.stiffness * depth) /
                          (mass + step * step * law.stiffness + step * law.damping);
      speed = depth > 0 ? std::max(free, held) : free;
      depth -= step * speed;
      scene.step(step);
      worst = std::max(worst, std::abs(depthOf(cube) - depth));
      deepest = std::max(deepest, depth);
    }
    EXPECT_GT(deepest, 1e-4) << "the test never touched";
    EXPECT_LT(worst, 0.02 * kVoxel) << "k " << law.stiffness << ", deepest " << deepest;
  }
}

TEST(LawInWorld, EveryPointsImpulseIsTheLawAtTheStepsEnd) {
  // impulse = h (k d+ - c v+) for each row by itself, where d+ = d + h v+ and v+ closes.
  CloudContactSettings settings;
  settings.law = KelvinVoigt{3000, 20};
  BulletWorld scene(settings);
  scene.world.getSolverInfo().m_numIterations = 500;
  scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.096)}));
  cube.setLinearVelocity({btScalar(0.02), 0, btScalar(-0.05)});
  cube.setAngularVelocity({btScalar(0.1), btScalar(-0.2), 0});
  const double step = 1. / 240;
  scene.step(step);
  ASSERT_GE(scene.points().size(), 3u);
  const btVector3 before(0, 0, btScalar(0.096));
  for (const btManifoldPoint& p : scene.points()) {
    // The cube is body 1: the ground was added first.
    const btVector3 velocity =
        cube.getLinearVelocity() + cube.getAngularVelocity().cross(p.m_positionWorldOnB - before);
    const double closing = velocity.dot(p.m_normalWorldOnB);
    const double depth = -p.m_distance1 + step * closing;
    const double impulse =
        step * (p.m_combinedContactStiffness1 * depth + p.m_combinedContactDamping1 * closing);
    EXPECT_GT(impulse, 0);
    EXPECT_NEAR(p.m_appliedImpulse, impulse, 2e-3 * impulse);
  }
}

TEST(LawInWorld, SagIsWeightOverStiffness) {
  const auto slab = fieldOf(boxMesh({0.5, 0.4, 0.1}), kVoxel);
  for (const bool onCloud : {false, true})
    for (const double stiffness : {500.0, 2e3, 5e3, 2e4, 1e5, 1e6}) {
      const double mass = 1;
      CloudContactSettings settings;
      settings.law = KelvinVoigt{stiffness, 2 * std::sqrt(stiffness * mass)};
      BulletWorld scene(settings);
      if (onCloud)
        scene.addCloud(slab, 0,
                       at({0, 0, btScalar(-0.05)}, btQuaternion({0, 0, 1}, btScalar(0.3))));
      else
        scene.addGround();
      btRigidBody& cube = scene.addCloud(cubeField(), mass, at({0, 0, btScalar(0.1)}));
      for (int i = 0; i < 480; ++i) scene.step(1. / 240);
      const double sag = mass * kGravity / stiffness;
      EXPECT_NEAR(depthOf(cube), sag, std::max(0.01 * sag, 0.01 * kVoxel))
          << "k " << stiffness << (onCloud ? " on a cloud" : " on a plane");
    }
}

// The sum of the contacts' stiffnesses.
double stiffnessOf(BulletWorld& scene) {
  scene.detect();
  double sum = 0;
  for (const btManifoldPoint& p : scene.points()) sum += p.m_combinedContactStiffness1;
  return sum;
}

// The contacts of a pair at rest push with the automatic spring's force at their mean depth.
void expectAutomatic(BulletWorld& scene, double mass, double weight, double voxel = kVoxel) {
  scene.detect();
  double push = 0, whole = 0, depth = 0;
  for (const btManifoldPoint& p : scene.points()) {
    push -= p.m_combinedContactStiffness1 * p.m_distance1;
    depth -= p.m_distance1;
    whole += 1;
  }
  ASSERT_GT(whole, 0);
  const AutomaticSpring spring = automaticSpring(mass, weight, voxel, 0.01);
  const double force = spring.force(depth / whole);
  EXPECT_NEAR(push, force, 0.02 * force) << "at " << depth / whole / kVoxel << " voxels";
}

TEST(LawInWorld, ShapesLawsPrecedeBulletsAndAutomaticSprings) {
  const auto scene = [](std::optional<KelvinVoigt> cloud, std::optional<KelvinVoigt> ground) {
    auto made = std::make_unique<BulletWorld>();
    btRigidBody& plane = made->addGround();
    if (ground)
      plane.setContactStiffnessAndDamping(btScalar(ground->stiffness), btScalar(ground->damping));
    btRigidBody& cube = made->addCloud(cubeField(), 3, at({0, 0, btScalar(0.097)}));
    static_cast<CloudShape*>(cube.getCollisionShape())->law = cloud;
    made->world.getDispatchInfo().m_timeStep = btScalar(0.01);
    return made;
  };
  EXPECT_NEAR(stiffnessOf(*scene(KelvinVoigt{2000, 1}, std::nullopt)), 2000, 0.01);
  EXPECT_NEAR(stiffnessOf(*scene(std::nullopt, KelvinVoigt{700, 1})), 700, 0.01);
  EXPECT_NEAR(stiffnessOf(*scene(KelvinVoigt{2000, 1}, KelvinVoigt{500, 1})), 400, 0.01);
  // Neither: the automatic spring.
  expectAutomatic(*scene(std::nullopt, std::nullopt), 3, 3 * kGravity);
}

TEST(LawInWorld, TwoFreeBodiesShareAnAutomaticSpringByTheirReducedMass) {
  BulletWorld scene;
  scene.addCloud(cubeField(), 3, at({0, 0, 0}));
  scene.addCloud(cubeField(), 6, at({0, 0, btScalar(0.197)}));
  scene.world.getDispatchInfo().m_timeStep = btScalar(0.01);
  // Reduced mass 3 * 6 / 9, the weight of the heavier body, a quarter of the lengths.
  expectAutomatic(scene, 2, 6 * kGravity, 0.25 * kVoxel);
}

// The spring follows the world's gravity; without gravity it is as on the ground.
TEST(LawInWorld, TheAutomaticSpringFollowsGravity) {
  for (const double gravity : {0.0, 1.62, 9.81}) {
    BulletWorld scene;
    scene.world.setGravity({0, 0, btScalar(-gravity)});
    scene.addGround();
    scene.addCloud(cubeField(), 3, at({0, 0, btScalar(0.0995)}));
    scene.world.getDispatchInfo().m_timeStep = btScalar(0.01);
    expectAutomatic(scene, 3, 3 * (gravity > 0 ? gravity : kGravity));
  }
}

TEST(LawInWorld, OwnWeightSagsAlikeAtEveryStepWhereNobodyStatesAStiffness) {
  const auto slab = fieldOf(boxMesh({0.5, 0.4, 0.1}), kVoxel);
  for (const bool onCloud : {false, true})
    for (const bool byArea : {false, true})
      for (const double step : {1. / 60, 1. / 240, 1e-3})
        for (const double load : {1.0, 5.0, 20.0}) {
          CloudContactSettings settings;
          if (byArea) settings.law = Foundation{};
          BulletWorld scene(settings);
          if (onCloud)
            scene.addCloud(slab, 0, at({0, 0, btScalar(-0.05)}));
          else
            scene.addGround();
          btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
          for (int i = 0; i < 2 / step; ++i) {
            cube.applyCentralForce({0, 0, btScalar(-(load - 1) * kGravity)});
            scene.step(step);
          }
          const double sag = automaticSpring(1, kGravity, kVoxel, step).sag(load * kGravity);
          EXPECT_NEAR(depthOf(cube), sag, std::max(0.02 * kVoxel, 0.05 * sag))
              << "step " << step << ", " << load << " times its weight"
              << (onCloud ? " on a cloud" : " on a plane");
        }
}

TEST(LawInWorld, FoundationIsStiffnessTimesArea) {
  CloudContactSettings settings;
  settings.law = Foundation{1e6, 0};  // [N/m^3]
  BulletWorld scene(settings);
  scene.addGround();
  scene.addCloud(cubeField(), 3, at({0, 0, btScalar(0.097)}));
  EXPECT_NEAR(stiffnessOf(scene), 1e6 * 0.04, 0.03 * 1e6 * 0.04);
}

TEST(LawInWorld, FoundationWithoutAStiffnessSharesOutAnAutomaticSpring) {
  CloudContactSettings settings;
  settings.law = Foundation{};
  BulletWorld scene(settings);
  scene.addGround();
  scene.addCloud(cubeField(), 3, at({0, 0, btScalar(0.097)}));
  scene.world.getDispatchInfo().m_timeStep = btScalar(0.01);
  expectAutomatic(scene, 3, 3 * kGravity);
}

}  // namespace
}  // namespace cloudcontact::testing::law_in_world_test
