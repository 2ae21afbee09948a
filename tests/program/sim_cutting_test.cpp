// Driven bodies and cutting in worlds: closed forms of their motion, the swept volume of a groove,
// pieces that fall, and sums that stay.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "io/errors.h"
#include "program/scene_bodies.h"
#include "scene/simulation.h"

namespace cloudcontact::program::sim_cutting_test {
namespace {

constexpr double kVoxelSize = 1e-3, kMilli = 1e-3;

// A table of one tissue, soft enough that a mill clears all that it meets. A file for each test, as
// tests run side by side.
std::string waxFile() {
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto file = std::filesystem::temp_directory_path() / (test + "_wax.json");
  std::ofstream(file) << R"([{"name": "wax", "stiffness": 4e4, "damping": 40, "hardness": 5e6,
                             "density": 2000}])";
  return file.string();
}

WorldSettings cloudSettings(double voxel = kVoxelSize) {
  WorldSettings settings;
  settings.common.threads = 1;
  settings.voxel = voxel;
  return settings;
}

WorldSettings waxSettings() {
  WorldSettings settings = cloudSettings();
  settings.common.tissues.table = waxFile();
  return settings;
}

SceneDescription sceneWith(std::vector<SceneBody> bodies, const Vec3& gravity = Vec3::Zero()) {
  SceneDescription scene;
  scene.gravity = gravity;
  scene.bodies = std::move(bodies);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) scene.bodies[i].model = int(i);
  return scene;
}

SceneBody cuttable(const std::string& name, const Vec3& edges, const Vec3& position,
                   bool isStatic) {
  SceneBody body = bodyWith(name, SceneBox{edges}, position, isStatic ? 0 : 1);
  body.mass.reset();
  body.collisions[0].isCuttable = true;
  body.collisions[0].tissues = {{"", "wax"}};
  return body;
}

SceneBody driven(SceneBody body, const Vec3& linear, const Vec3& angular = Vec3::Zero()) {
  body.isStatic = false;
  body.drive = SceneDrive{Pose(), linear, angular};
  return body;
}

// About a frame away from its origin, through thousands of steps.
TEST(DrivenBody, MovesExactly) {
  SceneBody body = driven(bodyWith("arm", SceneBox{Vec3(1, 1, 1)}, Vec3(2, 0, 0), 0),
                          Vec3(0.1, 0, 0.2), Vec3(0, 0, 3));
  body.drive->place.position = Vec3(1, 0, 0);
  World world(sceneWith({body}), cloudSettings(0.1));
  const double step = 1.0 / 1024;
  for (int n = 0; n < 2048; ++n) world.step(step);
  const double angle = 3 * 2.0;
  const Vec3 frame = Vec3(3, 0, 0) + 2 * Vec3(0.1, 0, 0.2);
  const Vec3 truth = frame - Vec3(std::cos(angle), std::sin(angle), 0);
  EXPECT_LT((world.pose(0).position - truth).norm(), 1e-6);
  const Vec3 velocity = Vec3(0.1, 0, 0.2) - Vec3(0, 0, 3).cross(truth - frame) * -1;
  EXPECT_LT((world.state(0).linearVelocity - velocity).norm(), 1e-5);
  EXPECT_EQ(world.mass(0), 0);
  EXPECT_FALSE(world.isStatic(0));
}

// A box on a belt: friction accelerates it by mu g until it has the belt's speed.
TEST(DrivenBody, CarriesByFriction) {
  SceneBody belt =
      driven(bodyWith("belt", SceneBox{Vec3(2, 0.4, 0.1)}, Vec3(0, 0, -0.05), 0), Vec3(0.5, 0, 0));
  SceneBody box = bodyWith("box", SceneBox{Vec3(0.1, 0.1, 0.05)}, Vec3(0, 0, 0.025), 1);
  belt.friction = box.friction = 0.2;
  World world(sceneWith({belt, box}, Vec3(0, 0, -kGravity)), cloudSettings(0.005));
  const double step = 1e-3, arrival = 0.5 / (0.2 * kGravity);
  int n = 0;
  for (; n * step < 0.6 * arrival; ++n) world.step(step);
  EXPECT_NEAR(world.state(1).linearVelocity.x(), 0.2 * kGravity * n * step, 0.02);
  for (; n * step < 1.4 * arrival; ++n) world.step(step);
  EXPECT_NEAR(world.state(1).linearVelocity.x(), 0.5, 0.005);
  EXPECT_NEAR(world.pose(0).position.x(), 0.5 * n * step, 1e-6);
}

