// diagnose() names each setting that defeats the law, and its advice cures it; and each shape that
// clouds do not touch.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <gtest/gtest.h>

#include <functional>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::diagnosis_test {
namespace {

TEST(Diagnose, NamesOnlyTheWrongSetting) {
  struct Row {
    const char* names;
    std::function<void(btContactSolverInfo&)> spoil;
  };
  const Row rows[] = {
      {"m_splitImpulse", [](auto& info) { info.m_splitImpulse = 1; }},
      {"SOLVER_USE_WARMSTARTING",
       [](auto& info) { info.m_solverMode &= ~SOLVER_USE_WARMSTARTING; }},
      {"m_warmstartingFactor", [](auto& info) { info.m_warmstartingFactor = btScalar(0.85); }},
      {"SOLVER_USE_2_FRICTION_DIRECTIONS",
       [](auto& info) { info.m_solverMode &= ~SOLVER_USE_2_FRICTION_DIRECTIONS; }},
      {"SOLVER_ENABLE_FRICTION_DIRECTION_CACHING",
       [](auto& info) { info.m_solverMode &= ~SOLVER_ENABLE_FRICTION_DIRECTION_CACHING; }},
      {"m_linearSlop", [](auto& info) { info.m_linearSlop = btScalar(0.001); }},
      {"m_numIterations", [](auto& info) { info.m_numIterations = 3; }},
      {"m_leastSquaresResidualThreshold",
       [](auto& info) { info.m_leastSquaresResidualThreshold = btScalar(1e-3); }},
      {"m_sor", [](auto& info) { info.m_sor = btScalar(1.9); }},
      {"m_sor", [](auto& info) { info.m_sor = 0; }},
      {"m_globalCfm", [](auto& info) { info.m_globalCfm = btScalar(1e-3); }},
      {"m_restitutionVelocityThreshold",
       [](auto& info) { info.m_restitutionVelocityThreshold = 1; }},
  };
  for (const Row& row : rows) {
    BulletWorld scene;
    ASSERT_TRUE(diagnose(scene.world).empty()) << diagnose(scene.world)[0];
    row.spoil(scene.world.getSolverInfo());
    const auto advice = diagnose(scene.world);
    ASSERT_EQ(advice.size(), 1u) << row.names;
    EXPECT_NE(advice[0].find(row.names), std::string::npos) << advice[0];
    EXPECT_NE(advice[0].find(": "), std::string::npos) << "says no remedy: " << advice[0];
    recommendedSettings(scene.world);
    EXPECT_TRUE(diagnose(scene.world).empty()) << row.names;
  }
}

TEST(Diagnose, BulletsDefaultsAreReported) {
  BulletWorld scene;
  scene.world.getSolverInfo() = btContactSolverInfo();
  EXPECT_GE(diagnose(scene.world).size(), 3u);
}

TEST(Diagnose, ReportsAnMlcpSolver) {
  BulletWorld scene;
  btDantzigSolver dantzig;
  btMLCPSolver solver(&dantzig);
  scene.world.setConstraintSolver(&solver);
  const auto advice = diagnose(scene.world);
  scene.world.setConstraintSolver(&scene.solver);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_NE(advice[0].find("btSequentialImpulseConstraintSolver"), std::string::npos);
}

TEST(Diagnose, SplitImpulseDoesDropTheSpringOfDeepContacts) {
  // The reason for the advice: at 5 cm a spring of 100 N/m holds nothing with split impulse.
  const auto field = fieldOf(boxMesh({0.5, 0.5, 0.5}), 0.05);
  for (const bool split : {false, true}) {
    CloudContactSettings settings;
    settings.law = KelvinVoigt{100, 0};
    BulletWorld scene(settings);
    scene.addGround();
    btRigidBody& cube = scene.addCloud(field, 1, at({0, 0, btScalar(0.2)}));
    scene.world.getSolverInfo().m_splitImpulse = split;
    scene.world.setGravity({0, 0, 0});
    scene.step(0.01);
    // Backward Euler: h k d / (m + h^2 k) = 0.0495 m/s.
    EXPECT_NEAR(cube.getLinearVelocity().z(), split ? 0 : 0.0495, 2e-3) << "split " << split;
  }
}

double heightOfTower(const std::function<void(btContactSolverInfo&)>& spoil) {
  const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), 0.02);
  BulletWorld scene;
  scene.addGround();
  spoil(scene.world.getSolverInfo());
  btRigidBody* top = nullptr;
  for (int i = 0; i < 5; ++i)
    top = &scene.addCloud(field, 1, at({btScalar(0.03 * (i % 2)), 0, btScalar(0.1 + 0.1999 * i)}));
  for (int i = 0; i < 480; ++i) scene.step(1.0 / 120);
  return top->getWorldTransform().getOrigin().z();
}

