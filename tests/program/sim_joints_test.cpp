// Joints that turn, screw and drive, against mechanics: closed forms of screws, spherical
// pendulums, Cardan shafts, servos and reactions; what no joint may change; states.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "io/errors.h"
#include "program/scene_bodies.h"
#include "scene/world.h"

namespace cloudcontact::program::sim_joints_test {
namespace {

using Kind = SceneJoint::Kind;
constexpr double kPi = std::numbers::pi;
constexpr double kG = 9.8;

// A thin rod of `length` along x, without a shape.
SceneBody rod(const std::string& name, const Vec3& middle, double length, double mass) {
  SceneBody body;
  body.name = name;
  body.pose.position = middle;
  body.mass = mass;
  const double across = mass * length * length / 12;
  body.inertia = Vec3(0.01 * across, across, across).asDiagonal();
  body.inertialPose = Pose();
  return body;
}

SceneJoint jointOf(Kind kind, int parent, int child, const Vec3& at, const Vec3& axis) {
  SceneJoint joint;
  joint.name = "joint " + std::to_string(child);
  joint.kind = kind;
  joint.parent = parent, joint.child = child;
  joint.pose.position = at;
  joint.axis = axis;
  return joint;
}

struct Jointed {
  SceneDescription scene;
  std::unique_ptr<World> world;
  double step = 1e-3;

  World& made() {
    if (!world) {
      WorldSettings settings;
      settings.voxel = 0.01;
      settings.common.threads = 1;
      world = std::make_unique<World>(scene, settings);
    }
    return *world;
  }
  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds / step); ++i) made().step(step);
  }
};

Jointed oneRod(Kind kind, const Vec3& at, const Vec3& axis, double mass = 2, double length = 1) {
  Jointed made;
  made.scene.bodies = {rod("rod", Vec3::Zero(), length, mass)};
  made.scene.joints = {jointOf(kind, -1, 0, at, axis)};
  return made;
}

// What falls by a thread turns: m g s = (I + m s^2) a, with s of the pitch over 2 pi.
TEST(SceneJoints, AScrewTurnsAsItSinks) {
  for (const double pitch : {0.4, -0.4, 2.0}) {
    Jointed j = oneRod(Kind::Screw, Vec3::Zero(), Vec3::UnitZ());
    j.scene.joints[0].pitch = pitch;
    j.run(2);
    const double s = pitch / (2 * kPi), inertia = 2.0 / 12;
    const double turning = -2 * kG * s / (inertia + 2 * s * s);  // [rad/s^2]
    const AxisState axis = j.made().axis(0, 0);
    EXPECT_NEAR(axis.speed, 2 * turning, 0.002 * std::abs(2 * turning)) << pitch;
    EXPECT_NEAR(axis.place, 2 * turning, 0.003 * std::abs(2 * turning)) << pitch;
    // More turns than one: the place goes on, and so does the thread.
    EXPECT_GT(std::abs(axis.place), 2 * kPi);
    EXPECT_NEAR(j.made().pose(0).position.z(), s * axis.place, 1e-3 * std::abs(s * axis.place));
  }
}

// A rod hung at its end, on a ball, circles at a constant slope where (I - I_axis) w^2 cos = m g l
// / 2.
TEST(SceneJoints, ABallLetsAPendulumCircle) {
  const double length = 1, slope = 0.7;
  const double about = 2.0 / 3 - 0.01 * 2 / 12;  // its end, less what it has about its axis
  const double w = std::sqrt(kG / (about * std::cos(slope)));
  Jointed j = oneRod(Kind::Ball, Vec3::Zero(), Vec3::UnitZ());
  SceneBody& body = j.scene.bodies[0];
  // Its end at the joint; it points outward and down.
  body.pose.orientation = Eigen::AngleAxisd(kPi / 2 - slope, Vec3::UnitY());
  body.pose.position = body.pose.orientation * Vec3(length / 2, 0, 0);
  body.angularVelocity = Vec3(0, 0, w);
  body.linearVelocity = body.angularVelocity.cross(body.pose.position);
  const double height = body.pose.position.z();
  double lowest = 0, highest = -1;
  for (int i = 0; i < 3000; ++i) {
    j.run(j.step);
    lowest = std::min(lowest, j.made().pose(0).position.z());
    highest = std::max(highest, j.made().pose(0).position.z());
  }
  EXPECT_GT(lowest, height - 0.003 * length);
  EXPECT_LT(highest, height + 0.003 * length);
}

