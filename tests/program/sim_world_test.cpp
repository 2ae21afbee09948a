// Worlds and runs against mechanics: free fall, sliding, spinning, pendulums, sag, and reproducible
// runs.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "io/errors.h"
#include "program/scene_bodies.h"
#include "scene/scene_clouds.h"
#include "scene/scene_dispatcher.h"
#include "scene/scene_shapes.h"
#include "scene/simulation.h"

namespace cloudcontact::program::sim_world_test {
namespace {

SceneDescription sceneOf(std::vector<SceneBody> bodies) {
  SceneDescription scene;
  scene.bodies = std::move(bodies);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) scene.bodies[i].model = int(i);
  return scene;
}

WorldSettings with(Method method, double voxel) {
  WorldSettings settings;
  settings.common.method = method;
  settings.common.threads = 1;
  settings.voxel = voxel;
  return settings;
}

SimulationReport run(const SceneDescription& scene, const WorldSettings& settings, double seconds,
                     double step = kStep, int substeps = 1) {
  World world(scene, settings);
  SimulationSettings run;
  run.seconds = seconds;
  run.step = step;
  run.substeps = substeps;
  run.instants = 5;
  return simulate(world, run);
}

const SceneBox kBrick{Vec3(0.1, 0.2, 0.3)};

TEST(SceneShapesTest, MassAloneTakesItsInertiaFromTheGeometry) {
  SceneShapes shapes({}, 0.01);
  const BodyParts parts = shapes.make(bodyWith("b", kBrick, Vec3::Zero(), 6));
  const Vec3 truth = 6.0 / 12 * Vec3(0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04);
  EXPECT_DOUBLE_EQ(parts.mass, 6);
  EXPECT_LT((parts.inertia - truth).cwiseAbs().maxCoeff(), 2e-3 * truth.maxCoeff());
  EXPECT_LT(parts.frame.position.norm(), 1e-4);
}

TEST(SceneShapesTest, NoMassAtAllIsWater) {
  SceneShapes shapes({}, 0.01);
  SceneBody body = bodyWith("b", kBrick, Vec3::Zero(), 1);
  body.mass.reset();
  EXPECT_NEAR(shapes.make(body).mass, 1000 * 0.006, 6e-3);
}

// Two equal balls 2a apart: a point mass pair about its middle, and each ball's own 2/5 m r^2.
TEST(SceneShapesTest, CompoundsAddUpByTheParallelAxes) {
  const double r = 0.1, a = 0.3, mass = 2;
  SceneBody body = bodyWith("b", SceneSphere{r}, Vec3::Zero(), mass);
  body.collisions[0].pose.position = Vec3(1 + a, 0, 0);
  body.collisions.push_back({"d", Pose(), SceneSphere{r}});
  body.collisions[1].pose.position = Vec3(1 - a, 0, 0);
  SceneShapes shapes({}, 0.01);
  const BodyParts parts = shapes.make(body);
  const double own = 0.4 * mass * r * r;
  EXPECT_TRUE(parts.frame.position.isApprox(Vec3(1, 0, 0), 1e-4));
  EXPECT_NEAR(parts.inertia.x(), own, 2e-3 * own);
  EXPECT_NEAR(parts.inertia.y(), own + mass * a * a, 2e-3 * mass * a * a);
}

// For a given inertia that is not diagonal, Bullet's frame has its principal axes.
TEST(SceneShapesTest, FramesTurnIntoThePrincipalAxes) {
  SceneBody body = bodyWith("b", kBrick, Vec3::Zero(), 6);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).matrix();
  const Vec3 principal(0.04, 0.05, 0.07);
  body.inertia = turn * principal.asDiagonal() * turn.transpose();
  body.inertialPose = Pose{Eigen::Quaterniond::Identity(), Vec3(0.01, 0, 0)};
  SceneShapes shapes({}, 0.01);
  const BodyParts parts = shapes.make(body);
  const Eigen::Matrix3d r = parts.frame.orientation.toRotationMatrix();
  EXPECT_TRUE((r * parts.inertia.asDiagonal() * r.transpose()).isApprox(*body.inertia, 1e-9));
  EXPECT_TRUE(r.isApprox(turn, 1e-9));  // each axis stays the nearest to its own
  EXPECT_EQ(parts.frame.position, Vec3(0.01, 0, 0));
}

