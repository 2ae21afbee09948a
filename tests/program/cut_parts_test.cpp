// Tests the parts of the cutting demos: level surfaces, the tooth, planned paths, and a run's
// figures.
#include <gtest/gtest.h>

#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <numbers>
#include <set>

#include "draw/cut_picture.h"
#include "draw/force_chart.h"
#include "draw/plot.h"
#include "draw/svg.h"
#include "scene/cutting_figures.h"
#include "scene/level_surface.h"
#include "scene/primitive_mesh.h"
#include "scene/tooth.h"

namespace cloudcontact::program::cut_parts_test {
namespace {

TEST(LevelSurface, OfABallHasItsVolumeAndIsClosed) {
  const double r = 2e-3;
  const Vec3 center(1e-4, 2e-4, -3e-4);
  const Eigen::AlignedBox3d box(Vec3::Constant(-2.7e-3), Vec3::Constant(2.7e-3));
  double before = 1;
  for (const double cell : {4e-4, 2e-4, 1e-4}) {
    const Mesh mesh =
        levelSurface([&](const Vec3& p) { return r - (p - center).norm(); }, box, cell);
    const MeshReport report = inspect(mesh);
    EXPECT_TRUE(report.closed());
    const double error =
        std::abs(report.volume / (4 * std::numbers::pi / 3 * r * r * r) - 1);  // outward: positive
    // Edges of up to sqrt(3) cells are chords with an error of at most 3 cell^2 / 8 r.
    EXPECT_LT(error, 1.125 * (cell / r) * (cell / r));
    EXPECT_LT(error, before);
    before = error;
  }
  // A box that cuts it off closes it.
  const Mesh half = levelSurface([&](const Vec3& p) { return r - p.norm(); },
                                 {Vec3(-3e-3, -3e-3, 0), Vec3::Constant(3e-3)}, 1e-4);
  EXPECT_TRUE(inspect(half).closed());
  EXPECT_THROW(levelSurface([](const Vec3&) { return 1.0; }, box, 0), std::invalid_argument);
  EXPECT_THROW(levelSurface([](const Vec3&) { return 1.0; }, {}, 1e-4), std::invalid_argument);
  EXPECT_THROW(levelSurface([](const Vec3&) { return 1.0; }, box, 1e-9), std::invalid_argument);
}

TEST(LevelSurface, OfACloudHasItsVolume) {
  DigitizeSettings settings;
  settings.voxelSize = 1e-4;
  const Cloud cloud = digitize(primitiveMesh(Sphere{1e-3}, 1e-6), settings);
  const double volume = cloud.massProperties().volume;
  EXPECT_NEAR(inspect(cloudSurface(cloud)).volume, volume, 0.02 * volume);
  EXPECT_NEAR(inspect(cloudSurface(cloud, 2)).volume, volume, 0.06 * volume);
  EXPECT_TRUE(cloudSurface(Cloud()).triangles.empty());
}

// A first lower molar is about 10 by 10 by 20 mm; each part is closed and inside the previous one.
TEST(Tooth, HasTheSizesOfAMolar) {
  Eigen::AlignedBox3d whole;
  double last = 1;
  std::vector<std::string> names;
  for (const NamedMesh& part : toothMeshes()) {
    names.push_back(part.name);
    const MeshReport report = inspect(part.mesh);
    EXPECT_EQ(report.openEdges, 0u) << part.name;
    EXPECT_GT(report.volume, 0) << part.name;
    EXPECT_LT(report.volume, last) << part.name << ": the smaller, the further in";
    last = report.volume;
    for (const Vec3& v : part.mesh.vertices) whole.extend(v);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"enamel", "dentin", "pulp", "caries"}));
  EXPECT_NEAR(whole.sizes().x(), 10.5e-3, 0.5e-3);
  EXPECT_NEAR(whole.sizes().y(), 9.9e-3, 0.5e-3);
  EXPECT_NEAR(whole.sizes().z(), 20e-3, 0.5e-3);
  ToothShape shape;
  shape.enamel = -1e-3;
  EXPECT_THROW(toothMeshes(shape), std::invalid_argument);
}

