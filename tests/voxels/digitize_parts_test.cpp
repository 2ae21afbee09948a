// Machine parts and nested shells, with the faults that their files often have: missing facets and
// cracks along seams.
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/test_meshes.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::digitize_parts_test {
namespace {

Cloud cloudOf(const Mesh& mesh, double voxelSize, DigitizeReport* report = nullptr) {
  DigitizeSettings settings;
  settings.voxelSize = voxelSize;
  return digitize(mesh, settings, report);
}

template <typename Visit>
void forEachVoxel(const Cloud& cloud, Visit&& visit) {
  const Eigen::Vector3i n = cloud.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) visit(cloud.center(x, y, z), cloud.coverage(x, y, z));
}

// Opens a crack in a turned mesh along the first half of its last meridian: the vertices there
// become two, some 1e-4 of their distance from the origin apart.
Mesh cracked(Mesh mesh, int around) {
  const int count = static_cast<int>(mesh.vertices.size());
  for (int v = 0; v < count; ++v) mesh.vertices.emplace_back(1.0001 * mesh.vertices[v]);
  for (std::size_t t = 2 * around - 2; t < mesh.triangles.size() / 2; t += 2 * around)
    for (std::size_t k = t; k < t + 2; ++k)
      for (int c = 0; c < 3; ++c)
        if (int& v = mesh.triangles[k][c]; v % around == 0) v += count;
  return mesh;
}

// A disc with a blind hole from above, both round about z.
Mesh blindHole(double outer, double height, double radius, double depth) {
  const std::array<Eigen::Vector2d, 6> profile{{{0, 0},
                                                {outer, 0},
                                                {outer, height},
                                                {radius, height},
                                                {radius, height - depth},
                                                {0, height - depth}}};
  return revolvedMesh(120, 6, false, [&](double angle, double s) {
    const Eigen::Vector2d p = profile[std::lround(5 * s)];
    return Vec3(p[0] * std::cos(angle), p[0] * std::sin(angle), p[1]);
  });
}

TEST(Parts, NutWithOpenEdges) {
  const Mesh whole = threadedRing(Thread(), 13e-3, 12e-3, 1e-4);
  const Mesh nut = test::withHoles(cracked(whole, 180), 36, 1);
  EXPECT_GT(inspect(nut).openEdges, 108u);
  const double truth = std::abs(inspect(whole).volume);  // its triangles face inward
  for (const double h : {1e-4, 2.5e-4}) {
    DigitizeReport report;
    const Cloud cloud = cloudOf(nut, h, &report);
    EXPECT_FALSE(report.closed);
    EXPECT_NEAR(cloud.massProperties().volume, truth, 1e-3 * truth);
    EXPECT_LT(cloud.bytes(), 15'000'000u);
    forEachVoxel(cloud, [&](const Vec3& p, int coverage) {
      const double r = std::hypot(p[0], p[1]);
      // No streak in the bore (the thread's minor radius is 6.9 mm), none outside the nut.
      if (r < 6.6e-3 || r > 12.4e-3) {
        ASSERT_EQ(coverage, 0) << p.transpose();
      }
      // The ring around the thread's grooves is whole.
      if (r > 8.6e-3 && r < 11e-3 && std::abs(p[2]) < 4e-3) {
        ASSERT_EQ(coverage, 255) << p.transpose();
      }
    });
  }
}

TEST(Parts, HoleWithOpenEdges) {
  const Mesh whole = blindHole(10e-3, 16e-3, 4e-3, 12e-3);
  const double truth = inspect(whole).volume, h = 1e-4;
  const Mesh open = test::withHoles(whole, 20, 2);
  EXPECT_FALSE(inspect(open).closed());
  const Cloud cloud = cloudOf(open, h);
  EXPECT_NEAR(cloud.massProperties().volume, truth, 1e-3 * truth);
  double low = INFINITY, high = -INFINITY;
  forEachVoxel(cloud, [&](const Vec3& p, int coverage) {
    if (coverage == 0) return;
    low = std::min(low, p[2]);
    high = std::max(high, p[2]);
  });
  // The blind hole has no streak: it is empty around its axis from the top down to its floor.
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

TEST(Parts, BoltAndPegByTheirVolumes) {
  for (const Mesh& mesh : {threadedRod(Thread(), 20e-3), test::cylinderMesh(4e-3, 30e-3, 64)}) {
    DigitizeReport report;
    const double truth = inspect(mesh).volume;
    const Cloud cloud = cloudOf(mesh, 1e-4, &report);
    EXPECT_TRUE(report.closed);
    EXPECT_NEAR(cloud.massProperties().volume, truth, 1e-4 * truth);
    EXPECT_LT(cloud.bytes(), 15'000'000u);
  }
}

// A tooth and its nerve, each a closed shell: the nerve is material inside material and changes
// nothing.
TEST(Parts, ToothWithItsNerve) {
  const Mesh tooth = test::sphereMesh(1, 5).scaled({90, 110, 160});
  const Mesh nerve = test::sphereMesh(1, 4).scaled({20, 30, 100});
  const double outside = inspect(tooth).volume;
  EXPECT_NEAR(cloudOf(test::joined(tooth, nerve), 2.0).massProperties().volume, outside,
              1e-4 * outside);
}

}  // namespace
}  // namespace cloudcontact::digitize_parts_test