TEST(SurfaceRule, APairsFrictionIsTheSmaller) {
  SurfaceSettings settings;
  settings.bodies = {{0.2, {}}, {0.7, {}}, {{}, {}}, {{}, {}}};
  EXPECT_EQ(pairFriction(settings, 0, 1), 0.2);
  EXPECT_EQ(pairFriction(settings, 1, 0), 0.2);
  EXPECT_EQ(pairFriction(settings, 1, 1), 0.7);
  EXPECT_EQ(pairFriction(settings, 2, 1), 0.7);
  EXPECT_EQ(pairFriction(settings, 2, 3), 0);
  settings.friction = 0.4;
  EXPECT_EQ(pairFriction(settings, 2, 3), 0.4);
}

// Symplectic Euler: after n steps z = z0 - g h^2 n (n + 1) / 2.
TEST(Simulation, ABodyFallsFreely) {
  const auto scene = sceneOf({bodyWith("ball", SceneSphere{0.1}, Vec3(0, 0, 100), 2)});
  const auto report = run(scene, with(Method::Primitive, 0.02), 1);
  ASSERT_EQ(report.steps, 240);
  EXPECT_NEAR(report.bodies[0].pose.position.z(), 100 - kGravity * kStep * kStep * 240 * 241 / 2,
              1e-3);
  EXPECT_NEAR(report.bodies[0].linearVelocity.z(), -kGravity, 1e-4);
  EXPECT_NEAR(report.energyStart.ofBodies(), 2 * kGravity * 100, 1e-2);
  EXPECT_EQ(report.energyStart.kinetic, 0);
  EXPECT_NEAR(report.energyEnd.kinetic, 0.5 * 2 * kGravity * kGravity, 1e-2);
  EXPECT_EQ(report.maxPenetration, 0);
  EXPECT_EQ(report.contactsPerStep, 0);
}

TEST(Simulation, SubstepsAreStepsThatCount) {
  const auto scene = sceneOf({bodyWith("ball", SceneSphere{0.1}, Vec3(0, 0, 100), 2)});
  const auto report = run(scene, with(Method::Primitive, 0.02), 1, 0.01, 4);
  EXPECT_EQ(report.steps, 100);
  const double h = 0.0025;
  EXPECT_NEAR(report.bodies[0].pose.position.z(), 100 - kGravity * h * h * 400 * 401 / 2, 1e-3);
}

// A spin about a principal axis that differs from the geometry's is steady only in the right frame.
TEST(Simulation, TurnsAreUnwrappedAboutTheWorldsAxes) {
  SceneBody body = bodyWith("brick", kBrick, Vec3::Zero(), 6);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).matrix();
  body.inertia = turn * Vec3(0.04, 0.05, 0.07).asDiagonal() * turn.transpose();
  body.inertialPose = Pose{Eigen::Quaterniond::Identity(), Vec3(0.05, 0, 0)};
  body.angularVelocity = 9 * turn.col(2);
  SceneDescription scene = sceneOf({body});
  scene.gravity = Vec3::Zero();
  const auto report = run(scene, with(Method::Primitive, 0.02), 2);
  EXPECT_LT((report.turns[0] - 18 * turn.col(2)).norm(), 0.02);
  EXPECT_LT((report.bodies[0].angularVelocity - body.angularVelocity).norm(), 0.01);
  // The center of mass keeps its initial velocity; the frame's origin started at rest.
  const double flying = 0.5 * 6 * body.angularVelocity.cross(Vec3(0.05, 0, 0)).squaredNorm();
  EXPECT_NEAR(report.energyEnd.kinetic, 0.5 * 0.07 * 81 + flying, 3e-3);
}

