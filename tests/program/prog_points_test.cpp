// Bodies from points: their detected kind, the messages, and the mass.
#include <gtest/gtest.h>

#include <cloudcontact/objects/object_file.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "program/program_run.h"

namespace prog_points_test {
namespace {

using nlohmann::json;
using program_test::Outcome;
using program_test::Workplace;

constexpr double kRadius = 0.02;

// A ball of points, spread evenly by a spiral, in millimeters.
std::string ballPoints(int count, double from = -1) {
  std::ostringstream rows;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    if (z < from) continue;
    rows << 1e3 * kRadius * std::sqrt(1 - z * z) * std::cos(turn) << ' '
         << 1e3 * kRadius * std::sqrt(1 - z * z) * std::sin(turn) << ' ' << 1e3 * kRadius * z
         << '\n';
  }
  return rows.str();
}

Outcome digitize(const Workplace& place, std::vector<std::string> rest) {
  rest.insert(rest.begin(), "digitize");
  rest.push_back("--json");
  const Outcome outcome = place.run(rest);
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  return outcome;
}

TEST(Points, AScanIsTheBodyItEncloses) {
  const Workplace place;
  const std::string rows = ballPoints(8000);
  place.write("ball.xyz", rows);
  place.write("ball.ply",
              "ply\nformat ascii 1.0\nelement vertex 8000\nproperty float x\nproperty float y\n"
              "property float z\nend_header\n" +
                  rows);
  place.write("ball.pcd",
              "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 8000\n"
              "HEIGHT 1\nPOINTS 8000\nDATA ascii\n" +
                  rows);
  for (const char* name : {"ball.xyz", "ball.ply", "ball.pcd"}) {
    const Outcome outcome = digitize(place, {name, "--unit", "mm", "--voxel", "0.001"});
    EXPECT_NE(outcome.err.find("8000 points of a surface"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("filled the volume that they enclose"), std::string::npos)
        << outcome.err;
    EXPECT_NEAR(
        outcome.json()["volume"].get<double>() / (4 * std::numbers::pi / 3 * std::pow(kRadius, 3)),
        1, 3e-3);
  }
  // Without --voxel there is a default.
  EXPECT_GT(digitize(place, {"ball.xyz", "--unit", "mm"}).json()["voxels"].get<int>(), 5000);
}

TEST(Points, AnOpenScanIsAShellOfTheGivenThickness) {
  const Workplace place;
  place.write("cup.xyz", ballPoints(12000, 0));
  const Outcome outcome =
      digitize(place, {"cup.xyz", "--unit", "mm", "--voxel", "0.001", "--shell", "0.003"});
  EXPECT_NE(outcome.err.find("made a shell 0.003 m thick"), std::string::npos) << outcome.err;
  const double truth =
      2 * std::numbers::pi / 3 * (std::pow(kRadius + 0.0015, 3) - std::pow(kRadius - 0.0015, 3));
  EXPECT_NEAR(outcome.json()["volume"].get<double>() / truth, 1, 0.03);
}

TEST(Points, ALatticeIsTheVolumeItFills) {
  const Workplace place;
  std::ostringstream rows;
  for (int k = 0; k < 1000; ++k) rows << k % 10 << ' ' << k / 10 % 10 << ' ' << k / 100 << '\n';
  place.write("block.xyz", rows.str());
  const Outcome outcome = digitize(place, {"block.xyz", "--unit", "mm"});
  EXPECT_NE(outcome.err.find("fill a volume"), std::string::npos) << outcome.err;
  EXPECT_NEAR(outcome.json()["volume"].get<double>(), 1e-6, 1e-9);
}

TEST(Points, AnOrganizedPcdIsADepthImage) {
  const Workplace place;
  std::ostringstream rows;
  for (int k = 0; k < 1600; ++k)
    if (k == 820)
      rows << "nan nan nan\n";
    else
      rows << k % 40 - 20 << ' ' << k / 40 - 20 << " 1000\n";
  place.write("plate.pcd",
              "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 40\n"
              "HEIGHT 40\nPOINTS 1600\nDATA ascii\n" +
                  rows.str());
  const Outcome outcome =
      digitize(place, {"plate.pcd", "--unit", "mm", "--voxel", "0.001", "--shell", "0.004"});
  EXPECT_NE(outcome.err.find("depth image of 40 x 40 pixels, 1599 seen, 1 filled"),
            std::string::npos)
      << outcome.err;
  EXPECT_NEAR(outcome.json()["volume"].get<double>() / (0.039 * 0.039 * 0.004), 1, 0.01);
}

// A saved object of any kind is a body, with the same contact as its mesh.
TEST(Points, SavedObjectsAreBodies) {
  using namespace cloudcontact;
  const Workplace place;
  SphereCloud spheres;
  spheres.centers = {Vec3(0, 0, 0)};
  spheres.radii = {kRadius};
  saveObject(spheres, place / "ball.cloud");
  const std::vector<std::string> arguments = {"contact",   "halfspace", "ball.cloud", "--pose",
                                              "0 0 0.019", "--voxel",   "0.001",      "--json",
                                              "--repeat",  "1"};
  const Outcome outcome = place.run(arguments);
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NEAR(outcome.json()["force"][2].get<double>(), 1e4 * 0.001, 0.02 * 10);
  EXPECT_EQ(
      place
          .run({"contact", "halfspace", "ball.cloud", "--pose", "0 0 0.019", "--method", "gimpact"})
          .exitCode,
      2);
}

}  // namespace

}  // namespace prog_points_test