TEST(Diagnose, TooFewSweepsDropATower) {
  EXPECT_NEAR(heightOfTower([](auto&) {}), 0.9, 0.01);
  EXPECT_LT(heightOfTower([](auto& info) { info.m_numIterations = 1; }), 0.85);
  EXPECT_GT(std::abs(heightOfTower([](auto& info) { info.m_sor = btScalar(2.5); }) - 0.9), 0.1);
}

// How high a ball with a restitution of 0.7 comes back after a fall of half a meter.
double bounceOf(const std::function<void(btContactSolverInfo&)>& spoil) {
  BulletWorld scene;
  btRigidBody& floor = scene.addGround();
  spoil(scene.world.getSolverInfo());
  btRigidBody& ball =
      scene.addCloud(fieldOf(sphereMesh(0.1, 1e-4), 0.01), 1, at({0, 0, btScalar(0.6)}));
  floor.setRestitution(1);
  ball.setRestitution(btScalar(0.7));
  double highest = 0;
  bool rises = false;
  for (int i = 0; i < 240; ++i) {
    scene.step(1.0 / 240);
    rises = rises || ball.getLinearVelocity().z() > 0;
    if (rises) highest = std::max(highest, double(ball.getWorldTransform().getOrigin().z()) - 0.1);
  }
  return highest;
}

TEST(Diagnose, SettingsTakeBouncesAway) {
  EXPECT_NEAR(bounceOf([](auto&) {}), 0.49 * 0.5, 0.01);
  EXPECT_LT(bounceOf([](auto& info) { info.m_restitutionVelocityThreshold = 5; }), 0.01);
  EXPECT_LT(bounceOf([](auto& info) { info.m_globalCfm = btScalar(1e-3); }), 0.21);
}

// Not named, because rows with a stiffness have their own: the sag stays the law's.
TEST(Diagnose, OtherSettingsDoNotMatter) {
  const std::function<void(btContactSolverInfo&)> rows[] = {
      [](auto& info) { info.m_erp = 0; },
      [](auto& info) { info.m_erp2 = 0; },
      [](auto& info) { info.m_erp2 = 1; },
      [](auto& info) { info.m_frictionERP = 0; },
      [](auto& info) { info.m_frictionCFM = btScalar(0.1); },
      [](auto& info) { info.m_damping = btScalar(0.5); },
      [](auto& info) { info.m_maxErrorReduction = btScalar(0.1); },
      [](auto& info) { info.m_numIterations = 4; },
      [](auto& info) { info.m_sor = btScalar(1.7); },
      [](auto& info) { info.m_leastSquaresResidualThreshold = btScalar(1e-4); }};
  const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), 0.02);
  for (const auto& change : rows) {
    CloudContactSettings settings;
    settings.law = KelvinVoigt{1e4, 100};
    BulletWorld scene(settings);
    scene.addGround();
    change(scene.world.getSolverInfo());
    EXPECT_TRUE(diagnose(scene.world).empty());
    btRigidBody& cube = scene.addCloud(field, 1, at({0, 0, btScalar(0.1)}));
    for (int i = 0; i < 240; ++i) scene.step(1.0 / 240);
    EXPECT_NEAR(0.1 - cube.getWorldTransform().getOrigin().z(), 9.81e-4, 2e-5);
  }
}