// The frame's origin starts at rest, but the center of mass does not and keeps moving.
TEST(Simulation, VelocitiesAreTheFramesOrigins) {
  SceneBody body = bodyWith("ball", SceneSphere{0.1}, Vec3::Zero(), 1);
  body.collisions[0].pose.position = Vec3(1, 0, 0);
  body.angularVelocity = Vec3(0, 0, 2);
  SceneDescription scene = sceneOf({body});
  scene.gravity = Vec3::Zero();
  World world(scene, with(Method::Primitive, 0.02));
  EXPECT_LT(world.state(0).linearVelocity.norm(), 1e-4);
  SimulationSettings settings;
  settings.step = kStep;
  const auto report = simulate(world, settings);
  const Vec3 center = report.bodies[0].pose.toWorld(Vec3(1, 0, 0));
  EXPECT_LT((center - Vec3(1, 2, 0)).norm(), 1e-3);
}

// mu 0.3 against 1.0 is 0.3: a brick on a slope of 0.5 slides at g (sin - mu cos).
TEST(Simulation, TheSmallerFrictionSlides) {
  SceneBody floor = bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0);
  floor.friction = 1.0;
  SceneBody brick = bodyWith("brick", SceneBox{Vec3(0.4, 0.4, 0.1)}, Vec3(0, 0, 0.05), 1);
  brick.friction = 0.3;
  SceneDescription scene = sceneOf({floor, brick});
  const double slope = std::atan(0.5);
  scene.gravity = kGravity * Vec3(std::sin(slope), 0, -std::cos(slope));
  const double truth = kGravity * (std::sin(slope) - 0.3 * std::cos(slope));
  const auto report = run(scene, with(Method::Cloud, 0.02), 1);
  EXPECT_NEAR(report.bodies[1].linearVelocity.x(), truth, 0.02 * truth);
  // Bullet's own boxes have 5 % more friction; with 0.65, the mean, or 1 the brick would not slide.
  const auto bullet = run(scene, with(Method::Primitive, 0.02), 1);
  EXPECT_NEAR(bullet.bodies[1].linearVelocity.x(), truth, 0.08 * truth);
}

// The pair's spring carries the weight for every method; equal bodies act in series.
TEST(Simulation, AStatedStiffnessSagsByTheWeight) {
  SceneBody floor = bodyWith("floor", SceneBox{Vec3(1, 1, 0.2)}, Vec3(0, 0, -0.1), 0);
  SceneBody brick = bodyWith("brick", SceneBox{Vec3(0.2, 0.2, 0.2)}, Vec3(0, 0, 0.1), 1);
  for (SceneBody* body : {&floor, &brick}) {
    body->stiffness = 2e4;
    body->damping = 400;
    body->friction = 0.5;
  }
  const double sag = kGravity / 1e4;
  for (const Method method : {Method::Cloud, Method::Primitive, Method::Gjk}) {
    const auto report = run(sceneOf({floor, brick}), with(method, 0.02), 2);
    EXPECT_NEAR(0.1 - report.bodies[1].pose.position.z(), sag, 0.02 * sag) << nameOf(method);
    EXPECT_NEAR(report.maxPenetration, sag, 0.1 * sag) << nameOf(method);
    EXPECT_NEAR(report.energyEnd.spring, 0.5 * 1e4 * sag * sag, 0.1 * 0.5 * 1e4 * sag * sag);
    EXPECT_EQ(report.pairs, 1);
  }
}

// In the end the solid's spring alone carries the load; Maxwell's dashpot lets it sink at load / c.
TEST(Simulation, LawsOfTheCommandLineCarryTheLoad) {
  const auto scene =
      sceneOf({bodyWith("floor", SceneBox{Vec3(1, 1, 0.2)}, Vec3(0, 0, -0.1), 0),
               bodyWith("brick", SceneBox{Vec3(0.2, 0.2, 0.2)}, Vec3(0, 0, 0.1), 1)});
  auto settings = with(Method::Cloud, 0.02);
  settings.common.law = StandardLinearSolid{500, 1000, 100};
  const double depth = 0.1 - run(scene, settings, 3).bodies[1].pose.position.z();
  EXPECT_NEAR(depth, kGravity / 500, 0.02 * kGravity / 500);
  settings.common.law = Maxwell{2000, 1000};
  const double one = run(scene, settings, 1).bodies[1].pose.position.z();
  const double two = run(scene, settings, 2).bodies[1].pose.position.z();
  EXPECT_NEAR(one - two, kGravity / 1000, 0.02 * kGravity / 1000);
}

