// The laboratory tells right from wrong: its truths agree with quadrature, and planted faults show.
#include "lab/chart.h"

#include <cloudcontact/digitize.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/oracle.h"
#include "lab/self_check.h"
#include "lab/solids.h"

namespace cloudcontact::program::lab {
namespace {

LabCase caseNamed(const std::string& name) {
  for (const LabCase& one : allCases())
    if (one.name == name) return one;
  throw std::runtime_error("no case " + name);
}

// A method that answers with the truth, and then spoils it.
LabMethod spoilt(const LabCase& one, const std::function<void(std::vector<LabPoint>&)>& spoil) {
  const Instance instance = one.make(1);
  return {"cloud", "voxel = size / 32", 1.0 / 32, [=](const LabBody&, const LabBody&, double) {
            LabPair pair;
            pair.find = [=](const Pose& b) {
              for (const Placement& p : instance.placements)
                if ((p.b.position - b.position).norm() < 1e-12) {
                  std::vector<LabPoint> points = {
                      {*p.truth.centre, p.truth.direction, *p.truth.depth, 1}};
                  spoil(points);
                  return points;
                }
              return std::vector<LabPoint>();
            };
            pair.microseconds = [](const Pose&, int repeat, double) {
              return std::vector<double>(std::size_t(repeat), 1.0);
            };
            return pair;
          }};
}

std::vector<std::string> faultsOf(const std::function<void(std::vector<LabPoint>&)>& spoil) {
  const LabCase one = caseNamed("sphere on sphere");
  return ownFaults(runChart({one}, {spoilt(one, spoil)}, {}), {});
}

TEST(LabCheck, PassesTheTruth) {
  EXPECT_TRUE(faultsOf([](auto&) {}).empty());
}

TEST(LabCheck, SeesAFlippedNormal) {
  EXPECT_FALSE(faultsOf([](auto& points) { points[0].normal = -points[0].normal; }).empty());
}

TEST(LabCheck, SeesANormalThatIsADegreeOff) {
  EXPECT_FALSE(faultsOf([](auto& points) {
                 const Eigen::AngleAxisd turn(std::numbers::pi / 180, Vec3::UnitX());
                 points[0].normal = turn * points[0].normal;
               }).empty());
}

TEST(LabCheck, SeesADepthThatIsAFifthOfAVoxelOff) {
  EXPECT_FALSE(faultsOf([](auto& points) { points[0].depth += 0.2 * 0.01 / 32; }).empty());
}

TEST(LabCheck, SeesAContactThatIsNotFound) {
  EXPECT_FALSE(faultsOf([](auto& points) { points.clear(); }).empty());
}

// A ball that bounces as if nothing damped it breaks the damped ball's rule.
TEST(LabCheck, SeesADampingThatIsDropped) {
  const auto run = [](const std::string& name) {
    for (const StabilityScene& scene : motionScenes())
      if (scene.name == name) return scene.run({Method::Cloud, 1e-3, "stiff"});
    throw std::runtime_error("no scene " + name);
  };
  const Verdict damped = run("bouncing, damping ratio 0.2"), bare = run("bouncing, undamped");
  StabilityRow row;
  row.scene = "bouncing", row.trial = {Method::Cloud, 1e-3, "stiff"}, row.verdict = damped;
  EXPECT_TRUE(ownFaults({}, {row}).empty());
  row.verdict = within(bare.figure, damped.limit, 0.05, "another rebound");
  EXPECT_EQ(ownFaults({}, {row}).size(), 1u);
}

// And our own method, as it is, stands up to it where it is cheap to ask.
TEST(LabCheck, OursPassesOnSpheres) {
  std::vector<LabMethod> methods = cloudMethods();
  std::erase_if(methods, [](const LabMethod& m) { return m.detail != 1.0 / 32; });
  ChartSettings quick;
  quick.quick = true;
  for (const char* name : {"sphere on plane", "sphere on sphere"})
    for (const std::string& fault : ownFaults(runChart({caseNamed(name)}, methods, quick), {}))
      ADD_FAILURE() << fault;
}

// Each case's truth against the foundation's force by quadrature on fine meshes: they press the
// same way along the same axis, whatever the law, where symmetry says so.
class CaseTruth : public ::testing::TestWithParam<std::string> {};

TEST_P(CaseTruth, AgreesWithQuadrature) {
  const LabCase one = caseNamed(GetParam());
  const Instance instance = one.make(3);
  const Placement& p = instance.placements.back();
  const double fine = 2e-4 * one.size;
  const OracleForce found =
      foundationForce(instance.a.mesh(fine), instance.b.mesh(fine), p.b, one.size / 40);
  ASSERT_GT(found.force.norm(), 0);
  const double angle =
      std::atan2(found.force.cross(p.truth.direction).norm(), found.force.dot(p.truth.direction));
  EXPECT_LT(angle * 180 / std::numbers::pi, 1.0);
  if (p.truth.centre) {
    const Vec3 torque = found.torque - p.truth.centre->cross(found.force);
    EXPECT_LT(torque.norm() / found.force.norm(), 0.02 * one.size);
  }
  if (p.truth.depth) {
    EXPECT_NEAR(found.deepest, *p.truth.depth, 0.1 * *p.truth.depth);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, CaseTruth,
                         ::testing::Values("sphere on sphere", "cylinder's side on a face",
                                           "box's face on a face", "torus on torus", "chain links",
                                           "tube over a rod", "hex key in its socket",
                                           "bowl in a bowl", "capsule in a V groove",
                                           "peg in a hole, clearance 0.2 mm"),
                         [](const auto& one) {
                           std::string name = one.param;
                           std::erase_if(name, [](char c) { return !std::isalnum(c); });
                           return name;
                         });

TEST(LabSolids, AreClosedAndHaveTheirVolume) {
  const auto volumeOf = [](const Mesh& mesh) {
    DigitizeSettings settings;
    settings.voxelSize = 0.05;
    DigitizeReport report;
    const double volume = digitize(mesh, settings, &report).massProperties().volume;
    EXPECT_TRUE(report.closed);
    // The sum over tetrahedra has the sign of how triangles are turned.
    double six = 0;
    for (const auto& t : mesh.triangles)
      six += mesh.vertices[std::size_t(t[0])].dot(
          mesh.vertices[std::size_t(t[1])].cross(mesh.vertices[std::size_t(t[2])]));
    EXPECT_NEAR(six / 6, volume, 0.002 * volume);
    return volume;
  };
  constexpr double kPi = std::numbers::pi;
  EXPECT_NEAR(volumeOf(torus(1, 0.3, 1e-3)), 2 * kPi * kPi * 0.09, 0.01);
  EXPECT_NEAR(volumeOf(tube(circle(0.5, 1e-4), polygon(int(circle(0.5, 1e-4).size()), 1), 0, 1)),
              kPi * 0.75, 0.01);
  const Outline notched = {{-1, -1}, {1, -1}, {1, 0}, {0.5, 0}, {0, -0.5}, {-0.5, 0}, {-1, 0}};
  EXPECT_NEAR(volumeOf(prism(notched, 0, 2)), 2 * (2 - 0.25), 0.01);
}

TEST(LabChart, TheFrontierIsWhatNothingBeats) {
  const auto row = [](const char* method, double time, double error) {
    ChartRow r;
    r.family = "f", r.name = "c", r.method = method, r.setting = "s";
    r.microseconds = time, r.normalDeg.mean = error;
    return r;
  };
  std::vector<ChartRow> rows = {row("a", 1, 1), row("b", 2, 2), row("c", 3, 0.1), row("d", 0.5, 9)};
  markFrontier(rows);
  EXPECT_TRUE(rows[0].frontier && rows[2].frontier && rows[3].frontier);
  EXPECT_FALSE(rows[1].frontier);
}

}  // namespace
}  // namespace cloudcontact::program::lab
