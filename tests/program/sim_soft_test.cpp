// Soft tissue by scene files: a bar that hangs stretches as its closed form says, a ball rests on a
// pad, a blade slits it, runs are the same on any number of threads; and what a scene cannot have.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "io/errors.h"
#include "scene/scene_file.h"
#include "scene/world.h"

namespace cloudcontact::program::sim_soft_test {
namespace {

const std::filesystem::path kFolder =
    std::filesystem::path(CLOUDCONTACT_SOURCE_DIR) / "tests/program";

WorldSettings settings(int threads = 1) {
  WorldSettings s;
  s.common.threads = threads;
  s.voxel = 1e-3;
  s.common.tissues.table = (kFolder / "soft_tissues.json").string();
  return s;
}

SceneDescription sceneOf(const std::string& models) {
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto path = std::filesystem::temp_directory_path() / (test + "_cloudcontact_soft.sdf");
  std::ofstream(path) << R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="soft"><gravity>0 0 -9.8</gravity>)"
                      << models << "</world></sdf>";
  return loadScene(path);
}

std::string softBar(const std::string& attributes, const std::string& more = "",
                    const std::string& link = "", const std::string& model = "") {
  return "<model name='bar'>" + model + "<link name='l'>" + link +
         "<collision name='c'><geometry><box><size>0.012 0.012 0.08</size></box></geometry>"
         "<cloudcontact:soft " +
         attributes + "/>" + more + "</collision></link></model>";
}
// Of soft_tissues.json.
constexpr double kFatModulus = 8e3, kFatStiffness = 1e4, kSkinModulus = 6e4;
const std::string kFat = "<cloudcontact:tissue>fat</cloudcontact:tissue>";

// The center of mass of a bar that hangs sinks by density g L^2 / (3 E).
TEST(SoftScene, ABarHangs) {
  World world(sceneOf(softBar("spacing='0.006' held='+z'",
                              "<cloudcontact:tissue>skin</cloudcontact:tissue>")),
              settings());
  ASSERT_TRUE(world.isSoft(0));
  EXPECT_NEAR(world.mass(0), 1100 * 0.012 * 0.012 * 0.08, 1e-8);
  const Mesh before = world.softSurface(0);
  for (int n = 0; n < 1500; ++n) world.step(1e-3);
  const double sunk = 1100 * 9.8 * 0.08 * 0.08 / (3 * kSkinModulus);
  // The held end cannot grow thinner, which stiffens it.
  EXPECT_NEAR(world.pose(0).position.z(), -sunk, 0.05 * sunk);
  EXPECT_LT(world.state(0).linearVelocity.norm(), 1e-4);
  // Half of what gravity gave is in the bar.
  const double fallen = world.mass(0) * 9.8 * sunk;
  EXPECT_NEAR(world.moment().energy.elastic, fallen / 2, 0.05 * fallen);
  // Drawn from the top, which stays, to the bottom, which sinks by 3/2 as far as the center.
  double low = 1, high = -1;
  for (const Vec3& v : world.softSurface(0).vertices) {
    low = std::min(low, world.pose(0).toWorld(v).z());
    high = std::max(high, world.pose(0).toWorld(v).z());
  }
  EXPECT_NEAR(high, 0.04, 1e-6);
  EXPECT_NEAR(low, -0.04 - 1.5 * sunk, 0.05 * sunk);
  EXPECT_EQ(before.triangles.size(), world.softSurface(0).triangles.size());
}

// The example: the ball ends at rest on the pad, and the blade leaves a slit.
TEST(SoftScene, ABladeSlitsSkin) {
  std::uint64_t hash = 0;
  for (const int threads : {1, 2}) {
    World world(loadScene(kFolder / "tissue.sdf"), settings(threads));
    for (int n = 0; n < 500; ++n) world.step(1e-3);
    const SoftRecord pad = world.softRecord(0);
    EXPECT_GT(pad.cut, 60);
    EXPECT_EQ(pad.pieces, 1);  // down to a half
    EXPECT_GT(world.moment().energy.cutAway, 0);
    const Vec3 ball = world.pose(1).position;
    EXPECT_GT(ball.z(), 0.02);           // held up
    EXPECT_LT(ball.z(), 0.02 + 0.0092);  // and pressed in
    EXPECT_LT(world.state(1).linearVelocity.norm(), 0.02);
    if (threads > 1) {
      EXPECT_EQ(world.hash(), hash);
    }
    hash = world.hash();
  }
}

// Its own weight presses it together by density g L^2 / (2 E), its center by 2/3 of that, and its
// lower nodes sink in by the weight over their share of k, a face and half a cell of the sides,
// where all sank in alike; those in the middle bear more.
TEST(SoftScene, ABlockStandsOnATable) {
  const double edge = 0.024;
  World world(
      sceneOf(
          "<model name='block'><link name='l'><collision name='c'><geometry><box>"
          "<size>0.024 0.024 0.024</size></box></geometry><cloudcontact:soft spacing='0.006'/>" +
          kFat + "</collision></link></model>" +
          "<model name='table'><static>true</static><pose>0 0 -0.022 0 0 0</pose>"
          "<link name='l'><collision name='c'><geometry><box><size>0.04 0.04 0.02</size></box>"
          "</geometry></collision></link></model>"),
      settings());
  for (int n = 0; n < 1500; ++n) world.step(1e-3);
  const double weight = 920 * edge * edge * edge * 9.8;
  const double lower = (edge * edge + 4 * edge * 0.003) / (6 * edge * edge);
  const double wanted =
      920 * 9.8 * edge * edge / (3 * kFatModulus) + weight / (kFatStiffness * lower);
  EXPECT_NEAR(world.pose(0).position.z(), -wanted, 0.06 * wanted);
  EXPECT_EQ(world.moment().pairs, 1);
  EXPECT_EQ(world.moment().contacts, 25);
  ContactsNow now;
  world.contacts(now);
  ASSERT_EQ(now.patches.size(), 1u);
  Vec3 force = Vec3::Zero();
  for (const ContactNow& p : now.points) force += p.force;
  EXPECT_NEAR(force.z(), -weight, 1e-3 * weight);  // on the table
  EXPECT_LT(world.moment().energy.ofBodies(), 0);
}

void refused(const std::string& models, const std::string& message) {
  try {
    World world(sceneOf(models), settings());
    FAIL() << message;
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
  }
}

TEST(SoftScene, RefusesWhatItCannotBe) {
  refused(softBar("", kFat), "attribute spacing: is missing");
  refused(softBar("spacing='0'", kFat), "attribute spacing");
  refused(softBar("spacing='0.006' held='top'", kFat), "top is no side; give some of -x");
  refused(softBar("spacing='0.006'"), "its tissue is missing");
  refused(softBar("spacing='0.0001'", kFat), "no less than a voxel");
  refused(softBar("spacing='0.006'", kFat + "<cloudcontact:cuttable/>"), "neither cuts nor wears");
  refused(softBar("spacing='0.006'", kFat, "", "<static>true</static>"), "hold its sides");
  refused(softBar("spacing='0.006'", "<cloudcontact:tissue>steel</cloudcontact:tissue>"),
          "steel: soft tissue needs its elasticity");
  refused(
      softBar("spacing='0.006'", kFat + "<cloudcontact:window>sphere:0.003</cloudcontact:window>"),
      "leave them out");
}

}  // namespace
}  // namespace cloudcontact::program::sim_soft_test