TEST(Simulation, EqualRunsHaveEqualHashes) {
  SceneBody floor = bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0);
  SceneBody brick = bodyWith("brick", kBrick, Vec3(0, 0, 0.3), 1);
  brick.pose.orientation = Eigen::AngleAxisd(0.5, Vec3(1, 2, 0).normalized());
  const auto scene = sceneOf({floor, brick, bodyWith("b", SceneSphere{0.1}, Vec3(0, 0, 0.7), 1)});
  const auto settings = with(Method::Cloud, 0.02);
  const auto first = run(scene, settings, 0.5), second = run(scene, settings, 0.5);
  EXPECT_EQ(first.hash, second.hash);
  EXPECT_EQ(first.maxPenetration, second.maxPenetration);
  EXPECT_NE(first.hash, run(scene, settings, 0.5, 1.0 / 239).hash);
}

TEST(Simulation, ADroppedBodyGainsNoEnergy) {
  SceneBody floor = bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0);
  SceneBody brick = bodyWith("brick", SceneBox{Vec3(0.2, 0.2, 0.2)}, Vec3(0, 0, 0.4), 1);
  brick.pose.orientation = Eigen::AngleAxisd(0.7, Vec3(1, 2, 0).normalized());
  brick.stiffness = 1e4;
  brick.friction = floor.friction = 0.5;
  const auto report = run(sceneOf({floor, brick}), with(Method::Cloud, 0.02), 2);
  EXPECT_LT(report.energyMax, 1.001 * report.energyStart.ofBodies());
  EXPECT_GT(report.contactsPerStep, 0);
}

// A rod hung at its end swings down to w^2 = 3 g / l.
TEST(Simulation, ARevoluteJointIsAPendulumsPivot) {
  const double length = 1;
  SceneBody rod = bodyWith("rod", SceneBox{Vec3(length, 0.02, 0.02)}, Vec3(length / 2, 0, 0), 1);
  SceneDescription scene = sceneOf({rod});
  SceneJoint hinge;
  hinge.name = "hinge";
  hinge.kind = SceneJoint::Kind::Revolute;
  hinge.child = 0;
  hinge.axis = Vec3::UnitY();
  scene.joints = {hinge};
  World world(scene, with(Method::Primitive, 0.005));
  double fastest = 0, strayed = 0;
  SimulationSettings settings;
  settings.step = 1e-3;
  settings.observe = [&](double, const World& now) {
    fastest = std::max(fastest, std::abs(now.state(0).angularVelocity.y()));
    strayed = std::max(strayed, now.state(0).pose.toWorld(Vec3(-length / 2, 0, 0)).norm());
  };
  simulate(world, settings);
  EXPECT_NEAR(fastest, std::sqrt(3 * kGravity / length), 0.02 * std::sqrt(3 * kGravity / length));
  EXPECT_LT(strayed, 2e-3);
}

