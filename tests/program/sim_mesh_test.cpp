// Generated meshes against closed forms: watertight, with the right volume, handedness, and play
// between nut and bolt.
#include <cloudcontact/mesh/mesh_repair.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene/generated_mesh.h"
#include "scene/penetration.h"

namespace cloudcontact::program::sim_mesh_test {
namespace {

constexpr double kPi = std::numbers::pi;

// Area of a regular polygon of n corners at `radius`.
double polygonArea(int n, double radius) {
  return n / 2.0 * radius * radius * std::sin(2 * kPi / n);
}

double frustum(double areaA, double areaB, double height) {
  return height / 3 * (areaA + areaB + std::sqrt(areaA * areaB));
}

// Checks that the mesh is closed and oriented outward; returns its volume.
double soundVolume(const Mesh& mesh) {
  const MeshReport report = inspect(mesh);
  EXPECT_TRUE(report.closed()) << report.openEdges << " open, " << report.overusedEdges;
  EXPECT_EQ(report.degenerateTriangles, 0u);
  return report.volume;
}

TEST(GeneratedMesh, PegHasItsPolygonsVolume) {
  const double wall = polygonArea(96, 4e-3), end = polygonArea(96, 3.5e-3);
  EXPECT_NEAR(soundVolume(pegMesh(4e-3, 20e-3, 0.5e-3, 96)),
              wall * 19e-3 + 2 * frustum(end, wall, 0.5e-3), 1e-16);
}

TEST(GeneratedMesh, HoleHasItsBlocksVolumeWithoutTheHole) {
  const double wall = polygonArea(96, 4e-3), mouth = polygonArea(96, 4.5e-3);
  EXPECT_NEAR(soundVolume(holeMesh(4e-3, 14e-3, 12e-3, 0.5e-3, 96)),
              14e-3 * 14e-3 * 12e-3 - wall * 11.5e-3 - frustum(wall, mouth, 0.5e-3), 1e-16);
}

// Pappus' theorem; the error of facets falls with their number squared.
TEST(GeneratedMesh, ChainLinkTendsToPappus) {
  const double truth = kPi * 0.1 * 0.1 * (2 * kPi * 0.25 + 2 * 0.6);
  ChainLink coarse{0.1, 0.25, 0.6, 24, 32}, fine{0.1, 0.25, 0.6, 48, 64};
  const double lackCoarse = truth - soundVolume(chainLinkMesh(coarse));
  const double lackFine = truth - soundVolume(chainLinkMesh(fine));
  EXPECT_GT(lackFine, 0);
  EXPECT_LT(lackFine, 0.004 * truth);
  EXPECT_NEAR(lackCoarse / lackFine, 4, 0.05);
}

// Mean of the profile's squared radius over a pitch: flats of P/8 and P/4 with flanks between.
double meanSquaredRadius(double major, double pitch) {
  const double high = major / 2, low = high - 5.0 / 16 * pitch * std::sqrt(3.0);
  return high * high / 8 + low * low / 4 + 0.625 * (high * high + high * low + low * low) / 3;
}

struct ThreadCase {
  double major, pitch;
  int starts;
  bool left;
};
// Names a case in gtest's output.
void PrintTo(const ThreadCase& one, std::ostream* out) {
  *out << (one.left ? "left M" : "M") << 1e3 * one.major << ", " << one.starts << " starts";
}

class ThreadTest : public ::testing::TestWithParam<ThreadCase> {
 protected:
  Thread thread() const {
    Thread t;
    t.majorDiameter = GetParam().major;
    t.pitch = GetParam().pitch;
    t.starts = GetParam().starts;
    t.leftHanded = GetParam().left;
    return t;
  }
};

// Lengths that differ by whole pitches differ by full thread only, whatever the ends are.
TEST_P(ThreadTest, HoldsTheIsoProfilesVolume) {
  const Thread t = thread();
  const double longer = soundVolume(boltMesh(t, 14 * t.pitch));
  const double shorter = soundVolume(boltMesh(t, 10 * t.pitch));
  const double truth = kPi * meanSquaredRadius(t.majorDiameter, t.pitch) * 4 * t.pitch;
  EXPECT_LT(longer - shorter, truth);
  EXPECT_GT(longer - shorter, truth * (1 - 0.0015));  // 96 facets lack 0.0007
}

TEST_P(ThreadTest, NutHasItsVolumeLessTheProfile) {
  const Thread t = thread();
  const double width = 1.6 * t.majorDiameter;
  const double more =
      soundVolume(nutMesh(t, 14 * t.pitch, width)) - soundVolume(nutMesh(t, 10 * t.pitch, width));
  const double hexagon = std::sqrt(3.0) / 2 * width * width;
  const double hole = hexagon - more / (4 * t.pitch);
  const double truth = kPi * meanSquaredRadius(t.majorDiameter, t.pitch);
  EXPECT_NEAR(hole / truth, 1 - 0.0007, 0.0008);
}

TEST_P(ThreadTest, FollowsItsHandAndStarts) {
  const Thread t = thread();
  const Mesh mesh = boltMesh(t, 8 * t.pitch);
  const auto strayed = [&](double hand, int starts) {
    double furthest = 0;
    for (const auto& v : mesh.vertices) {
      if (v.head<2>().norm() < 0.9999 * t.majorDiameter / 2) continue;  // not on the crest
      const double turns = std::atan2(v.y(), v.x()) / (2 * kPi);
      const double pitches = v.z() / t.pitch - hand * turns * starts;
      furthest = std::max(furthest, std::abs(pitches - std::round(pitches)));
    }
    return furthest;
  };
  const double hand = t.leftHanded ? -1 : 1;
  EXPECT_LT(strayed(hand, t.starts), 1.0 / 16 + 1e-6);  // half the crest's flat
  EXPECT_GT(strayed(-hand, t.starts), 0.25);
  EXPECT_GT(strayed(hand, t.starts + 1), 0.25);
}

// A radial clearance c gives the flanks an axial play of c tan(30 deg) to either side; an offset
// beyond it overlaps by its cosine.
TEST_P(ThreadTest, MatesWithItsNutWithinTheClearance) {
  const Thread t = thread();
  Thread wide = t;
  wide.clearance = 0.05 * t.pitch;
  const double play = wide.clearance * std::tan(kPi / 6);
  const Mesh bolt = boltMesh(t, 12 * t.pitch),
             nut = nutMesh(wide, 5 * t.pitch, 1.6 * t.majorDiameter);
  const MeasuredBody a{{{probed(SceneMesh{}, &bolt), Pose()}}};
  const MeasuredBody b{{{probed(SceneMesh{}, &nut), Pose()}}};
  const auto pushed = [&](double by) {
    const Pose pose{Eigen::Quaterniond::Identity(), Vec3(0, 0, 3 * t.pitch + by)};
    return penetration(a, Pose(), b, pose);
  };
  EXPECT_EQ(pushed(0.8 * play), 0);
  EXPECT_EQ(pushed(-0.8 * play), 0);
  // Probes on the edges of flanks meet facets of the other body: tolerance of a facet's sagitta.
  const double sagitta = t.majorDiameter / 2 * (1 - std::cos(kPi / t.segments));
  for (const double by : {2 * play, -2 * play})
    EXPECT_NEAR(pushed(by), play * std::cos(kPi / 6), sagitta) << by;
}

// A turn moves a thread by its lead: with the matching shift nothing overlaps, against it the
// threads cross.
TEST_P(ThreadTest, TurnsByItsLead) {
  const Thread t = thread();
  Thread wide = t;
  wide.clearance = 0.05 * t.pitch;
  const Mesh bolt = boltMesh(t, 12 * t.pitch),
             nut = nutMesh(wide, 5 * t.pitch, 1.6 * t.majorDiameter);
  const MeasuredBody a{{{probed(SceneMesh{}, &bolt), Pose()}}};
  const MeasuredBody b{{{probed(SceneMesh{}, &nut), Pose()}}};
  const auto turned = [&](double turns, double lead) {
    const Eigen::AngleAxisd turn(2 * kPi * turns, Vec3::UnitZ());
    const Vec3 at(0, 0, 3 * t.pitch + turns * lead);
    return penetration(a, Pose(), b, {Eigen::Quaterniond(turn), at});
  };
  const double lead = (t.leftHanded ? -1 : 1) * t.lead();
  EXPECT_EQ(turned(0.3, lead), 0);
  EXPECT_GT(turned(0.3 / t.starts, -lead), 0.1 * t.pitch);
}

INSTANTIATE_TEST_SUITE_P(Threads, ThreadTest,
                         ::testing::Values(ThreadCase{16e-3, 2e-3, 1, false},
                                           ThreadCase{16e-3, 2e-3, 1, true},
                                           ThreadCase{12e-3, 1.75e-3, 2, false},
                                           ThreadCase{20e-3, 2.5e-3, 1, false}),
                         [](const ::testing::TestParamInfo<ThreadCase>& param) {
                           return std::string(param.param.left ? "Left" : "") + "M" +
                                  std::to_string(std::lround(1e3 * param.param.major)) + "Starts" +
                                  std::to_string(param.param.starts);
                         });

TEST(GeneratedMesh, HeadedBoltIsClosedAndHoldsItsHead) {
  const Thread t;
  const double hexagon = std::sqrt(3.0) / 2 * 24e-3 * 24e-3;
  EXPECT_NEAR(soundVolume(boltMesh(t, 32e-3, 24e-3, 10e-3)) - soundVolume(boltMesh(t, 32e-3)),
              hexagon * 10e-3, 1e-15);
}

TEST(GeneratedMesh, ImpossibleMeasuresAreRefused) {
  EXPECT_THROW(pegMesh(1e-3, 1e-3, 2e-3), std::invalid_argument);
  EXPECT_THROW(holeMesh(5e-3, 10e-3, 5e-3, 1e-3), std::invalid_argument);
  EXPECT_THROW(chainLinkMesh({0.3, 0.2, 0.5, 24, 24}), std::invalid_argument);
  EXPECT_THROW(boltMesh(Thread{}, 1e-3), std::invalid_argument);
  EXPECT_THROW(nutMesh(Thread{}, 10e-3, 16e-3), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::program::sim_mesh_test
