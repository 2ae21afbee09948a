// The layout of structures that host and device share. Opening a device checks its own layout
// (kernels/contact/layout.cl).
#include <gtest/gtest.h>

#include <cstddef>

#include "kernels/contact/batch_layout.h"
#include "kernels/cut/area_left.h"
#include "kernels/cut/digital_normal.h"
#include "kernels/cut/matter_cut.h"

namespace cloudcontact::layout_test {
namespace {

TEST(Layout, OfDigitalNormals) {
  EXPECT_EQ(offsetof(CcTouchedVoxel, share), 8u);
  EXPECT_EQ(sizeof(CcTouchedVoxel), 16u);
  EXPECT_EQ(offsetof(CcNormalSum, vector), 16u);
  EXPECT_EQ(offsetof(CcNormalSum, plain), 40u);
  EXPECT_EQ(sizeof(CcNormalSum), 64u);
}

TEST(Layout, BatchStructures) {
  EXPECT_EQ(sizeof(CcField), 108u);
  EXPECT_EQ(offsetof(CcField, samples), 36u);
  EXPECT_EQ(offsetof(CcField, bricks), 96u);
  EXPECT_EQ(sizeof(CcWay), 204u);
  EXPECT_EQ(sizeof(CcDirection), 228u);
  EXPECT_EQ(offsetof(CcDirection, hits), 212u);
  EXPECT_EQ(sizeof(CcTerms), 304u);
  EXPECT_EQ(sizeof(CcPair), 784u);
  EXPECT_EQ(offsetof(CcPair, enough), 316u);
  EXPECT_EQ(offsetof(CcPair, ways), 328u);
  EXPECT_EQ(offsetof(CcResults, answers), 16u);
  EXPECT_EQ(sizeof(CcFound), 20u);
  EXPECT_EQ(sizeof(CcAnswer), 36u);
  EXPECT_EQ(sizeof(CcBin), 32u);
  EXPECT_EQ(sizeof(CcSprout), CC_SPROUT_NUMBERS * sizeof(double));
  EXPECT_EQ(offsetof(CcSprout, size), 6 * sizeof(double));
  EXPECT_EQ(offsetof(CcSprout, area), 8 * sizeof(double));
  EXPECT_EQ(offsetof(CcSprout, first), 9 * sizeof(double));
  EXPECT_EQ(offsetof(CcSprout, origin), 12 * sizeof(double));
  EXPECT_EQ(sizeof(CcPatchForce), 104u);
  EXPECT_EQ(sizeof(CcContactPatch), 512u);
  EXPECT_EQ(offsetof(CcContactPatch, points), 144u);
  EXPECT_EQ(sizeof(CcVoxel), 8u);
}

TEST(Layout, CuttingStructures) {
  EXPECT_EQ(sizeof(CcCutting), 44u);
  EXPECT_EQ(sizeof(CcVoxelLeft), 8u);
  EXPECT_EQ(offsetof(CcVoxelLeft, left), 6u);
  EXPECT_EQ(sizeof(CcArea), 152u);
  EXPECT_EQ(offsetof(CcArea, turn), 32u);
  EXPECT_EQ(offsetof(CcArea, middle), 104u);
  EXPECT_EQ(sizeof(CcFlatRun), 16u);
  EXPECT_EQ(sizeof(CcBlock), 42u * CC_BRICK_VOXELS);
  EXPECT_EQ(offsetof(CcBlock, volume), 32u * CC_BRICK_VOXELS);
}

// Offsets in CcSums, in doubles.
TEST(Layout, PlacesInSums) {
  const auto at = [](std::size_t bytes) { return bytes / sizeof(double); };
  EXPECT_EQ(sizeof(CcSums), 632u);
  EXPECT_EQ(at(sizeof(CcSums)), std::size_t{CC_SUMS_NUMBERS});
  EXPECT_EQ(at(sizeof(CcSideSums)), std::size_t{CC_SIDE_NUMBERS});
  EXPECT_EQ(at(offsetof(CcSums, side)), std::size_t{CC_SIDES});
  EXPECT_EQ(at(offsetof(CcSideSums, moment)), std::size_t{CC_MOMENT});
  EXPECT_EQ(at(offsetof(CcSideSums, wall)), std::size_t{CC_WALL});
  EXPECT_EQ(at(offsetof(CcSideSums, size)), std::size_t{CC_SIZE});
  EXPECT_EQ(at(offsetof(CcSideSums, depth)), std::size_t{CC_DEPTHS});
  EXPECT_EQ(at(offsetof(CcSums, area)), std::size_t{CC_AREA});
  EXPECT_EQ(at(offsetof(CcSums, width)), std::size_t{CC_WIDTH});
  EXPECT_EQ(at(offsetof(CcSums, facing)), std::size_t{CC_PRESSED});
  EXPECT_EQ(at(offsetof(CcSums, first)), std::size_t{CC_FIRST});
  EXPECT_EQ(at(offsetof(CcSums, second)), std::size_t{CC_SECOND});
  EXPECT_EQ(at(offsetof(CcSums, normal)), std::size_t{CC_NORMALS});
  EXPECT_EQ(at(offsetof(CcSums, normalBy)), std::size_t{CC_NORMALS_BY});
  EXPECT_EQ(at(offsetof(CcSums, place)), std::size_t{CC_PLACES});
  EXPECT_EQ(at(offsetof(CcSums, middle)), std::size_t{CC_MIDDLE});
  EXPECT_EQ(at(offsetof(CcSums, apart)), std::size_t{CC_APART});
  EXPECT_EQ(at(offsetof(CcSums, opening)), std::size_t{CC_OPENING});
  EXPECT_EQ(at(offsetof(CcSums, deepest)), std::size_t{CC_DEEPEST});
  EXPECT_EQ(at(offsetof(CcSums, deep)), std::size_t{CC_DEEP_PRESSED});
  EXPECT_EQ(at(offsetof(CcSums, hits)), std::size_t{CC_HITS});
}

// Vectors of four doubles lie where the arrays lie that they are copied to.
TEST(Layout, AddingMatchesAdded) {
  EXPECT_EQ(sizeof(CcFour), 32u);
  EXPECT_EQ(offsetof(CcAdding, middle), offsetof(CcAdded, middle));
  EXPECT_EQ(offsetof(CcAdding, powers), offsetof(CcAdded, powers));
  EXPECT_EQ(offsetof(CcAdding, wallOther), offsetof(CcAdded, wallOther));
}

}  // namespace
}  // namespace cloudcontact::layout_test
