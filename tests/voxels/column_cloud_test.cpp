// Columns, as a Z-buffer stores them: exact where the surface crosses a column, and exact
// conversion of voxels and back.
#include <cloudcontact/voxels/column_cloud.h>

#include "objects/test_objects.h"

namespace cloudcontact::column_cloud_test {
namespace {

using namespace test;

TEST(Columns, ConvertBackToTheCloud) {
  for (const Cloud& cloud : {ballCloud(7), nutCloud(), twoMaterials()})
    for (int axis = 0; axis < 3; ++axis)
      for (const int perVoxel : {1, 4}) {
        const ColumnCloud columns = toColumns(cloud, axis, perVoxel);
        EXPECT_NO_THROW(validate(columns));
        expectSameVoxels(toCloud(columns, cloud.voxelSize()), cloud, 1);
      }
}

// A slab across the columns: one interval each, that ends where the slab does.
TEST(Columns, EndWhereTheBodyDoes) {
  const Vector3d low = kH * Vector3d(-6.3, -5.2, -3.17), high = kH * Vector3d(7.1, 6.9, 4.41);
  const Cloud cloud = digitized(boxMesh(low, high));
  for (const ColumnCloud& columns :
       {toColumns(cloud, 2, 4), toColumns(boxMesh(low, high), kH / 4)}) {
    int inside = 0;
    for (std::size_t c = 0; c + 1 < columns.first.size(); ++c) {
      const auto n = static_cast<std::size_t>(columns.columns[0]);
      const double u = columns.origin[0] + columns.width * (double(c % n) + 0.5),
                   v = columns.origin[1] + columns.width * (double(c / n) + 0.5);
      const double rim = 2 * kH;
      if (u < low[0] + rim || u > high[0] - rim || v < low[1] + rim || v > high[1] - rim) continue;
      ++inside;
      ASSERT_EQ(columns.first[c + 1] - columns.first[c], 1u);
      const ColumnInterval& only = columns.intervals[columns.first[c]];
      EXPECT_EQ(only.share, 1);
      // The resolution of a voxel is 1/510.
      EXPECT_NEAR(columns.origin[2] + only.low, low[2], 0.003 * kH);
      EXPECT_NEAR(columns.origin[2] + only.high, high[2], 0.003 * kH);
    }
    EXPECT_GT(inside, 1000);
  }
}

// Columns finer than their voxels follow the ball: copies of the voxels would be off by 0.1.
TEST(Columns, FollowTheSurfaceWithinAVoxel) {
  const double r = 9;
  const Cloud finer = toCloud(toColumns(ballCloud(r), 2, 4), kH / 4);
  EXPECT_LT(ballError(finer, r * kH, ballMiddle()), 0.015);
  const Cloud direct = toCloud(toColumns(ballMesh(r), kH / 4), kH);
  EXPECT_LT(ballError(direct, r * kH, ballMiddle()), 0.003);
}

TEST(Columns, KeepVolumeInVoxelsOfAnySize) {
  const Cloud cloud = nutCloud();
  const double volume = cloud.massProperties().volume;
  const ColumnCloud columns = toColumns(cloud, 1, 3);
  for (const double size : {0.5, 0.83, 1.0, 2.0, 3.7})
    EXPECT_NEAR(toCloud(columns, size * kH).massProperties().volume / volume, 1, 2e-3) << size;
}

TEST(Columns, SplitVoxelsInThree) {
  const Cloud cloud = ballCloud(8);
  const VoxelSplit split = splitVoxels(cloud);
  EXPECT_EQ(split.inside.size(), cloud.counts().inside);
  EXPECT_EQ(split.interface.size(), cloud.counts().interface);
  EXPECT_EQ(split.inside.size() + split.interface.size() + split.outside,
            static_cast<std::size_t>(cloud.size().prod()));
  for (const Vector3i& v : split.inside) {
    EXPECT_EQ(kindOf(cloud, v), VoxelKind::Inside);
    EXPECT_LT((cloud.center(v[0], v[1], v[2]) - ballMiddle()).norm(), 8 * kH);
  }
  for (const Vector3i& v : split.interface) {
    EXPECT_EQ(kindOf(cloud, v), VoxelKind::Interface);
    EXPECT_NEAR((cloud.center(v[0], v[1], v[2]) - ballMiddle()).norm(), 8 * kH, 0.9 * kH);
  }
  EXPECT_EQ(kindOf(cloud, {0, 0, 0}), VoxelKind::Outside);
}

TEST(Columns, RefuseBadInput) {
  const ColumnCloud good = toColumns(ballCloud(4), 2, 2);
  const auto refused = [&](auto change, const std::string& word) {
    ColumnCloud bad = good;
    change(bad);
    try {
      toCloud(bad, kH);
      ADD_FAILURE() << word << " was accepted";
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  };
  refused([](ColumnCloud& c) { c.axis = 3; }, "axis");
  refused([](ColumnCloud& c) { c.width = 0; }, "width");
  refused([](ColumnCloud& c) { c.width = INFINITY; }, "width");
  refused([](ColumnCloud& c) { c.origin[1] = NAN; }, "origin");
  refused([](ColumnCloud& c) { c.columns[0] = -1; }, "columns");
  refused([](ColumnCloud& c) { c.first.pop_back(); }, "first");
  refused([](ColumnCloud& c) { c.first[1] = c.intervals.size() + 1000; }, "first");
  refused([](ColumnCloud& c) { c.intervals[0].low = NAN; }, "low");
  refused([](ColumnCloud& c) { std::swap(c.intervals[0].low, c.intervals[0].high); }, "low");
  refused([](ColumnCloud& c) { c.intervals[0].share = 0; }, "share");
  refused([](ColumnCloud& c) { c.intervals[0].share = 1.5f; }, "share");
  refused([](ColumnCloud& c) { c.intervals[0].material = 1; }, "material");
  EXPECT_THROW(toCloud(good, 0), std::invalid_argument);
  EXPECT_THROW(toCloud(good, NAN), std::invalid_argument);
  EXPECT_THROW(toCloud(good, 1e-9), std::length_error);
  EXPECT_THROW(toColumns(ballCloud(4), 3, 2), std::invalid_argument);
  EXPECT_THROW(toColumns(ballCloud(4), 0, 0), std::invalid_argument);
  EXPECT_THROW(toCloud(toColumns(Cloud()), kH), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::column_cloud_test
