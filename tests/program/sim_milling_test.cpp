// Milling by a scene file alone: a driven mill takes a groove out of a block that a spring holds.
// And the spring itself: a block on it swings as its formula says.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "scene/scene_file.h"
#include "scene/world.h"

namespace cloudcontact::program::sim_milling_test {
namespace {

constexpr double kStep = 1e-3, kSpring = 2e4;
constexpr double kRadius = 4e-3, kDeep = 5e-3;  // of the mill, and below the block's top [m]
constexpr double kLength = 0.04;                // of the block along x [m]

// In a file of this test's own, as tests run side by side.
std::filesystem::path file(const char* name, const std::string& text) {
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto path = std::filesystem::temp_directory_path() / (test + name);
  std::ofstream(path) << text;
  return path;
}

WorldSettings settings() {
  WorldSettings s;
  s.common.threads = 1;
  s.voxel = 1e-3;
  s.common.tissues.table =
      file(
          "cloudcontact_milling_wax.json",
          R"([{"name": "wax", "stiffness": 4e4, "damping": 40, "hardness": 5e6, "density": 2000}])")
          .string();
  return s;
}

// A block on a spring along x; `rest` models follow it.
SceneDescription scene(const std::string& state, const std::string& rest) {
  return loadScene(file("cloudcontact_milling.sdf", R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="milling"><gravity>0 0 0</gravity>
<physics name="p" type="bullet"><max_step_size>0.001</max_step_size><real_time_factor>0</real_time_factor></physics>
<model name="block">
  <link name="l"><collision name="c">
    <geometry><box><size>0.04 0.024 0.016</size></box></geometry>
    <cloudcontact:cuttable/>
    <cloudcontact:tissue>wax</cloudcontact:tissue>
  </collision></link>
  <joint name="hold" type="prismatic"><parent>world</parent><child>l</child>
    <axis><xyz>1 0 0</xyz><dynamics><spring_stiffness>20000</spring_stiffness>
      <spring_reference>0</spring_reference></dynamics></axis>
  </joint>
</model>)" + rest + state + "</world></sdf>"));
}

// Of the contacts on body `b`: force [N] in the last step.
Vec3 forceOn(const World& world, int body) {
  ContactsNow now;
  world.contacts(now);
  Vec3 sum = Vec3::Zero();
  for (const PatchNow& patch : now.patches)
    for (const ContactNow& point : now.of(patch))
      sum += (patch.b == body ? 1.0 : patch.a == body ? -1.0 : 0.0) * point.force;
  return sum;
}

TEST(Milling, TakesAGrooveByFileAlone) {
  World world(scene("", R"(
<model name="mill"><pose>-0.0248 0 0.023 0 0 0</pose><link name="l">
  <cloudcontact:drive><linear>0.03 0 0</linear><angular>0 0 300</angular></cloudcontact:drive>
  <collision name="c">
    <geometry><cylinder><radius>0.004</radius><length>0.04</length></cylinder></geometry>
    <cloudcontact:cutter efficiency="0.5"/>
  </collision></link></model>)"),
              settings());
  const double mass = world.mass(0);
  Vec3 given = Vec3::Zero();
  double exchanged = 0, most = 0, lost = 0, before = 0;
  while (world.pose(1).position.x() < 0) {
    const double speed = world.state(0).linearVelocity.x();
    world.step(kStep);
    const Vec3 force = forceOn(world, 0);
    const double pull = -kSpring * world.pose(0).position.x();
    given += kStep * (force + Vec3(pull, 0, 0));
    exchanged += kStep * (std::abs(force.x()) + std::abs(pull));
    most = std::max(most, force.norm());
    lost += (world.cutOf(0).mass - before) * speed;
    before = world.cutOf(0).mass;
  }
  const double length = world.pose(1).position.x() - world.pose(0).position.x() + kLength / 2;
  const double swept = kDeep * (2 * kRadius * length + std::numbers::pi / 2 * kRadius * kRadius);
  EXPECT_NEAR(world.cutOf(0).volume, swept, 0.02 * swept);
  EXPECT_NEAR(mass - world.mass(0), world.cutOf(0).mass, 1e-6 * mass);
  EXPECT_LT(most, 60);
  EXPECT_GT(most, 1);
  const double momentum = world.mass(0) * world.state(0).linearVelocity.x() + lost;
  EXPECT_NEAR(momentum, given.x(), 0.01 * exchanged);
}

TEST(Prismatic, SwingsOnItsSpring) {
  const std::string push =
      "<state world_name='milling'><model name='block'><link name='l'>"
      "<velocity>0.5 0 0 0 0 0</velocity></link></model></state>";
  World world(scene(push, ""), settings());
  const double omega = std::sqrt(kSpring / world.mass(0));
  // A step damps the swing a little, so the first zero is what tells the period.
  int n = 0;
  world.step(kStep / 4);
  for (n = 1; world.pose(0).position.x() > 0 && n < 4000; ++n) world.step(kStep / 4);
  EXPECT_NEAR(n * kStep / 4, std::numbers::pi / omega, 0.03 * std::numbers::pi / omega);
  EXPECT_LT(std::abs(world.pose(0).position.y()), 1e-6);
}

}  // namespace
}  // namespace cloudcontact::program::sim_milling_test
