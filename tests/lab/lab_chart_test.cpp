// The laboratory detects errors: its truths agree with quadrature, and planted faults are found.
#include "lab/chart.h"

#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/families.h"
#include "lab/lab_meshes.h"
#include "lab/oracle.h"
#include "lab/ratios.h"
#include "lab/self_check.h"

namespace cloudcontact::program::lab::lab_chart_test {
namespace {

LabCase caseNamed(const std::string& name) {
  for (const LabCase& one : allCases())
    if (one.name == name) return one;
  throw std::runtime_error("no case " + name);
}

// A method that answers with the truth, changed by `spoil`.
LabMethod spoilt(const LabCase& one, const std::function<void(std::vector<LabPoint>&)>& spoil) {
  const Instance instance = one.make(1);
  return {"cloud", "voxel = size / 32", 1.0 / 32, [=](const LabBody&, const LabBody&, double) {
            LabPair pair;
            pair.find = [=](const Pose& b) {
              for (const Placement& p : instance.placements)
                if ((p.b.position - b.position).norm() < 1e-12) {
                  std::vector<LabPoint> points = {
                      {*p.truth.center, p.truth.direction, *p.truth.depth, 1}};
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

// CloudContact passes where that is cheap to check.
TEST(LabCheck, OursPassesOnSpheres) {
  std::vector<LabMethod> methods = cloudMethods();
  std::erase_if(methods, [](const LabMethod& m) { return m.detail != 1.0 / 32; });
  ChartSettings quick;
  quick.quick = true;
  for (const char* name : {"sphere on plane", "sphere on sphere"})
    for (const std::string& fault : ownFaults(runChart({caseNamed(name)}, methods, quick), {}))
      ADD_FAILURE() << fault;
}

// Base vectors are charted by their windows, which matter: a window of 1.5 voxels is the roughest.
TEST(LabChart, HasBaseVectorsByTheirWindows) {
  ChartSettings quick;
  quick.quick = true;
  quick.method = "paper";
  const std::vector<LabMethod> methods = chartMethods(quick);
  ASSERT_EQ(methods.size(), 3u);
  const std::vector<ChartRow> rows = runChart({caseNamed("sphere on plane")}, methods, quick);
  std::vector<double> degrees;
  for (const auto& [row, setting] : {std::pair(rows.at(0), "window 1.5"),
                                     {rows.at(1), "window 2.5"},
                                     {rows.at(2), "window 4"}}) {
    EXPECT_EQ(row.method, "paper");
    EXPECT_EQ(row.setting, setting);
    EXPECT_EQ(row.why, "");
    EXPECT_GT(row.microseconds, 0);
    degrees.push_back(row.normalDeg.mean);
  }
  EXPECT_LT(degrees[0], 5);
  EXPECT_LT(degrees[1], degrees[0]);
  EXPECT_LT(degrees[2], degrees[0]);
  EXPECT_GT(degrees[2], 0);
}

// Wherever clouds run a scene, base vectors do.
TEST(LabChart, BaseVectorsRunEveryScene) {
  for (const StabilityScene& scene : allScenes())
    EXPECT_EQ(std::count(scene.methods.begin(), scene.methods.end(), Method::Paper), 1)
        << scene.name;
}

// Each case's truth agrees with the elastic foundation's force, by quadrature on fine meshes: by
// symmetry, direction and axis are equal for every law.
class CaseTruth : public ::testing::TestWithParam<std::string> {};

TEST_P(CaseTruth, AgreesWithQuadrature) {
  const LabCase one = caseNamed(GetParam());
  const Instance instance = one.make(3);
  const Placement& p = instance.placements.back();
  const double fine = 2e-4 * one.size;
  const double spacing = one.size / (one.family == "grooves" ? 120 : 40);  // an edge's tip is thin
  const OracleForce found =
      foundationForce(instance.a.mesh(fine), instance.b.mesh(fine), p.b, spacing);
  ASSERT_GT(found.force.norm(), 0);
  const AnswerError error =
      errorOf({{Vec3::Zero(), found.force.normalized(), 1, 1}}, p.truth, one.size);
  EXPECT_LT(error.normalDeg, 1.0);
  if (p.truth.center) {
    const Vec3 torque = found.torque - p.truth.center->cross(found.force);
    EXPECT_LT(torque.norm() / found.force.norm(), 0.02 * one.size);
  }
  if (const auto deepest = p.truth.deepest ? p.truth.deepest : p.truth.depth) {
    EXPECT_NEAR(found.deepest, *deepest, 0.1 * *deepest);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, CaseTruth,
    ::testing::Values("sphere on sphere", "cylinder's side on a face", "box's face on a face",
                      "torus on torus", "chain links", "tube over a rod", "hex key in its socket",
                      "bowl in a bowl", "capsule in a V groove", "capsule aside in a V groove",
                      "capsule on a V groove's flank", "spike in a crack",
                      "spike on a crack's flank", "torus deep in a plate", "torus deep in a torus",
                      "L-shape deep in a block", "peg in a hole, clearance 0.2 mm"),
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
    // The sum over tetrahedra also checks the triangles' orientation.
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

// Any direction between those of the linear and the quadratic law is right. Beyond them the error
// is the angle to the nearer one, out of their plane the angle to the plane.
TEST(LabCheck, EitherLawIsRightAndNoOther) {
  const auto leaning = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    return Vec3(-std::sin(angle), 0, std::cos(angle));
  };
  Truth truth{leaning(10), {}, {}, {}};
  truth.squareLaw = leaning(20);
  const auto error = [&](const Vec3& normal) {
    return errorOf({{Vec3::Zero(), normal.normalized(), 1, 1}}, truth, 1).normalDeg;
  };
  EXPECT_NEAR(error(leaning(15)), 0, 1e-9);
  EXPECT_NEAR(error(leaning(7)), 3, 1e-9);
  EXPECT_NEAR(error(leaning(26)), 6, 1e-9);
  EXPECT_NEAR(error(leaning(0)), 10, 1e-9);
  EXPECT_NEAR(error(-leaning(15)), 170, 6);  // never accepted
  EXPECT_NEAR(error(leaning(15) + 0.1 * Vec3::UnitY()), std::atan(0.1) * 180 / std::numbers::pi,
              1e-9);
}

TEST(LabCheck, ATrueNormalDoesNotHideAWrongDepth) {
  Truth truth{Vec3::UnitZ(), 0.1, {}, {}};
  const auto error = [&](double depth) {
    return errorOf({{Vec3::Zero(), Vec3::UnitZ(), depth, 1}}, truth, 1);
  };
  EXPECT_FALSE(error(0.55).wrongDepth);
  EXPECT_TRUE(error(0.65).wrongDepth);
  EXPECT_NEAR(error(0.65).depthTimes, 6.5, 1e-9);
  // A truth that only knows the deepest point detects it, too.
  truth.depth.reset(), truth.deepest = 0.1;
  EXPECT_TRUE(error(0.65).wrongDepth);
}

// A force k d along z is conservative. One with a sideways share of it is not: that share does net
// work around the circle.
TEST(LabCheck, ALoopDetectsAForceThatGainsEnergy) {
  const auto work = [](double drag) {
    LabPair pair;
    pair.find = [=](const Pose& b) {
      const double depth = 1 - b.position.z();
      // The sideways share makes the force non-conservative.
      const Vec3 force = depth * (Vec3::UnitZ() + drag * Vec3::UnitZ().unitOrthogonal());
      return std::vector<LabPoint>{{Vec3::Zero(), force.normalized(), force.norm(), 1}};
    };
    return loopWork(pair, {}, Vec3::UnitZ(), 0.5, 24);
  };
  EXPECT_LT(work(0), 1e-12);
  EXPECT_GT(work(0.1), 0.02);
}

TEST(LabCheck, SwappingDetectsABiasTowardOneBody) {
  const std::vector<LabPoint> answer = {{Vec3::Zero(), Vec3::UnitZ(), 1, 1}};
  const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())),
                  Vec3(1, 2, 3)};
  const auto swapped = [&](const Vec3& inWorld, double depth) {
    LabPair pair;
    pair.find = [=](const Pose& poseOfA) {
      EXPECT_LT((poseOfA.position - pose.inverse().position).norm(), 1e-12);
      // A's pose and the answer are in B's frame.
      return std::vector<LabPoint>{
          {Vec3::Zero(), pose.orientation.conjugate() * inWorld, depth, 1}};
    };
    return swapError(answer, pair, pose);
  };
  EXPECT_LT(swapped(-Vec3::UnitZ(), 1).normalDeg, 1e-6);
  EXPECT_NEAR(swapped(-Vec3(0, 1, 1).normalized(), 1).normalDeg, 45, 1e-6);
  EXPECT_NEAR(swapped(-Vec3::UnitZ(), 1.5).force, 0.5, 1e-9);
}

ChartRow rowOf(std::string method, std::string setting, std::string name, double time,
               double error) {
  ChartRow r;
  r.family = "f", r.name = std::move(name);
  r.method = std::move(method), r.setting = std::move(setting);
  r.microseconds = time, r.normalDeg.mean = error;
  return r;
}

TEST(LabChart, RatiosAreOverTheCasesThatAPeerAnswersAndMaySaySlower) {
  std::vector<ChartRow> rows = {
      rowOf("cloud", "coarse", "c", 1, 3), rowOf("cloud", "coarse", "d", 100, 3),
      rowOf("cloud", "fine", "c", 10, 1),  rowOf("cloud", "fine", "d", 1000, 1),
      rowOf("quick", "s", "c", 2, 2),      rowOf("quick", "s", "d", 2, 2),
      rowOf("slow", "s", "c", 500, 2),     rowOf("slow", "s", "d", 1, 1),
      rowOf("exact", "s", "c", 5, 0.5),    rowOf("exact", "s", "d", 5, 0.5)};
  rows[7].why = "cannot";
  const std::vector<PeerRatio> ratios = peerRatios(rows);
  ASSERT_EQ(ratios.size(), 3u);
  EXPECT_EQ(ratios[0].ours, "fine");  // the coarse setting is less accurate than the peer
  EXPECT_NEAR(ratios[0].timesFaster, 2 / 100.0, 1e-9);
  EXPECT_EQ(verdictOf(ratios[0]), "50 times slower");
  EXPECT_EQ(ratios[1].cases, 1);
  EXPECT_EQ(ratios[1].of, 2);
  EXPECT_NEAR(ratios[1].timesFaster, 500 / 10.0, 1e-9);
  EXPECT_TRUE(ratios[2].ours.empty());
  EXPECT_EQ(verdictOf(ratios[2]), "no setting of CloudContact is as accurate");
  // A setting with a wrong depth does not count.
  for (ChartRow& row : rows)
    if (row.setting == "fine") row.wrongDepth = 1;
  EXPECT_TRUE(peerRatios(rows)[1].ours.empty());
}

TEST(LabChart, MethodsWithAWrongDepthAreNotOnTheFrontier) {
  std::vector<ChartRow> rows = {rowOf("a", "s", "c", 1, 0.1), rowOf("b", "s", "c", 2, 2)};
  rows[0].wrongDepth = 1, rows[0].depthTimes = 25;
  markFrontier(rows);
  EXPECT_FALSE(rows[0].frontier);
  EXPECT_TRUE(rows[1].frontier);
  EXPECT_EQ(familyMarks(rows)[0].depthTimes, 25);
}

TEST(LabChart, TheFrontierHasTheUnbeatenMethods) {
  const auto row = [](const char* method, double time, double error) {
    return rowOf(method, "s", "c", time, error);
  };
  std::vector<ChartRow> rows = {row("a", 1, 1), row("b", 2, 2), row("c", 3, 0.1), row("d", 0.5, 9)};
  markFrontier(rows);
  EXPECT_TRUE(rows[0].frontier && rows[2].frontier && rows[3].frontier);
  EXPECT_FALSE(rows[1].frontier);
}

}  // namespace
}  // namespace cloudcontact::program::lab::lab_chart_test
