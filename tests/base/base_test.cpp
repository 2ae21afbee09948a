// The order of cells in grids and bricks, and the hash against its published values.
#include <gtest/gtest.h>

#include <cstring>

#include "base/byte_archive.h"
#include "base/grid_index.h"
#include "base/hash.h"

namespace cloudcontact::base_test {
namespace {

TEST(GridIndex, RunsWithXFastestAndBack) {
  const Eigen::Vector3i size(3, 4, 5);
  std::size_t index = 0;
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 3; ++x, ++index) {
        EXPECT_EQ(gridIndex(x, y, z, size), index);
        EXPECT_EQ(gridCell(index, size), Eigen::Vector3i(x, y, z));
        EXPECT_TRUE(insideGrid(x, y, z, size));
      }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_FALSE(insideGrid(-Eigen::Vector3i::Unit(axis), size));
    EXPECT_FALSE(insideGrid(size[axis] * Eigen::Vector3i::Unit(axis), size));
  }
}

TEST(GridIndex, DividesVoxelsIntoBricksAndCells) {
  const Eigen::Vector3i bricks(2, 3, 2);
  for (const Eigen::Vector3i& voxel : {Eigen::Vector3i(0, 0, 0), Eigen::Vector3i(15, 23, 15),
                                       Eigen::Vector3i(7, 8, 9), Eigen::Vector3i(12, 5, 10)}) {
    const Eigen::Vector3i brick = gridCell(brickIndex(voxel, bricks), bricks);
    EXPECT_EQ(Eigen::Vector3i(8 * brick + cellOffset(cellIndex(voxel))), voxel);
  }
  EXPECT_EQ(cellIndex(1, 2, 3), 1 + 8 * (2 + 8 * 3));
  EXPECT_EQ(cellIndex(-1, -2, -3), cellIndex(7, 6, 5));
}

TEST(Fnv1a, HasItsPublishedValues) {
  const auto hashOf = [](const char* text) {
    Fnv1a hash;
    hash.add(text, std::strlen(text));
    return hash.value();
  };
  EXPECT_EQ(hashOf(""), 0xCBF29CE484222325u);
  EXPECT_EQ(hashOf("a"), 0xAF63DC4C8601EC8Cu);
  EXPECT_EQ(hashOf("foobar"), 0x85944171F73967E8u);
}

// A record that says more items than it holds makes those that it holds, and one more.
TEST(ByteArchive, MakesNoItemsThatAreNotThere) {
  struct Item {
    double number = 0;
  };
  int made = 0;
  ByteWriter writer;
  writer(std::uint64_t{80});
  for (int i = 0; i < 10; ++i) writer(double(i));
  ByteReader reader(writer.bytes());
  std::vector<Item> items;
  const auto visit = [&](ByteReader& a, Item& item) {
    ++made;
    a(item.number);
  };
  EXPECT_THROW(listIn(reader, items, visit), std::runtime_error);
  EXPECT_EQ(made, 11);
  EXPECT_EQ(items.size(), 11u);
  EXPECT_EQ(items[9].number, 9);
}

// A byte that is neither 0 nor 1 is no bool: to load one from it is undefined.
TEST(ByteArchive, RefusesFlagsThatAreNone) {
  const char bytes[] = {1, 0, 64};
  ByteReader reader(bytes);
  bool one = false, other = true;
  reader(one, other);
  EXPECT_TRUE(one);
  EXPECT_FALSE(other);
  EXPECT_THROW(reader(one), std::runtime_error);
}

}  // namespace
}  // namespace cloudcontact::base_test
