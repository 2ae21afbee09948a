// Collision voxels of two clouds: those of a search through all voxels, for tools of any size and
// any number of threads.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/cloud_solid.h>
#include <cloudcontact/workpiece/collision_finder.h>
#include <cloudcontact/workpiece/interference.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "voxels/small_clouds.h"

namespace cloudcontact::interference_test {
namespace {

constexpr double kVoxel = 1e-3;  // [m]
using Voxels = std::vector<VoxelIndex>;

Cloud block() {
  return test::smallCloud(kVoxel, {4, 4, 4}, [](int x, int y, int z) {
    return std::min({x, y, z}) >= 2 && std::max({x, y, z}) < 28 ? 255 : 0;
  });
}
// A bent wire with partly covered voxels, and another voxel size.
Cloud wire() {
  return test::smallCloud(0.7 * kVoxel, {4, 2, 1}, [](int x, int y, int z) {
    return std::abs(y - 4 - x / 4) <= 1 && z < 2 ? 255 - 20 * (x % 8) : 0;
  });
}

// The definition, voxel by voxel.
Voxels allInside(const Cloud& tool, const Pose& place, const Cloud& work) {
  Voxels found;
  for (int z = 0; z < work.size().z(); ++z)
    for (int y = 0; y < work.size().y(); ++y)
      for (int x = 0; x < work.size().x(); ++x) {
        if (work.coverage(x, y, z) == 0) continue;
        const Vec3 p = (place.toLocal(work.center(x, y, z)) - tool.origin()) / tool.voxelSize();
        const Eigen::Vector3i v = p.array().floor().cast<int>();
        if (tool.coverage(v.x(), v.y(), v.z()) >= 128) found.emplace_back(x, y, z);
      }
  return found;
}

Pose randomPose(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Pose pose;
  pose.orientation =
      Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized();
  pose.position =
      kVoxel * (Vec3::Constant(12) + 16 * Vec3(unit(random), unit(random), unit(random)));
  return pose;
}

// A wire in a block walks the tool, a block in a wire the workpiece; a ball in a block depends on
// where it is.
TEST(Interference, FindsWhatASearchThroughAllVoxelsFinds) {
  const Cloud large = block(), thin = wire();
  const Cloud ball = test::ballCloud(kVoxel, 3, Vec3(12, 12, 12), 9.3);
  const std::pair<const Cloud*, const Cloud*> pairs[] = {
      {&thin, &large}, {&large, &thin}, {&ball, &large}, {&large, &ball}, {&ball, &ball}};
  std::mt19937 random(7);
  for (const auto& [tool, work] : pairs) {
    std::size_t touching = 0, apart = 0;
    for (int k = 0; k < 60; ++k) {
      const Pose place = randomPose(random);
      const Voxels truth = allInside(*tool, place, *work);
      ASSERT_EQ(interference(*tool, place, *work), truth);
      ++(truth.empty() ? apart : touching);
    }
    EXPECT_GT(touching, 10u);
    EXPECT_GT(apart, 3u);
  }
}

// A box of 6x5x4 voxels, along the grid: 3 of its 4 layers are in the block.
TEST(Interference, ABoxAlongTheGrid) {
  const Cloud tool = test::smallCloud(
      kVoxel, {1, 1, 1}, [](int x, int y, int z) { return x < 6 && y < 5 && z < 4 ? 255 : 0; });
  const Pose place{Eigen::Quaterniond::Identity(), kVoxel * Vec3(10, 11, 25)};
  const Voxels found = interference(tool, place, block());
  ASSERT_EQ(found.size(), 6u * 5 * 3);
  EXPECT_EQ(found.front(), VoxelIndex(10, 11, 25));
  EXPECT_EQ(found.back(), VoxelIndex(15, 15, 27));
}

// The digital normal of a ball's voxels is that of the ball as an area, within a degree.
TEST(Interference, GivesTheDigitalNormalOfABall) {
  const double radius = 9.317;
  const Cloud tool = test::ballCloud(kVoxel, 3, Vec3(12, 12, 12), radius);
  Pose place{Eigen::Quaterniond(0.8, 0.1, -0.3, 0.5).normalized(), Vec3::Zero()};
  place.position =
      kVoxel * Vec3(15.2, 14.7, 33.1) - place.orientation * (kVoxel * Vec3(12, 12, 12));
  const BaseVectorField field(block(), {{"tooth", 1e4, 1, 1e9, 2000}}, sphereWindow(kVoxel));
  Detection d;
  d.area = {Sphere{radius * kVoxel}, {.position = kVoxel * Vec3(12, 12, 12)}};
  CollisionFinder finder;
  const Vec3 normal = finder.find(field, {}, d, place).normal();
  const double depth = finder.find(field, {}, d, place).depth;
  EXPECT_NEAR(depth, 4.2 * kVoxel, 0.2 * kVoxel);
  EXPECT_LT(std::acos(normal.z()) * 57.3, 1);
  const Voxels found = interference(tool, place, block());
  const Collision& c = finder.gather(field, {}, d, place, found);
  EXPECT_EQ(c.voxels.size(), found.size());
  EXPECT_LT(std::acos(std::min(1.0, c.normal().dot(normal))) * 57.3, 1);
  EXPECT_NEAR(c.stiffness, 1e4, 1e-6);
}

TEST(Interference, InSequenceAndInParallelTheSame) {
  const Cloud tool = test::ballCloud(kVoxel, 3, Vec3(12, 12, 12), 9.3);
  const Pose place{Eigen::Quaterniond(0.8, 0.1, -0.3, 0.5).normalized(), kVoxel * Vec3(9, 5, 11)};
  const Voxels one = interference(tool, place, block(), 1);
  ASSERT_GT(one.size(), 300u);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(one, interference(tool, place, block(), threads));
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
  for (const double far : {0.1, 1e6, -1e12, 1e300})
    EXPECT_TRUE(
        interference(tool, {Eigen::Quaterniond::Identity(), Vec3(far, 0, 0)}, block()).empty());
  EXPECT_TRUE(interference(tool, {}, Cloud()).empty());
  EXPECT_TRUE(interference(Cloud(), {}, block()).empty());
  Pose bad;
  bad.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(interference(tool, bad, block()), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::interference_test
