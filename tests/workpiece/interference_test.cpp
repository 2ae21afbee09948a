// Collision voxels of four kinds of objects: equal where all are equally fine, close elsewhere, and
// the same for any number of threads.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/cloud_solid.h>
#include <cloudcontact/workpiece/collision_finder.h>
#include <cloudcontact/workpiece/interference.h>

#include <algorithm>

#include "voxels/small_clouds.h"

namespace cloudcontact {
namespace {

constexpr double kVoxel = 1e-3;  // [m]
using Voxels = std::vector<VoxelIndex>;

Cloud block() {
  return test::smallCloud(kVoxel, {4, 4, 4}, [](int x, int y, int z) {
    return std::min({x, y, z}) >= 2 && std::max({x, y, z}) < 28 ? 255 : 0;
  });
}

struct Answers {
  Voxels points, columns, spheres, clouds;
};

Answers allFour(const Cloud& tool, const SphereCloud& asSpheres, const Pose& place, int threads) {
  const Cloud work = block();
  return {interference(centerPoints(tool, 3), place, Octree(work), threads),
          interference(toColumns(tool, 2, 1), place, toColumns(work, 2, 1), threads),
          interference(asSpheres, place, work, threads), interference(tool, place, work, threads)};
}

std::size_t apart(const Voxels& a, const Voxels& b) {
  const auto key = [](const VoxelIndex& v) { return v.x() + 1000 * (v.y() + 1000 * v.z()); };
  std::vector<int> x, y, difference;
  for (const VoxelIndex& v : a) x.push_back(key(v));
  for (const VoxelIndex& v : b) y.push_back(key(v));
  std::set_symmetric_difference(x.begin(), x.end(), y.begin(), y.end(),
                                std::back_inserter(difference));
  return difference.size();
}

// A box of 6x5x4 voxels, along the grid: 3 of its 4 layers are in the block.
TEST(Interference, AllKindsGiveTheSameForABox) {
  const Cloud tool = test::smallCloud(
      kVoxel, {1, 1, 1}, [](int x, int y, int z) { return x < 6 && y < 5 && z < 4 ? 255 : 0; });
  SphereCloud spheres;  // a small one per voxel
  for (const Vec3& p : centerPoints(tool).positions) {
    spheres.centers.push_back(p);
    spheres.radii.push_back(0.4 * kVoxel);
  }
  const Pose place{Eigen::Quaterniond::Identity(), kVoxel * Vec3(10, 11, 25)};
  const Answers a = allFour(tool, spheres, place, 1);
  ASSERT_EQ(a.clouds.size(), 6u * 5 * 3);
  EXPECT_EQ(a.clouds.front(), VoxelIndex(10, 11, 25));
  EXPECT_EQ(a.clouds.back(), VoxelIndex(15, 15, 27));
  EXPECT_EQ(a.points, a.clouds);
  EXPECT_EQ(a.columns, a.clouds);
  EXPECT_EQ(a.spheres, a.clouds);
}

// A ball at any pose: the kinds differ by its outermost voxels at most, and the digital normal by a
// degree.
TEST(Interference, KindsDifferByTheToolsRimAlone) {
  const double radius = 9.317;
  const Cloud tool = test::ballCloud(kVoxel, 3, Vec3(12, 12, 12), radius);
  const SphereCloud one{{kVoxel * Vec3(12, 12, 12)}, {radius * kVoxel}, {}, {}};
  Pose place{Eigen::Quaterniond(0.8, 0.1, -0.3, 0.5).normalized(), Vec3::Zero()};
  place.position =
      kVoxel * Vec3(15.2, 14.7, 33.1) - place.orientation * (kVoxel * Vec3(12, 12, 12));
  const Answers a = allFour(tool, one, place, 1);
  std::size_t truth = 0;
  for (int z = 0; z < 28; ++z)
    for (int y = 2; y < 28; ++y)
      for (int x = 2; x < 28; ++x)
        truth += (Vec3(x + .5, y + .5, z + .5) - Vec3(15.2, 14.7, 33.1)).norm() < radius;
  ASSERT_GT(truth, 300u);
  EXPECT_EQ(a.spheres.size(), truth) << "a sphere is exact";
  const double rim = 2 * M_PI * radius * 4.2;  // one layer of voxels of the touched cap
  EXPECT_LT(apart(a.clouds, a.spheres), 0.3 * rim);
  EXPECT_LT(apart(a.columns, a.spheres), 0.3 * rim);
  EXPECT_LT(apart(a.points, a.spheres), 0.9 * rim) << "a voxel with one point of 27 counts";

  const BaseVectorField field(block(), {{"tooth", 1e4, 1, 1e9, 2000}}, sphereWindow(kVoxel));
  Detection d;
  d.area = {Sphere{radius * kVoxel}, {.position = kVoxel * Vec3(12, 12, 12)}};
  CollisionFinder finder;
  const Vec3 found = finder.find(field, {}, d, place).normal();
  const double depth = finder.find(field, {}, d, place).depth;
  EXPECT_NEAR(depth, 4.2 * kVoxel, 0.2 * kVoxel);
  EXPECT_LT(std::acos(found.z()) * 57.3, 1);
  for (const Voxels* b : {&a.points, &a.columns, &a.spheres, &a.clouds}) {
    const Collision& c = finder.gather(field, {}, d, place, *b);
    EXPECT_EQ(c.voxels.size(), b->size());
    EXPECT_LT(std::acos(std::min(1.0, c.normal().dot(found))) * 57.3, 1);
    EXPECT_NEAR(c.stiffness, 1e4, 1e-6);
  }
}

TEST(Interference, InSequenceAndInParallelTheSame) {
  const Cloud tool = test::ballCloud(kVoxel, 3, Vec3(12, 12, 12), 9.3);
  const SphereCloud spheres = inscribedSpheres(tool);
  const Pose place{Eigen::Quaterniond(0.8, 0.1, -0.3, 0.5).normalized(), kVoxel * Vec3(9, 5, 11)};
  const Answers one = allFour(tool, spheres, place, 1);
  ASSERT_GT(one.clouds.size(), 300u);
  for (const int threads : {2, 3, 8}) {
    const Answers many = allFour(tool, spheres, place, threads);
    EXPECT_EQ(one.points, many.points);
    EXPECT_EQ(one.columns, many.columns);
    EXPECT_EQ(one.spheres, many.spheres);
    EXPECT_EQ(one.clouds, many.clouds);
  }
  // The finder too is equal to the bit.
  const BaseVectorField field(block(), {{"tooth", 1e4, 1, 1e9, 2000}}, sphereWindow(kVoxel));
  Detection d;
  d.area = cloudSolid(tool);
  CollisionFinder serial(1), parallel(3);
  const Collision& a = serial.find(field, {}, d, place);
  const Collision& b = parallel.find(field, {}, d, place);
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.voxels.size(), b.voxels.size());
}

TEST(Interference, NothingMeetsNothing) {
  const Cloud tool = test::ballCloud(kVoxel, 1, Vec3(4, 4, 4), 3);
  const SphereCloud one{{kVoxel * Vec3(4, 4, 4)}, {3 * kVoxel}, {}, {}};
  const Pose far{Eigen::Quaterniond::Identity(), kVoxel * Vec3(100, 0, 0)};
  const Answers a = allFour(tool, one, far, 1);
  EXPECT_TRUE(a.points.empty() && a.columns.empty() && a.spheres.empty() && a.clouds.empty());
  EXPECT_TRUE(interference(tool, {}, Cloud(), 1).empty());
  EXPECT_TRUE(interference(SphereCloud{}, {}, block(), 1).empty());
  Pose bad;
  bad.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(interference(tool, bad, block(), 1), std::invalid_argument);
  EXPECT_THROW(interference(SphereCloud{{Vec3::Zero()}, {-1}, {}, {}}, {}, block(), 1),
               std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact
