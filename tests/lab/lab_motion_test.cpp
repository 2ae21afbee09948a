// The laboratory's mechanisms and motion: meshes against their formulas, bisection, and rules that
// distinguish what holds from what fails.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "lab/lab_meshes.h"
#include "lab/trial_runs.h"

namespace cloudcontact::program::lab::lab_motion_test {
namespace {

constexpr double kPi = std::numbers::pi;

// Each edge occurs once in each direction: closed and consistently oriented.
void expectClosed(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    ASSERT_TRUE(edges.count({edge.second, edge.first}));
  }
}

double volumeOf(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  return sum;
}

const StabilityScene& sceneNamed(const std::vector<StabilityScene>& scenes,
                                 const std::string& name) {
  for (const StabilityScene& scene : scenes)
    if (scene.name == name) return scene;
  throw std::runtime_error("no scene " + name);
}

TEST(LabMeshes, GearsAreClosedAndNearlyTheirPitchCylinder) {
  Gear gear;
  for (const int teeth : {18, 27}) {
    gear.teeth = teeth;
    const Mesh mesh = gearMesh(gear);
    expectClosed(mesh);
    const double cylinder = kPi * gear.pitchRadius() * gear.pitchRadius() * gear.width;
    EXPECT_NEAR(volumeOf(mesh), cylinder, 0.05 * cylinder);
  }
  gear.teeth = 12;
  EXPECT_THROW(gearMesh(gear), std::invalid_argument);
}

// On the pitch circle a tooth is half a pitch wide, less `thinned`.
TEST(LabMeshes, AGearsToothHasItsWidthOnThePitchCircle) {
  Gear gear;
  gear.thinned = 0.4e-3;
  gear.flankSteps = 200;
  const Mesh mesh = gearMesh(gear);
  double nearest = 1, half = 0;
  for (const Vec3& v : mesh.vertices) {
    const double off = std::abs(v.head<2>().norm() - gear.pitchRadius());
    const double angle = std::atan2(v.y(), v.x());
    if (off >= nearest || std::abs(angle) > kPi / gear.teeth) continue;
    nearest = off;
    half = std::abs(angle);
  }
  const double width = kPi * gear.module / 2 - gear.thinned;
  EXPECT_NEAR(2 * half * gear.pitchRadius(), width, 0.01 * width);
}

TEST(LabMeshes, ABowlIsClosedAndHalfAHollowBall) {
  const Mesh mesh = bowlMesh(0.1, 0.12, 96);
  expectClosed(mesh);
  const double volume = 2 * kPi / 3 * (std::pow(0.12, 3) - std::pow(0.1, 3));
  EXPECT_NEAR(volumeOf(mesh), volume, 0.005 * volume);
}

TEST(LabBisection, FindsWhereARuleTurns) {
  EXPECT_NEAR(turningPoint(0, 8, 12, [](double x) { return x < 3.3; }), 3.3, 2e-3);
  EXPECT_EQ(turningPoint(1, 8, 12, [](double) { return false; }), 1);
  EXPECT_EQ(turningPoint(1, 8, 12, [](double) { return true; }), 8);
}

TEST(LabVerdicts, EnergyGainedAndFiguresThatAreNoneFail) {
  const Verdict held = atLeast(2, 1, "");
  EXPECT_EQ(held.outcome, Outcome::Holds);
  EXPECT_EQ(failIfGains(held, 0.009, 1).outcome, Outcome::Holds);
  EXPECT_EQ(failIfGains(held, 0.011, 1).outcome, Outcome::Fails);
  EXPECT_EQ(atLeast(std::nan(""), 1, "").outcome, Outcome::Fails);
}

TEST(LabScenes, HaveUniqueNamesAndTrials) {
  std::set<std::string> names;
  for (const StabilityScene& scene : allScenes()) {
    EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    EXPECT_FALSE(scene.rule.empty());
    EXPECT_FALSE(scene.methods.empty() || scene.steps.empty() || scene.modes.empty());
  }
}

// The rule is energy's. At 240 Hz this nut is 5.6 % short, which the map says.
TEST(LabScenes, ANutRunsDownItsBoltAndItsStepsAreCounted) {
  const auto scenes = runningScenes();
  Trial trial{Method::Cloud, kStep1000, "stiff"};
  trial.cost = std::make_shared<TrialCost>();
  const Verdict verdict = sceneNamed(scenes, "nut down its bolt").run(trial);
  EXPECT_EQ(verdict.outcome, Outcome::Holds) << verdict.figure << ' ' << verdict.why;
  EXPECT_EQ(trial.cost->steps, 500);
  EXPECT_GT(trial.cost->narrowPhaseStep(), 0);
  EXPECT_GT(trial.cost->wallStep(), trial.cost->narrowPhaseStep());
}

// Bullet's own cylinder must fail: its rigid constraints brake it.
TEST(LabScenes, DistinguishHoldingFromFailing) {
  const auto scenes = motionScenes();
  const auto run = [&](const char* name, const Trial& trial) {
    return sceneNamed(scenes, name).run(trial).outcome;
  };
  EXPECT_EQ(run("box dropped on an edge", {Method::Cloud, kStep240, "stiff"}), Outcome::Holds);
  EXPECT_EQ(run("bouncing, undamped", {Method::Primitive, kStep1000, "stiff"}), Outcome::Holds);
  EXPECT_EQ(run("rolling cylinder", {Method::Primitive, kStep240, "auto"}), Outcome::Fails);
}

TEST(LabScenes, ASlopeDistinguishesItsTwoFrictions) {
  const auto scenes = mechanismScenes();
  for (const char* name : {"incline at friction 0.49", "incline at friction 0.50"}) {
    const Verdict verdict = sceneNamed(scenes, name).run({Method::Cloud, kStep240, "stiff"});
    EXPECT_EQ(verdict.outcome, Outcome::Holds) << name << ": " << verdict.figure;
  }
}

// Where a tooth's tip just touches a flank, no sample of the flank is inside the tip. With the
// tip's normals alone the force was 46 deg off and the teeth caught.
TEST(LabScenes, GearsWithHalfAVoxelOfPlayTurn) {
  const auto scenes = mechanismScenes();
  const Verdict verdict = sceneNamed(scenes, "gear pair, backlash of half a voxel")
                              .run({Method::Cloud, kStep240, "auto"});
  EXPECT_EQ(verdict.outcome, Outcome::Holds) << verdict.figure << ' ' << verdict.why;
}

TEST(LabScenes, AHullHasNoHole) {
  const auto scenes = mechanismScenes();
  EXPECT_THROW(sceneNamed(scenes, "screw's self-locking").run({Method::Gjk, kStep240, "auto"}),
               std::runtime_error);
}

}  // namespace
}  // namespace cloudcontact::program::lab::lab_motion_test
