// Springs of joints: a body on one swings between rest's two sides and never gains energy, however
// long a step is; where steps are short it swings as its formula says.
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <tuple>

#include "scene/scene_file.h"
#include "scene/world.h"

namespace cloudcontact::program::joint_spring_test {
namespace {

constexpr double kMass = 0.5, kHalf = 0.02;  // [kg], [m] of a cube's half edge
constexpr double kRest = 0.05;               // [m], or [rad] of the hinge
constexpr double kInertia = kMass * (2 * kHalf) * (2 * kHalf) / 6;

// The joint is in the cube's middle; both axes are y.
World world(const std::string& kind, double spring, double damping, double gravity = 0) {
  std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::replace(name.begin(), name.end(), '/', '_');
  const auto path = std::filesystem::temp_directory_path() / (kind + name + "_spring.sdf");
  std::ofstream(path) << R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 )" +
                             std::to_string(-gravity) + R"( 0</gravity>
<physics name="p" type="bullet"><max_step_size>0.001</max_step_size><real_time_factor>0</real_time_factor></physics>
<model name="cube"><link name="l">
  <inertial><mass>0.5</mass></inertial>
  <collision name="c"><geometry><box><size>0.04 0.04 0.04</size></box></geometry></collision></link>
  <joint name="j" type=")" + kind +
                             R"("><parent>world</parent><child>l</child><axis><xyz>0 1 0</xyz>
    <dynamics><spring_stiffness>)" +
                             std::to_string(spring) + "</spring_stiffness><spring_reference>" +
                             std::to_string(kRest) + "</spring_reference><damping>" +
                             std::to_string(damping) +
                             "</damping></dynamics></axis></joint></model></world></sdf>";
  WorldSettings settings;
  settings.common.threads = 1;
  settings.voxel = 2e-3;
  return World(loadScene(path), settings);
}

// A swing's place and speed.
struct Swing {
  double place, speed;
};
Swing swingOf(const World& world, bool turns) {
  const auto pose = world.pose(0);
  const auto state = world.state(0);
  if (!turns) return {pose.position.y(), state.linearVelocity.y()};
  return {2 * std::atan2(pose.orientation.y(), pose.orientation.w()), state.angularVelocity.y()};
}

// Bullet's fixed body is one for all worlds of a program and lists their joints: two worlds that
// were made on two threads broke the list, and the program.
TEST(Joint, ToTheWorldSharesNothingWithOtherWorlds) {
  const int before = btTypedConstraint::getFixedBody().getNumConstraintRefs();
  const World one = world("revolute", 1, 0), other = world("prismatic", 1, 0);
  EXPECT_EQ(btTypedConstraint::getFixedBody().getNumConstraintRefs(), before);
}

// At each step's length, in radians of the swing.
class AnyStep : public ::testing::TestWithParam<std::tuple<bool, double>> {};

// The test of a wrong one: with the spring of the step's start the swing grows at all of these, and
// from 2 radians on without end.
TEST_P(AnyStep, SwingsBetweenItsEndsAndGainsNothing) {
  const auto [turns, radians] = GetParam();
  const double step = 2e-3, omega = radians / step, inert = turns ? kInertia : kMass;
  const double spring = inert * omega * omega;
  World w = world(turns ? "revolute" : "prismatic", spring, 0);
  double before = 0.5 * spring * kRest * kRest;
  for (int i = 0; i < 300; ++i) {
    w.step(step);
    const Swing s = swingOf(w, turns);
    EXPECT_GT(s.place, -1e-4 * kRest);
    EXPECT_LT(s.place, 2.0001 * kRest);
    const double energy =
        0.5 * spring * (s.place - kRest) * (s.place - kRest) + 0.5 * inert * s.speed * s.speed;
    EXPECT_LT(energy, before + 1e-4 * spring * kRest * kRest) << i;
    before = energy;
  }
}
INSTANTIATE_TEST_SUITE_P(JointSpring, AnyStep,
                         ::testing::Combine(::testing::Bool(),
                                            ::testing::Values(0.1, 0.5, 1.0, 2.0, 3.5, 7.0, 30.0)));

// Of short steps: the formula's period, and the loss of the step's own scheme, which is a factor of
// 1 / sqrt(1 + w^2 / 2) a step for a swing of w radians.
TEST(JointSpring, SwingsAsItsFormulaSays) {
  const double step = 1e-3, radians = 0.05, omega = radians / step;
  World w = world("prismatic", kMass * omega * omega, 0);
  double last = -kRest, first = 0, most = 0;
  int crossings = 0, steps = 0;
  while (crossings < 9) {
    w.step(step);
    ++steps;
    const double place = swingOf(w, false).place - kRest;
    if ((last < 0) != (place < 0)) {
      if (crossings++ == 0) first = steps - place / (place - last);
      if (crossings == 9) last = steps - place / (place - last);
    }
    if (crossings == 8) most = std::max(most, std::abs(place));
    if (crossings < 9) last = place;
  }
  const double period = (last - first) / 4;
  EXPECT_NEAR(period, 2 * std::numbers::pi / radians, 0.005 * period);
  // Between the eighth crossing and the ninth it is at its end after 8.5 half periods.
  const double turned = 8.5 * std::numbers::pi / radians - 0.5 * std::numbers::pi / radians;
  EXPECT_NEAR(most, kRest * std::pow(1 + radians * radians / 2, -0.5 * turned), 0.02 * kRest);
}

// What hangs on it stretches it by its weight, and a damper that is asked for damps.
TEST(JointSpring, HangsByItsWeight) {
  const double spring = 400, gravity = 9.81;
  World w = world("prismatic", spring, 2 * std::sqrt(spring * kMass), gravity);
  for (int i = 0; i < 1000; ++i) w.step(4e-3);
  EXPECT_NEAR(swingOf(w, false).place, kRest - kMass * gravity / spring, 1e-6);
}

// Critically damped, e (1 + omega t) exp(-omega t) is left.
TEST(JointSpring, IsDampedAsItsFormulaSays) {
  const double omega = 20, spring = kMass * omega * omega;
  World w = world("prismatic", spring, 2 * kMass * omega);
  for (int i = 1; i <= 2000; ++i) {
    w.step(1e-4);
    const double t = i * 1e-4, left = kRest * (1 + omega * t) * std::exp(-omega * t);
    EXPECT_NEAR(swingOf(w, false).place, kRest - left, 2e-3 * kRest) << t;
  }
}

}  // namespace
}  // namespace cloudcontact::program::joint_spring_test
