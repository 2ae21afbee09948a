// The other laws in Bullet's solver: creep and relaxation against closed forms, energy and
// momentum, a table against Kelvin-Voigt, and laws that cannot be combined.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::viscoelastic_world_test {
namespace {

constexpr double kVoxel = 0.01;
// Branch time 0.1 s, creep time 0.3 s.
constexpr StandardLinearSolid kSolid{1000, 2000, 200};

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}
std::shared_ptr<const SurfaceField> ballField() {
  static const auto field = fieldOf(sphereMesh(0.1, 1e-5), kVoxel);
  return field;
}

CloudContactSettings settingsOf(const Law& law) {
  CloudContactSettings settings;
  settings.law = law;
  return settings;
}

double depthOf(const btRigidBody& body) {
  return 0.1 - body.getWorldTransform().getOrigin().z();
}

// Under 20 N a solid creeps from 0.67 to 2 voxels. The body is light, so that its own oscillation
// is over at the first measurement. `more` runs between steps.
void expectCreep(const std::shared_ptr<const SurfaceField>& field, bool onCloud,
                 const std::function<void(BulletWorld&)>& more = {}) {
  static const auto slab = fieldOf(boxMesh({0.5, 0.4, 0.1}), kVoxel);
  BulletWorld scene(settingsOf(kSolid));
  scene.world.setGravity({0, 0, 0});
  if (onCloud)
    scene.addCloud(slab, 0, at({0, 0, btScalar(-0.05)}));
  else
    scene.addGround();
  btRigidBody& body = scene.addCloud(field, 0.01, at({0, 0, btScalar(0.1)}));
  const double load = 20, step = 1e-3, creepTime = 0.3;
  for (int i = 1; i <= 1000; ++i) {
    body.applyCentralForce({0, 0, btScalar(-load)});
    scene.step(step);
    if (more) more(scene);
    if (i % 50) continue;
    const double depth = load / 1000 * (1 - 2. / 3 * std::exp(-i * step / creepTime));
    EXPECT_NEAR(depthOf(body), depth, 0.01 * depth) << "after " << i * step << " s";
  }
}

TEST(ViscoelasticWorld, ACubeCreepsAsTheSolid) {
  expectCreep(cubeField(), false);
  expectCreep(cubeField(), true);
}

TEST(ViscoelasticWorld, ABallCreepsAsTheSolid) {
  expectCreep(ballField(), false);
}

TEST(ViscoelasticWorld, LookingForContactsByHandTakesNoTime) {
  expectCreep(cubeField(), false, [](BulletWorld& scene) {
    scene.detect();
    scene.detect();
    scene.detect();
  });
}

double pushOf(const BulletWorld& scene, double step) {
  double sum = 0;
  for (const btManifoldPoint& p : scene.points()) sum += p.m_appliedImpulse / step;
  return sum;
}

TEST(ViscoelasticWorld, AHeldBodyIsPushedLessAndLess) {
  const Maxwell maxwell{3000, 300};
  const auto solidForce = [](double d, double t) { return d * (1000 + 2000 * std::exp(-t / 0.1)); };
  const auto maxwellForce = [](double d, double t) { return 3000 * d * std::exp(-t / 0.1); };
  for (const bool solid : {true, false}) {
    BulletWorld scene(settingsOf(solid ? Law(kSolid) : Law(maxwell)));
    scene.world.setGravity({0, 0, 0});
    scene.world.getSolverInfo().m_numIterations = 50;
    scene.addGround();
    scene.addCloud(cubeField(), 1e6, at({0, 0, btScalar(0.085)}));  // too heavy to move
    const double step = 2.5e-4;
    for (int i = 1; i <= 1200; ++i) {
      scene.step(step);
      if (i % 100) continue;
      const double force = solid ? solidForce(0.015, i * step) : maxwellForce(0.015, i * step);
      EXPECT_NEAR(pushOf(scene, step), force, 0.01 * force) << "after " << i * step << " s";
    }
  }
}

// Under a load Maxwell's depth grows by load / c without end.
TEST(ViscoelasticWorld, OnAMaxwellABodySinksSteadily) {
  BulletWorld scene(settingsOf(Maxwell{3000, 2000}));
  scene.world.setGravity({0, 0, 0});
  scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 0.01, at({0, 0, btScalar(0.1)}));
  for (int i = 1; i <= 1000; ++i) {
    cube.applyCentralForce({0, 0, -20});
    scene.step(1e-3);
    if (i < 100 || i % 100) continue;
    const double depth = 20. / 3000 + 20 * i * 1e-3 / 2000;
    EXPECT_NEAR(depthOf(cube), depth, 0.01 * depth) << i;
  }
}

std::vector<Law> allLaws() {
  return {KelvinVoigt{3000, 0},
          Maxwell{3000, 3000},
          kSolid,
          UserLaw{[](double d, double v) {  // Hunt and Crossley's
            return 3e4 * std::pow(d, 1.5) * std::max(0.0, 1 + 0.5 * v);
          }},
          TableLaw{{{0.005, 10}, {0.01, 40}, {0.02, 200}}, 1},
          TableLaw{{{0.005, 40}, {0.01, 60}, {0.02, 80}}, 0}};
}

double energyOf(const btRigidBody& body) {
  const double mass = 1 / body.getInvMass();
  const btVector3 w = body.getAngularVelocity() * body.getWorldTransform().getBasis();
  const btVector3 inverse = body.getInvInertiaDiagLocal();
  double energy = 0.5 * mass * body.getLinearVelocity().length2() +
                  mass * 9.81 * body.getWorldTransform().getOrigin().z();
  for (int i = 0; i < 3; ++i) energy += 0.5 * w[i] * w[i] / inverse[i];
  return energy;
}

