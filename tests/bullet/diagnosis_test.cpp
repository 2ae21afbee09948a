// diagnose() names each setting that defeats the law, and its advice cures it.
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <gtest/gtest.h>

#include <functional>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing {
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

}  // namespace
}  // namespace cloudcontact::testing