// Two shafts at an angle b: the second turns by cos b / (1 - sin^2 b sin^2 a) of the first, with a
// from where the axis that the first holds is across the plane of both, as it is at the start.
TEST(SceneJoints, AUniversalJointTurnsAShaftAsCardanSays) {
  const double bend = 0.6;
  Jointed j;
  j.scene.gravity.setZero();
  const Vec3 first = Vec3::UnitX(), second(std::cos(bend), std::sin(bend), 0);
  j.scene.bodies = {rod("in", -first / 2, 1, 1), rod("out", second / 2, 1, 1)};
  j.scene.bodies[1].pose.orientation = Eigen::AngleAxisd(bend, Vec3::UnitZ());
  SceneJoint cross = jointOf(Kind::Universal, 0, 1, Vec3::Zero(), Vec3::UnitZ());
  cross.second.axis = Vec3::UnitZ().cross(second);
  j.scene.joints = {jointOf(Kind::Revolute, -1, 0, -first, first),
                    jointOf(Kind::Revolute, -1, 1, second, second), cross};
  j.made().setMotor(0, 0, {.velocity = 5, .damping = HUGE_VAL});
  double least = 10, most = 0;
  for (int i = 0; i < 3000; ++i) {
    j.run(1e-3);
    if (i < 10) continue;
    const double in = j.made().axis(0, 0).speed, out = j.made().axis(1, 0).speed;
    const double a = j.made().axis(0, 0).place;
    const double c = std::sin(a) * std::sin(bend), ratio = std::cos(bend) / (1 - c * c);
    EXPECT_NEAR(in, 5, 1e-3);
    ASSERT_NEAR(out / in, ratio, 0.01 * ratio) << a;
    least = std::min(least, out / in), most = std::max(most, out / in);
  }
  EXPECT_NEAR(least, std::cos(bend), 0.01);
  EXPECT_NEAR(most, 1 / std::cos(bend), 0.01);
  EXPECT_NEAR(j.made().axis(0, 0).place, 15, 0.05);
  EXPECT_NEAR(j.made().axis(1, 0).place, 15, 0.7);
}

struct Way {
  const char* name;
  Kind kind;
};
class DrivenJoint : public ::testing::TestWithParam<Way> {
 protected:
  // Along x: its weight does not push. `inert` of the mass or the inertia.
  DrivenJoint() { j_.scene.gravity.setZero(); }
  double inert() const { return GetParam().kind == Kind::Revolute ? 2.0 / 12 : 2; }
  AxisState state() { return j_.made().axis(0, 0); }
  Jointed j_ = oneRod(GetParam().kind, Vec3::Zero(), Vec3::UnitZ());
};

TEST_P(DrivenJoint, AForcePushes) {
  j_.made().setMotor(0, 0, {.force = 3 * inert()});
  j_.run(1);
  EXPECT_NEAR(state().speed, 3, 3e-3);
  EXPECT_NEAR(state().place, 1.5, 5e-3);
}

TEST_P(DrivenJoint, AServoGoesToItsPlaceAndASpeedIsHeld) {
  for (const double step : {1e-3, 1.0 / 60}) {
    j_.step = step;
    // Of any gain: here w h is up to 1,000.
    for (const double w : {20.0, 6e4}) {
      j_.made().setMotor(
          0, 0, {.position = 1.2, .stiffness = w * w * inert(), .damping = 2 * w * inert()});
      j_.run(1);
      EXPECT_NEAR(state().place, 1.2, 1e-3) << step << ' ' << w;
      EXPECT_NEAR(state().speed, 0, 1e-3);
    }
    j_.made().setMotor(0, 0, {.velocity = -4, .damping = HUGE_VAL});
    j_.run(1);
    EXPECT_NEAR(state().speed, -4, 1e-3);
    EXPECT_NEAR(state().place, 1.2 - 4, 0.08);
  }
}

TEST_P(DrivenJoint, NoMotorPushesHarderThanItsMost) {
  j_.made().setMotor(0, 0, {.velocity = 100, .damping = HUGE_VAL, .most = 2 * inert()});
  j_.run(0.5);
  EXPECT_NEAR(state().speed, 1, 2e-3);
  j_.world.reset();
  j_.scene.joints[0].effort = inert();
  j_.made().setMotor(0, 0, {.force = 3 * inert(), .most = 2 * inert()});
  j_.run(0.5);
  EXPECT_NEAR(state().speed, 0.5, 2e-3);
}