// A rod that turns about its middle, without gravity; or slides along its length.
struct JointedRod {
  static constexpr double kLength = 1, kMass = 2;
  SceneDescription scene =
      sceneOf({bodyWith("rod", SceneBox{Vec3(kLength, 0.02, 0.02)}, Vec3::Zero(), kMass)});
  explicit JointedRod(SceneJoint::Kind kind) {
    scene.gravity.setZero();
    SceneJoint joint;
    joint.name = "joint";
    joint.kind = kind;
    joint.child = 0;
    joint.axis = kind == SceneJoint::Kind::Revolute ? Vec3::UnitZ() : Vec3::UnitX();
    scene.joints = {joint};
  }
  SceneJoint& joint() { return scene.joints[0]; }
  bool turns() const { return scene.joints[0].kind == SceneJoint::Kind::Revolute; }
  // Of the inertia and the mass.
  double inert() const { return turns() ? kMass * (kLength * kLength + 0.02 * 0.02) / 12 : kMass; }
  void start(double speed) {
    (turns() ? scene.bodies[0].angularVelocity.z() : scene.bodies[0].linearVelocity.x()) = speed;
  }
  // The speed and the place on the joint's axis after a time.
  std::pair<double, double> after(double seconds, double step = 1e-3) const {
    World world(scene, with(Method::Primitive, 0.005));
    SimulationSettings settings;
    settings.step = step;
    settings.seconds = seconds;
    simulate(world, settings);
    const BodyState s = world.state(0);
    const Vec3 along = s.pose.orientation * Vec3::UnitX();
    return turns() ? std::pair(s.angularVelocity.z(), std::atan2(along.y(), along.x()))
                   : std::pair(s.linearVelocity.x(), s.pose.position.x());
  }
};

class JointDynamics : public ::testing::TestWithParam<SceneJoint::Kind> {};

TEST_P(JointDynamics, DampingSlowsDownExponentially) {
  JointedRod rod(GetParam());
  rod.start(3);
  rod.joint().damping = 0.5 * rod.inert();
  EXPECT_NEAR(rod.after(1).first, 3 * std::exp(-0.5), 3e-3);
  // More than stops it within a step: it stops, and does not turn back.
  rod.joint().damping = 1e5 * rod.inert();
  EXPECT_NEAR(rod.after(0.1).first, 0, 1e-3);
}

TEST_P(JointDynamics, ASpringSwingsAboutItsRest) {
  JointedRod rod(GetParam());
  const double period = 0.5, w = 2 * std::numbers::pi / period;
  rod.joint().spring = w * w * rod.inert();
  rod.joint().rest = 0.2;
  // From 0 to 0.4 in half a period, and back.
  EXPECT_NEAR(rod.after(period / 2).second, 0.4, 0.01);
  EXPECT_NEAR(rod.after(period).second, 0, 0.01);
}

TEST_P(JointDynamics, FrictionStopsItAndHoldsIt) {
  JointedRod rod(GetParam());
  rod.start(1);
  rod.joint().friction = 2 * rod.inert();
  EXPECT_NEAR(rod.after(0.25).first, 0.5, 5e-3);
  EXPECT_NEAR(rod.after(1).first, 0, 1e-4);
  EXPECT_NEAR(rod.after(1).second, 0.25, 5e-3);  // v^2 / (2 a)
}