TEST(ViscoelasticWorld, ADropGainsNoEnergyOnAnyLaw) {
  int n = 0;
  for (const Law& law : allLaws()) {
    for (const double step : {1. / 240, 1e-3})
      for (const bool turned : {false, true}) {
        BulletWorld scene(settingsOf(law));
        scene.addGround();
        const btQuaternion askew(btVector3(1, 2, 0).normalized(), turned ? btScalar(0.7) : 0);
        btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.3)}, askew));
        const double start = energyOf(cube);
        double most = 0, deepest = 0;
        for (int i = 0; i < 1.5 / step; ++i) {
          scene.step(step);
          most = std::max(most, energyOf(cube));
          for (const auto& p : scene.points()) deepest = std::max(deepest, -double(p.m_distance1));
        }
        EXPECT_LT(most, start * (1 + 1e-4)) << n << ", step " << step << ", turned " << turned;
        EXPECT_GT(deepest, 1e-3) << "never touched";
      }
    ++n;
  }
}

TEST(ViscoelasticWorld, TwoFreeBodiesKeepTheirMomentum) {
  for (const Law& law : allLaws()) {
    BulletWorld scene(settingsOf(law));
    scene.world.setGravity({0, 0, 0});
    btRigidBody& a = scene.addCloud(cubeField(), 1, at({0, 0, 0}));
    btRigidBody& b = scene.addCloud(ballField(), 2, at({btScalar(0.03), 0, btScalar(0.22)}));
    a.setLinearVelocity({0, 0, btScalar(0.5)});
    b.setLinearVelocity({0, 0, btScalar(-0.3)});
    const auto momentum = [&] { return a.getLinearVelocity() + 2 * b.getLinearVelocity(); };
    const btVector3 start = momentum();
    for (int i = 0; i < 300; ++i) scene.step(1e-3);
    EXPECT_LT((momentum() - start).length(), 10 * kRounding);
    EXPECT_GT((a.getLinearVelocity() - btVector3(0, 0, btScalar(0.5))).length(), 0.1);
  }
}

TEST(ViscoelasticWorld, AStraightTableIsThePairsSpring) {
  BulletWorld one(settingsOf(KelvinVoigt{4000, 25})), other(settingsOf(TableLaw{{{0.1, 400}}, 25}));
  std::vector<btRigidBody*> cubes;
  for (BulletWorld* scene : {&one, &other}) {
    scene->addGround();
    cubes.push_back(&scene->addCloud(
        cubeField(), 1, at({0, 0, btScalar(0.13)}, btQuaternion({1, 0, 0}, btScalar(0.1)))));
  }
  for (int i = 0; i < 300; ++i) {
    one.step(1e-3);
    other.step(1e-3);
  }
  const btTransform a = cubes[0]->getWorldTransform(), b = cubes[1]->getWorldTransform();
  EXPECT_LT((a.getOrigin() - b.getOrigin()).length(), 20 * kRounding);
  EXPECT_LT(depthOf(*cubes[0]), 0.02);
  EXPECT_LT(a.getRotation().angle(b.getRotation()), sizeof(btScalar) == 4 ? 2e-3 : 1e-6);
}

TEST(ViscoelasticWorld, AShapesOwnLawCountsWhereTheOtherBodyIsRigid) {
  BulletWorld scene;
  btRigidBody& ground = scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
  static_cast<CloudShape*>(cube.getCollisionShape())->law = kSolid;
  for (int i = 0; i < 4000; ++i) scene.step(1e-3);
  EXPECT_NEAR(depthOf(cube), 9.81e-3, 0.01 * 9.81e-3);
  EXPECT_EQ(scene.clouds.statistics().failures, 0u);
  ground.setContactStiffnessAndDamping(1000, 1);
  scene.step(1e-3);
  EXPECT_EQ(scene.clouds.statistics().failures, 1u);
  EXPECT_NE(scene.clouds.statistics().lastFailure.find("viscoelastic"), std::string::npos);
  EXPECT_TRUE(scene.points().empty());
}

TEST(ViscoelasticWorld, AUsersFunctionThatFailsIsCountedAndCrossesNoCallback) {
  BulletWorld scene(settingsOf(UserLaw{[](double d, double) { return d > 2e-3 ? NAN : 10.0; }}));
  scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.097)}));
  scene.step(1e-3);
  EXPECT_EQ(scene.clouds.statistics().failures, 1u);
  EXPECT_NE(scene.clouds.statistics().lastFailure.find("UserLaw"), std::string::npos);
  EXPECT_TRUE(std::isfinite(double(cube.getLinearVelocity().length())));
}

std::string refusal(const CloudContactSettings& settings) {
  try {
    const CloudContact clouds(settings);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(ViscoelasticWorld, RefusesAnInvalidLaw) {
  EXPECT_EQ(refusal(settingsOf(kSolid)), "");
  EXPECT_EQ(refusal(settingsOf(Foundation{})), "");
  EXPECT_NE(refusal(settingsOf(Foundation{-1, 0})).find("Foundation::stiffness"),
            std::string::npos);
  EXPECT_NE(refusal(settingsOf(Maxwell{1, -1})).find("Maxwell::damping"), std::string::npos);
}

}  // namespace
}  // namespace cloudcontact::testing::viscoelastic_world_test
