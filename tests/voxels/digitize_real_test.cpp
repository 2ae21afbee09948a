// Real meshes, where they are at hand: open edges, degenerate triangles, threads and nested shells.
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace cloudcontact {
namespace {

class RealMesh : public testing::Test {
 protected:
  // The mesh of that name, or nothing, and the test is skipped.
  Mesh load(const std::string& name) {
    const std::filesystem::path file =
        std::filesystem::path(CLOUDCONTACT_SHARED_DIR) / "data" / (name + ".obj");
    if (!std::filesystem::exists(file)) return {};
    return loadMesh(file);
  }
  static Cloud cloudOf(const Mesh& mesh, double voxelSize, DigitizeReport* report = nullptr) {
    DigitizeSettings settings;
    settings.voxelSize = voxelSize;
    return digitize(mesh, settings, report);
  }
  template <typename Visit>
  static void forEachVoxel(const Cloud& cloud, Visit&& visit) {
    const Eigen::Vector3i n = cloud.size();
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) visit(cloud.center(x, y, z), cloud.coverage(x, y, z));
  }
};

#define LOAD_OR_SKIP(mesh, name) \
  const Mesh mesh = load(name);  \
  if (mesh.triangles.empty()) GTEST_SKIP() << "no " << name << ".obj beside the checkout"

TEST_F(RealMesh, NutWithOpenEdges) {
  LOAD_OR_SKIP(nut, "nut_m16_loose");
  EXPECT_EQ(inspect(nut).openEdges, 108u);
  for (const double h : {1e-4, 2.5e-4}) {
    DigitizeReport report;
    const Cloud cloud = cloudOf(nut, h, &report);
    EXPECT_FALSE(report.closed);
    EXPECT_NEAR(cloud.massProperties().volume, 4.1236e-6, 1e-3 * 4.1236e-6);
    EXPECT_LT(cloud.bytes(), 15'000'000u);
    // No streak in the bore (an M16 thread's minor radius is 6.9 mm), none beside the hexagon
    // (24 mm across flats).
    forEachVoxel(cloud, [&](const Vec3& p, int coverage) {
      const double r = std::hypot(p[0], p[1]);
      if (r < 6.6e-3 || r > 14.2e-3) {
        ASSERT_EQ(coverage, 0) << p.transpose();
      }
      // The ring between the thread's grooves and the hexagon is whole.
      if (r > 8.6e-3 && r < 11e-3 && std::abs(p[2] - 0.0225) < 4e-3) {
        ASSERT_EQ(coverage, 255) << p.transpose();
      }
    });
  }
}

TEST_F(RealMesh, HoleWithOpenEdges) {
  LOAD_OR_SKIP(hole, "round_hole_8mm");
  const double h = 1e-4;
  const Cloud cloud = cloudOf(hole, h);
  EXPECT_NEAR(cloud.massProperties().volume, 5.1568e-6, 1e-3 * 5.1568e-6);
  double low = INFINITY, high = -INFINITY;
  forEachVoxel(cloud, [&](const Vec3& p, int coverage) {
    if (coverage == 0) return;
    low = std::min(low, p[2]);
    high = std::max(high, p[2]);
  });
  // The blind hole has no streak: empty around its axis from the top down to its floor.
  std::size_t inHole = 0;
  forEachVoxel(cloud, [&](const Vec3& p, int coverage) {
    if (std::hypot(p[0], p[1]) > 3.9e-3 || p[2] < low) return;
    inHole += coverage == 0 && p[2] < high;
    if (p[2] > high + h) {
      ASSERT_EQ(coverage, 0);
    }
  });
  EXPECT_GT(static_cast<double>(inHole) * h * h * h, 0.5 * M_PI * 3.9e-3 * 3.9e-3 * (high - low));
}

TEST_F(RealMesh, BoltAndPegsByTheirVolumes) {
  LOAD_OR_SKIP(bolt, "bolt_m16_loose");
  for (const std::string name : {"bolt_m16_loose", "round_peg_8mm_loose", "round_peg_8mm_tight"}) {
    const Mesh mesh = load(name);
    DigitizeReport report;
    const double truth = inspect(mesh).volume;
    const Cloud cloud = cloudOf(mesh, 1e-4, &report);
    EXPECT_TRUE(report.closed) << name;
    EXPECT_NEAR(cloud.massProperties().volume, truth, 1e-4 * truth) << name;
    EXPECT_LT(cloud.bytes(), 15'000'000u) << name;
  }
}

// A tooth and its nerve, each closed: the nerve is material inside material and changes nothing.
TEST_F(RealMesh, ToothWithItsNerve) {
  LOAD_OR_SKIP(tooth, "tooth");
  const double outside = 13879297.747;  // of the outer shell alone, by the divergence theorem
  EXPECT_NEAR(cloudOf(tooth, 2.0).massProperties().volume, outside, 1e-4 * outside);
}

}  // namespace
}  // namespace cloudcontact