// A shape that is none of Bullet's.
class UnknownShape : public btConcaveShape {
 public:
  UnknownShape() { m_shapeType = CUSTOM_CONCAVE_SHAPE_TYPE; }
  void getAabb(const btTransform& t, btVector3& low, btVector3& high) const override {
    low = t.getOrigin() - btVector3(1, 1, 1);
    high = t.getOrigin() + btVector3(1, 1, 1);
  }
  void setLocalScaling(const btVector3&) override {}
  const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3&) const override {}
  const char* getName() const override { return "unknown"; }
  void processAllTriangles(btTriangleCallback*, const btVector3&, const btVector3&) const override {
  }

 private:
  btVector3 scaling_{1, 1, 1};
};

std::unique_ptr<btCollisionShape> flatHull() {
  auto hull = std::make_unique<btConvexHullShape>();
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) hull->addPoint({btScalar(x), btScalar(y), 0});
  return hull;
}

std::unique_ptr<btCollisionShape> gimpactCompound() {
  auto compound = std::make_unique<btGImpactCompoundShape>();
  static btBoxShape box(btVector3(1, 1, 1));
  static btTransform place = btTransform::getIdentity();
  compound->addChildShape(place, &box);
  compound->updateBound();
  return compound;
}

TEST(Diagnose, NamesShapesThatCloudsDoNotTouch) {
  struct Row {
    const char* name;
    std::function<std::unique_ptr<btCollisionShape>()> make;
  };
  const Row rows[] = {{"unknown", [] { return std::make_unique<UnknownShape>(); }},
                      {"Convex", flatHull},
                      {"GImpactCompound", gimpactCompound}};
  const auto field = fieldOf(boxMesh({0.5, 0.5, 0.5}), 0.05);
  for (const Row& row : rows) {
    BulletWorld scene;
    scene.addGround();
    scene.addCloud(field, 1, at({0, 0, btScalar(0.24)}));
    EXPECT_TRUE(diagnose(scene.world).empty()) << diagnose(scene.world)[0];
    scene.add(row.make(), 0, at({0, 0, 0}));
    const auto advice = diagnose(scene.world);
    ASSERT_EQ(advice.size(), 1u) << row.name;
    EXPECT_NE(advice[0].find(row.name), std::string::npos) << advice[0];
    EXPECT_NE(advice[0].find("Object 2"), std::string::npos) << advice[0];
    scene.detect();
    EXPECT_EQ(scene.clouds.statistics().failures, 1u) << row.name;
  }
}

TEST(Diagnose, SaysWhoTakesAPairAway) {
  const auto field = fieldOf(boxMesh({0.5, 0.5, 0.5}), 0.05);
  BulletWorld scene;
  scene.addCloud(field, 1, at({0, 0, btScalar(0.24)}));
  btTriangleMesh triangle;
  triangle.addTriangle({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  auto gimpact = std::make_unique<btGImpactMeshShape>(&triangle);
  gimpact->updateBound();
  scene.add(std::move(gimpact), 0, at({0, 0, 0}));
  EXPECT_TRUE(diagnose(scene.world).empty());
  btGImpactCollisionAlgorithm::registerAlgorithm(&scene.dispatcher);
  const auto advice = diagnose(scene.world);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_NE(advice[0].find("attach()"), std::string::npos) << advice[0];
  scene.clouds.attach(scene.dispatcher);
  EXPECT_TRUE(diagnose(scene.world).empty());
}

TEST(Diagnose, SaysThatCloudsAreNotAttached) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  recommendedSettings(world);
  CloudShape shape(fieldOf(boxMesh({0.5, 0.5, 0.5}), 0.05));
  btCollisionObject object;
  object.setCollisionShape(&shape);
  world.addCollisionObject(&object);
  const auto advice = diagnose(world);
  world.removeCollisionObject(&object);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_NE(advice[0].find("attach()"), std::string::npos) << advice[0];
}

}  // namespace
}  // namespace cloudcontact::testing::diagnosis_test