// Down the fissure next to the pit: enamel, caries, dentin, pulp with these thicknesses. Through
// the pit only caries.
TEST(Tooth, HasItsTissuesWhereTheyBelong) {
  const double h = 2e-4;
  const Cloud cloud = toothCloud(h);
  const auto down = [&](double x, double y) {
    std::vector<std::pair<std::string, int>> met;
    const Eigen::Vector3i v = ((Vec3(x, y, 0) - cloud.origin()) / h).array().floor().cast<int>();
    for (int z = cloud.size().z() - 1; cloud.center(0, 0, z).z() > 0; --z) {
      if (cloud.coverage(v.x(), v.y(), z) < 128) continue;
      const std::string& name = cloud.materials()[cloud.material(v.x(), v.y(), z)];
      if (met.empty() || met.back().first != name) met.push_back({name, 0});
      ++met.back().second;
    }
    return met;
  };
  const auto beside = down(1.2e-3, 1e-5);
  ASSERT_EQ(beside.size(), 4u);
  const char* const order[] = {"enamel", "caries", "dentin", "pulp"};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(beside[k].first, order[k]);
  EXPECT_NEAR(beside[0].second * h, 2.0e-3, 0.5e-3) << "1 to 2 mm square to a sloping face";
  EXPECT_NEAR(beside[1].second * h, 1.2e-3, 0.4e-3);
  const auto pit = down(1e-5, 1e-5);
  ASSERT_EQ(pit.size(), 3u);
  EXPECT_EQ(pit[0].first, "caries");
  EXPECT_EQ(pit[1].first, "dentin");
  EXPECT_EQ(pit[2].first, "pulp");
}

TEST(PlannedPath, MovesAndPausesAsPlanned) {
  const PlannedPath path(
      {{Vec3(0, 0, 0), 1, 0.5}, {Vec3(0.01, 0, 0), 0.01, 0.25}, {Vec3(0.01, 0.02, 0), 0.04, 0}});
  EXPECT_NEAR(path.seconds(), 0.5 + 1 + 0.25 + 0.5, 1e-12);
  EXPECT_EQ(path.at(-1), Vec3(0, 0, 0));
  EXPECT_EQ(path.at(0.4), Vec3(0, 0, 0));
  EXPECT_NEAR((path.at(1.0) - Vec3(0.005, 0, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(path.at(1.6), Vec3(0.01, 0, 0));
  EXPECT_NEAR((path.at(2.0) - Vec3(0.01, 0.01, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(path.at(9), Vec3(0.01, 0.02, 0));
  EXPECT_THROW(PlannedPath({}), std::invalid_argument);
  EXPECT_THROW(PlannedPath({{Vec3::Zero(), 1, 0}, {Vec3::UnitX(), 0, 0}}), std::invalid_argument);
  EXPECT_THROW(PlannedPath({{Vec3(NAN, 0, 0), 1, 0}}), std::invalid_argument);
}

// Two ticks of each kind.
TEST(CuttingFigures, AreCountedRight) {
  CuttingRun run;
  run.step = 0.5;
  run.tissues = {"hard", "soft"};
  const auto tick = [&](double force, bool cutting, float hard, float soft) {
    CuttingTick t;
    t.time = run.step * static_cast<double>(run.ticks.size());
    t.force = Vec3(0, 0, force);
    t.depth = force > 0 ? 1 : 0;
    t.cutting = cutting;
    t.work = 3;
    run.ticks.push_back(t);
    run.shares.insert(run.shares.end(), {hard, soft});
  };
  tick(0, false, 0, 0);
  tick(10, false, 1, 0);      // from zero: the largest possible, 1
  tick(8, false, 1, 0);       // 0.2
  tick(4, true, 0.5f, 0.5f);  // 0.5, with a cut
  tick(3, true, 0, 1);
  tick(0.5, false, 0, 1);  // 2.5 of 3
  tick(0.1, false, 0, 1);  // below a tenth of the largest
  run.volumeBefore = 5, run.volumeAfter = 2;
  const CuttingFigures f = figuresOf(run);
  EXPECT_EQ(f.mostForce, 10);
  EXPECT_EQ(f.largestStep, 1);
  EXPECT_EQ(f.largestCuttingStep, 0.5);
  EXPECT_EQ(f.cutVolume, 3);
  EXPECT_EQ(f.workVolume, 3);
  EXPECT_EQ(f.tissues[0].firstTouch, 0.5);
  EXPECT_EQ(f.tissues[1].firstTouch, 1.5);
  EXPECT_EQ(f.tissues[0].seconds, 1);
  EXPECT_EQ(f.tissues[0].meanForce, 9);
  EXPECT_NEAR(f.tissues[1].meanForce, 1.2, 1e-12);
  EXPECT_EQ(meanForce(run, 0.4, 1.1), 9);
  const std::string svg = svgText(forceChart(run, {"title", "below", -Vec3::UnitZ(), "way [mm]"}));
  for (const char* word :
       {"title", "hard", "soft", "Force on the hand [N]", "time [s]", "way [mm]"})
    EXPECT_NE(svg.find(word), std::string::npos) << word;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_THROW(forceChart({}, {"", "", Vec3::UnitZ(), ""}), std::invalid_argument);
}

TEST(Plot, TicksAreRound) {
  EXPECT_EQ(roundTicks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(roundTicks(2.2, -0.1, 3), (std::vector<double>{0, 1, 2}));
  for (const double size : {1e-6, 3.0, 7e5}) {
    const auto ticks = roundTicks(0, size, 4);
    EXPECT_GE(ticks.size(), 3u);
    EXPECT_LE(ticks.size(), 6u);
  }
}

}  // namespace
}  // namespace cloudcontact::program::cut_parts_test
