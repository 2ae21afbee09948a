// Clouds with larger voxels: sums of the finer ones to the last bit, and the same body.
#include <cloudcontact/voxels/coarser_cloud.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <cmath>

#include "contact/contact_cases.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::test::coarser_cloud_test {
namespace {

// Of the fine voxels in a box [fine voxels].
struct Block {
  int sum = 0, voxels = 0;
  int byMaterial[3] = {0, 0, 0};
};

Block blockOf(const Cloud& fine, const Eigen::Vector3i& from, int edge) {
  Block block;
  for (int z = from.z(); z < from.z() + edge; ++z)
    for (int y = from.y(); y < from.y() + edge; ++y)
      for (int x = from.x(); x < from.x() + edge; ++x) {
        block.sum += fine.coverage(x, y, z);
        block.byMaterial[fine.material(x, y, z)] += fine.coverage(x, y, z);
        ++block.voxels;
      }
  return block;
}

// Coverage without any order, with solid and empty bricks between.
int rough(int x, int y, int z) {
  if (x >= 8 && x < 16 && y < 16 && z < 16) return 255;
  if (x >= 16 && y < 8) return 0;
  return (x * 73 + y * 151 + z * 211 + x * y * 7 + y * z * 13) % 256;
}

TEST(CoarserCloud, HoldsTheSumsOfTheFinerVoxels) {
  const Cloud fine = smallCloud(1e-3, {3, 3, 3}, rough, {"a", "b", "c"},
                                [](int x, int y, int z) { return (x / 3 + y / 5 + z / 2) % 3; });
  for (int halvings = 1; halvings <= 4; ++halvings) {
    const int edge = 1 << halvings;
    const Cloud coarse = coarserCloud(fine, halvings);
    EXPECT_DOUBLE_EQ(coarse.voxelSize(), edge * 1e-3);
    const Vec3 shift = (coarse.origin() - fine.origin()) / fine.voxelSize();
    const Eigen::Vector3i first = shift.array().round().cast<int>();
    EXPECT_LT((shift - first.cast<double>()).norm(), 1e-9);
    EXPECT_EQ(first.x() % edge, 0) << "made of whole voxels of each finer level";
    for (int z = 0; z < coarse.size().z(); ++z)
      for (int y = 0; y < coarse.size().y(); ++y)
        for (int x = 0; x < coarse.size().x(); ++x) {
          const Block block = blockOf(fine, first + edge * Eigen::Vector3i(x, y, z), edge);
          const double mean = double(block.sum) / block.voxels;
          ASSERT_LE(std::abs(coarse.coverage(x, y, z) - mean), 0.5);
          if (coarse.coverage(x, y, z) == 0) continue;
          const int material = coarse.material(x, y, z);
          for (const int other : block.byMaterial) ASSERT_GE(block.byMaterial[material], other);
        }
  }
}

// Halves go to even, so that they go up as often as down.
TEST(CoarserCloud, RoundsHalvesToEven) {
  for (const int part : {1, 2, 3, 4}) {
    const Cloud fine = smallCloud(1, {1, 1, 1}, [part](int x, int y, int z) {
      return x / 2 * 2 == x && y % 2 + z % 2 == 0 ? 8 * part - 4 : 0;  // 1/8: part - 1/2
    });
    const Cloud coarse = coarserCloud(fine);
    EXPECT_EQ(coarse.coverage(2, 2, 2), part / 2 * 2) << part;
  }
}

TEST(CoarserCloud, KeepsVolumeAndCenter) {
  const double voxel = 1e-3;
  DigitizeSettings how;
  how.voxelSize = voxel;
  how.threads = 1;
  const Cloud fine =
      digitize(testing::transformed(
                   testing::boxMesh({0.061, 0.047, 0.033}),
                   Pose{Eigen::Quaterniond(0.8, 0.3, 0.4, 0.33).normalized(), Vec3::Zero()}),
               how);
  const MassProperties truth = fine.massProperties();
  for (int halvings = 1; halvings <= 3; ++halvings) {
    const Cloud coarse = coarserCloud(fine, halvings);
    const MassProperties found = coarse.massProperties();
    const double bound = double(coarse.counts().interface) / 510 * std::pow(coarse.voxelSize(), 3);
    EXPECT_LE(std::abs(found.volume - truth.volume), bound);
    EXPECT_LE(std::abs(found.volume - truth.volume), 1e-4 * truth.volume);
    EXPECT_LT((found.centerOfMass - truth.centerOfMass).norm(), 0.01 * voxel);
  }
}

TEST(CoarserCloud, LeavesTwoEmptyVoxelsAround) {
  const Cloud fine = smallCloud(1, {2, 1, 1}, [](int, int, int) { return 255; });
  for (int halvings = 1; halvings <= 5; ++halvings) {
    const Cloud coarse = coarserCloud(fine, halvings);
    for (int k = 0; k < coarse.size().x(); ++k)
      for (int j = 0; j < 2; ++j) {
        EXPECT_EQ(coarse.coverage(k, 3, j), 0);
        EXPECT_EQ(coarse.coverage(k, 3, coarse.size().z() - 1 - j), 0);
      }
  }
}

TEST(CoarserCloud, RefusesWhatIsNoHalving) {
  const Cloud fine = smallCloud(1, {1, 1, 1}, [](int, int, int) { return 255; });
  EXPECT_THROW(coarserCloud(fine, -1), std::invalid_argument);
  EXPECT_THROW(coarserCloud(fine, 11), std::invalid_argument);
  EXPECT_EQ(&coarserCloud(fine, 0).voxels(), &fine.voxels());
}

}  // namespace
}  // namespace cloudcontact::test::coarser_cloud_test