// A spinning bar in free flight, cut through its middle: the halves fly on with the velocities that
// their matter had, and the energy that is missing left with the slice.
TEST(CuttableScene, PiecesFlyOnWithTheirMotion) {
  SceneBody bar = cuttable("bar", Vec3(60, 10, 10) * kMilli, Vec3(0, 0, 1), false);
  bar.angularVelocity = Vec3(0, 0, 5);
  bar.linearVelocity = Vec3(0, 0.2, 0);
  World world(sceneWith({bar}, Vec3(0, 0, -1)), waxSettings());
  world.findContacts();
  const double before = world.moment().energy.ofBodies(), mass = world.mass(0);
  world.cut(0, slice(world.matter(0), -3 * kMilli, 5 * kMilli));
  ASSERT_EQ(world.bodyCount(), 2u);
  EXPECT_EQ(world.name(1), "bar piece 1");
  EXPECT_EQ(world.cutOf(0).pieces, 1);
  const double density = mass / (60 * 100 * 1e-9);
  EXPECT_NEAR(world.cutOf(0).volume, 8 * 100 * 1e-9, 1e-12);
  EXPECT_NEAR(world.cutOf(0).mass, density * 8 * 100 * 1e-9, 1e-6 * mass);
  EXPECT_NEAR(world.mass(0) + world.mass(1) + world.cutOf(0).mass, mass, 1e-6 * mass);
  EXPECT_NEAR(world.mass(0), density * 27 * 100 * 1e-9, 1e-6 * mass);
  // Both have the bar's frame, in its place.
  EXPECT_LT((world.pose(1).position - Vec3(0, 0, 1)).norm(), 1e-7);
  EXPECT_LT((world.state(1).linearVelocity - Vec3(0, 0.2, 0)).norm(), 1e-6);
  world.findContacts();
  const Energy& now = world.moment().energy;
  EXPECT_NEAR(now.ofBodies() + now.cutAway, before, 1e-6 * before);
  EXPECT_GT(now.cutAway, 0.1 * before);
  EXPECT_LT(now.cutAway, 0.15 * before);  // 8/60 of the height
  // The piece's center of mass flies straight: the frame's origin turns about it.
  for (int n = 0; n < 240; ++n) world.step(kStep);
  const double fall = -kStep * kStep * 240 * 241 / 2;
  for (const int i : {0, 1}) {
    const double x0 =
        world.mass(i) > 0.5 * (mass - world.cutOf(0).mass) ? -16.5 * kMilli : 17.5 * kMilli;
    const Vec3 straight(x0, 0.2 + 5 * x0, 1 + fall);
    EXPECT_LT((world.pose(i).toWorld(Vec3(x0, 0, 0)) - straight).norm(), 2e-5) << i;
  }
}

TEST(CuttableScene, ABodyOfWhichNothingIsLeftIsGone) {
  World world(sceneWith({cuttable("bar", Vec3(20, 10, 10) * kMilli, Vec3::Zero(), false)}),
              waxSettings());
  world.cut(0, slice(world.matter(0), -1, 1));
  EXPECT_TRUE(world.cutOf(0).gone);
  EXPECT_NEAR(world.cutOf(0).volume, 2e-6, 1e-12);
  world.step(kStep);
  EXPECT_EQ(world.moment().energy.ofBodies(), 0);
  EXPECT_EQ(world.mass(0), 0);
}