TEST_P(JointDynamics, OneLimitAloneHolds) {
  for (const double damping : {0.0, 1e-6}) {
    JointedRod rod(GetParam());
    rod.start(1);
    rod.joint().damping = damping;
    rod.joint().upper = 0.3;
    EXPECT_LT(rod.after(1).second, 0.31) << damping;
    rod.joint().upper.reset();
    rod.joint().lower = -0.3;
    EXPECT_NEAR(rod.after(0.5).second, 0.5, 0.01) << damping;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, JointDynamics,
                         ::testing::Values(SceneJoint::Kind::Revolute, SceneJoint::Kind::Prismatic),
                         [](const auto& made) {
                           return made.param == SceneJoint::Kind::Revolute ? "revolute"
                                                                           : "prismatic";
                         });

TEST(Simulation, AFixedJointHoldsBodiesTogether) {
  SceneDescription scene = sceneOf({bodyWith("a", SceneSphere{0.1}, Vec3(0, 0, 5), 1),
                                    bodyWith("b", SceneSphere{0.1}, Vec3(1, 0, 5), 1)});
  scene.bodies[1].linearVelocity = Vec3(0, 2, 0);
  SceneJoint weld;
  weld.name = "weld";
  weld.parent = 0;
  weld.child = 1;
  scene.joints = {weld};
  const auto report = run(scene, with(Method::Primitive, 0.02), 1);
  const Vec3 apart = report.bodies[1].pose.position - report.bodies[0].pose.position;
  EXPECT_NEAR(apart.norm(), 1, 5e-3);
  // The pair's momentum is 2 kg m/s along y: its middle moves at half the speed.
  const Vec3 middle = (report.bodies[1].pose.position + report.bodies[0].pose.position) / 2;
  EXPECT_NEAR(middle.y(), 1, 5e-3);
}

TEST(Simulation, LinksOfOneModelTouchOnlyWithSelfCollide) {
  auto a = bodyWith("a", SceneSphere{0.5}, Vec3(0, 0, 5), 1);
  auto b = bodyWith("b", SceneSphere{0.5}, Vec3(0.9, 0, 5), 1);
  SceneDescription scene = sceneOf({a, b});
  scene.gravity = Vec3::Zero();
  scene.bodies[1].model = scene.bodies[0].model;
  const auto apart = run(scene, with(Method::Primitive, 0.05), 0.5);
  EXPECT_EQ(apart.bodies[1].pose.position.x(), scene.bodies[1].pose.position.cast<float>().x());
  EXPECT_EQ(apart.maxPenetration, 0);
  scene.bodies[0].selfCollide = scene.bodies[1].selfCollide = true;
  const auto pushed = run(scene, with(Method::Primitive, 0.05), 0.5);
  EXPECT_GT(pushed.bodies[1].pose.position.x() - pushed.bodies[0].pose.position.x(), 0.95);
}

// A long bar beside fine voxels: 10 million of them would be its own.
TEST(Simulation, ALargePrimitiveNeedsNoFineVoxels) {
  const SceneBox bar{Vec3(0.5, 0.1, 0.1)};
  SceneDescription scene =
      sceneOf({bodyWith("floor", SceneBox{Vec3(2, 2, 0.2)}, Vec3(0, 0, -0.1), 0),
               bodyWith("bar", bar, Vec3(0, 0, 0.051), 2)});
  WorldSettings settings = with(Method::Cloud, 1e-4);
  settings.common.friction = 0.5;
  const auto report = run(scene, settings, 0.5);
  EXPECT_NEAR(report.bodies[1].pose.position.z(), 0.05, 2e-5);
  EXPECT_LT(report.bodies[1].linearVelocity.norm(), 1e-4);
  SceneClouds clouds(settings.common, 2e-3, nullptr, traitsOf(scene));
  EXPECT_DOUBLE_EQ(clouds.cloud(bar, Pose(), "bar").cloud.voxelSize(), 0.5 / 128);
  // Who asks for its voxels gets those.
  scene.bodies[1].collisions[0].tolerance = 0;
  SceneClouds asked(settings.common, 2e-3, nullptr, traitsOf(scene));
  EXPECT_DOUBLE_EQ(asked.cloud(bar, Pose(), "bar").cloud.voxelSize(), 2e-3);
}

TEST(WorldOptions, InvalidValuesAreRefusedByName) {
  auto scene = sceneOf({bodyWith("ball", SceneSphere{0.1}, Vec3::Zero(), 1)});
  const auto message = [&](const WorldSettings& settings) {
    try {
      World world(scene, settings);
    } catch (const BadInput& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(message(with(Method::Sdf, 0.01)).find("--method sdf"), std::string::npos);
  auto damped = with(Method::Cloud, 0.01);
  damped.common.damping = 3;
  EXPECT_NE(message(damped).find("--damping"), std::string::npos);
  auto foundation = with(Method::Gjk, 0.01);
  foundation.common.law = Foundation{};
  EXPECT_NE(message(foundation).find("--law foundation"), std::string::npos);
  EXPECT_EQ(message(with(Method::Cloud, 0.01)), "accepted");
  scene.bodies[0].collisions[0].tolerance = 0;  // its voxels
  EXPECT_NE(message(with(Method::Cloud, 1e-7)).find("body 'ball'"), std::string::npos);
}

}  // namespace
}  // namespace cloudcontact::program::sim_world_test