// At a third of a radian a step, both limits, and at rest at one of them under a push.
TEST_P(DrivenJoint, LimitsAreNotPassed) {
  j_.step = 1.0 / 60;
  j_.scene.joints[0].lower = -0.5, j_.scene.joints[0].upper = 0.7;
  for (const double push : {20.0, -20.0}) {
    const double end = push > 0 ? 0.7 : -0.5;
    j_.world.reset();
    j_.made().setMotor(0, 0, {.velocity = push, .damping = HUGE_VAL, .most = 1e3 * inert()});
    double beyond = 0;
    for (int i = 0; i < 120; ++i) {
      j_.run(1.0 / 60);
      beyond = std::max(beyond, std::abs(state().place) - std::abs(end));
    }
    EXPECT_LT(beyond, 1e-3);
    EXPECT_NEAR(state().place, end, 1e-3);
    EXPECT_NEAR(state().speed, 0, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, DrivenJoint,
                         ::testing::Values(Way{"turns", Kind::Revolute},
                                           Way{"slides", Kind::Prismatic}),
                         [](const auto& made) { return made.param.name; });

// Two arms held out by servos: the torques are those of the weights, and the wall carries both.
TEST(SceneJoints, ReactionsCarryTheWeights) {
  Jointed j;
  j.scene.bodies = {rod("upper", Vec3(0.5, 0, 0), 1, 2), rod("fore", Vec3(1.5, 0, 0), 1, 3)};
  j.scene.joints = {jointOf(Kind::Revolute, -1, 0, Vec3::Zero(), Vec3::UnitY()),
                    jointOf(Kind::Fixed, 0, 1, Vec3(1, 0, 0), Vec3::UnitZ())};
  j.made().setMotor(0, 0, {.stiffness = 1e7, .damping = 1e5});
  j.run(1);
  const JointState wall = j.made().joint(0), elbow = j.made().joint(1);
  EXPECT_LT((wall.force - Vec3(0, 0, 5 * kG)).norm(), 1e-3 * 5 * kG);
  EXPECT_LT((wall.torque - Vec3(0, -kG * (2 * 0.5 + 3 * 1.5), 0)).norm(), 0.06);
  EXPECT_LT((elbow.force - Vec3(0, 0, 3 * kG)).norm(), 1e-3 * 3 * kG);
  EXPECT_LT((elbow.torque - Vec3(0, -kG * 3 * 0.5, 0)).norm(), 0.02);
  EXPECT_LT((elbow.origin - Vec3(1, 0, 0)).norm(), 1e-4);
}

// Free bodies that a joint holds together keep their momenta, and gain no energy.
TEST(SceneJoints, NoKindMakesMomentumOrEnergy) {
  for (const Kind kind :
       {Kind::Fixed, Kind::Revolute, Kind::Prismatic, Kind::Screw, Kind::Ball, Kind::Universal}) {
    Jointed j;
    j.scene.gravity.setZero();
    j.scene.bodies = {rod("a", Vec3(-0.5, 0, 0), 1, 2), rod("b", Vec3(0.5, 0.1, 0), 1, 3)};
    SceneJoint joint = jointOf(kind, 0, 1, Vec3(0.1, 0.05, 0), Vec3(0, 1, 1).normalized());
    joint.second.axis = Vec3::UnitX();
    joint.pitch = 0.3;
    j.scene.joints = {joint};
    j.scene.bodies[0].angularVelocity = Vec3(0.3, 1, -0.5);
    j.scene.bodies[1].linearVelocity = Vec3(0.2, -0.1, 0.3);
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (std::size_t i = 0; i < 2; ++i) {
        const BodyState s = j.made().state(i);
        const Eigen::Matrix3d turn = s.pose.orientation.toRotationMatrix();
        sum += *j.scene.bodies[i].mass * s.pose.position.cross(s.linearVelocity) +
               turn * *j.scene.bodies[i].inertia * turn.transpose() * s.angularVelocity;
      }
      return sum;
    };
    j.run(1e-3);
    const Vec3 start = momentum();
    double kinetic = 0, most = 0;
    for (int i = 0; i < 2000; ++i) {
      j.run(1e-3);
      if (i == 0) kinetic = j.made().moment().energy.kinetic;
      most = std::max(most, j.made().moment().energy.kinetic);
    }
    EXPECT_LT((momentum() - start).norm(), 0.01 * start.norm()) << int(kind);
    EXPECT_LT(most, 1.005 * kinetic) << int(kind);
  }
}

// Turns and motors are of no pose: they come back with a state.
TEST(SceneJoints, AStateBringsTurnsAndMotorsBack) {
  Jointed j = oneRod(Kind::Screw, Vec3::Zero(), Vec3::UnitZ());
  j.scene.joints[0].pitch = 0.4;
  j.made().setMotor(0, 0, {.velocity = 9, .damping = 4});
  j.run(2);
  ASSERT_GT(std::abs(j.made().axis(0, 0).place), 2 * kPi);
  const WorldSave saved = j.made().save();
  j.run(1);
  const std::uint64_t went = j.made().hash();
  const double place = j.made().axis(0, 0).place;
  j.made().setMotor(0, 0, {});
  j.run(0.5);
  j.made().restore(saved);
  j.run(1);
  EXPECT_EQ(j.made().hash(), went);
  EXPECT_EQ(j.made().axis(0, 0).place, place);
}

TEST(SceneJoints, WhatIsNoneIsRefused) {
  Jointed j = oneRod(Kind::Screw, Vec3::Zero(), Vec3::UnitZ());
  EXPECT_THROW(j.made(), BadInput);  // of no pitch
  j.scene.joints[0] = jointOf(Kind::Universal, -1, 0, Vec3::Zero(), Vec3::UnitZ());
  j.scene.joints[0].second.axis = Vec3(0, 1, 1);
  EXPECT_THROW(j.made(), BadInput);
  j.scene.joints[0].second.axis = Vec3::UnitY();
  EXPECT_NO_THROW(j.made().setMotor(0, 1, {.force = 1}));
  EXPECT_THROW(j.made().setMotor(0, 2, {}), std::out_of_range);
  EXPECT_THROW(j.made().setMotor(1, 0, {}), std::out_of_range);
  EXPECT_THROW(j.made().setMotor(0, 0, {.stiffness = -1}), std::invalid_argument);
  EXPECT_THROW(j.made().setMotor(0, 0, {.position = NAN}), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::program::sim_joints_test