// A hinge keeps its place in the world when the cut moves the body's center of mass.
TEST(CuttableScene, JointsFollowTheMatter) {
  SceneBody bar = cuttable("bar", Vec3(40, 10, 10) * kMilli, Vec3::Zero(), false);
  SceneDescription scene = sceneWith({bar}, Vec3(0, 0, -kGravity));
  SceneJoint hinge;
  hinge.kind = SceneJoint::Kind::Revolute;
  hinge.child = 0;
  hinge.axis = Vec3::UnitY();
  hinge.pose.position = Vec3(-20, 0, 0) * kMilli;
  scene.joints = {hinge};
  World world(scene, waxSettings());
  world.cut(0, slice(world.matter(0), 5 * kMilli, 1));
  for (int n = 0; n < 200; ++n) world.step(1e-3);
  EXPECT_LT((world.pose(0).toWorld(Vec3(-20, 0, 0) * kMilli) - hinge.pose.position).norm(), 2e-5);
  EXPECT_GT(Eigen::AngleAxisd(world.pose(0).orientation).angle(), 0.3);
}

SceneBody mill(double radius, const Vec3& position) {
  SceneBody body = driven(bodyWith("mill", SceneCylinder{radius, 0.04}, position, 0),
                          Vec3(0.06, 0, 0), Vec3(0, 0, 300));
  SceneCutter cutter;
  cutter.cutter.efficiency = 0.5;
  body.collisions[0].cutter = cutter;
  return body;
}

// A driven mill takes a groove out of a block that is held: the volume is what it swept.
TEST(CuttableScene, ADrivenToolCutsWhatIsHeld) {
  const Vec3 edges = Vec3(24, 16, 10) * kMilli;
  const double radius = 3 * kMilli, deep = 4 * kMilli;
  const SceneBody block = cuttable("block", edges, Vec3(0, 0, 0), true);
  const Vec3 start(-0.5 * edges.x() - 1.1 * radius, 0, 0.5 * edges.z() - deep + 0.02);
  World world(sceneWith({block, mill(radius, start)}, Vec3(0, 0, -kGravity)), waxSettings());
  const double step = 1e-3;
  double x = start.x();
  for (; x < 0; x += 0.06 * step) world.step(step);
  const double length = x + 0.5 * edges.x();
  const double swept = deep * (2 * radius * length + M_PI / 2 * radius * radius);
  // Within a fraction of a voxel of its walls and floor.
  const double area = length * (2 * deep + 2 * radius);
  EXPECT_NEAR(world.cutOf(0).volume, swept, 0.15 * kVoxelSize * area);
  EXPECT_EQ(world.cutOf(0).pieces, 0);
  EXPECT_LT((world.pose(0).position).norm(), 1e-7);
  EXPECT_LT((world.pose(1).position - Vec3(x, 0, start.z())).norm(), 1e-5);
}

// Cuts are the same on every run.
TEST(CuttableScene, RunsRepeat) {
  const SceneBody block = cuttable("block", Vec3(12, 8, 6) * kMilli, Vec3(0, 0, 0), true);
  const auto scene = sceneWith({block, mill(2 * kMilli, Vec3(-7 * kMilli, 0, 0.02))});
  World one(scene, waxSettings()), two(scene, waxSettings());
  for (int n = 0; n < 60; ++n) one.step(1e-3), two.step(1e-3);
  EXPECT_GT(one.cutOf(0).volume, 0);
  EXPECT_EQ(one.cutOf(0).volume, two.cutOf(0).volume);
  EXPECT_EQ(one.hash(), two.hash());
}

TEST(CuttableScene, NeedsATissue) {
  SceneBody bare = cuttable("b", Vec3(8, 8, 8) * kMilli, Vec3::Zero(), false);
  bare.collisions[0].tissues.clear();
  EXPECT_THROW(World(sceneWith({bare}), cloudSettings()), BadInput);
}

}  // namespace
}  // namespace cloudcontact::program::sim_cutting_test
