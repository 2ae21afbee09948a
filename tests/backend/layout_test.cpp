// The structures that host and device share, and those that C++ names twice, byte by byte. A device
// is asked for its own layout as it is opened (kernels/layout.cl).
#include <gtest/gtest.h>

#include <cstddef>

#include "area_left.h"
#include "batch.h"
#include "contact/sums.h"
#include "matter_cut.h"

namespace cloudcontact {
namespace {

TEST(Layout, BatchStructures) {
  EXPECT_EQ(sizeof(CcField), 96u);
  EXPECT_EQ(offsetof(CcField, samples), 36u);
  EXPECT_EQ(offsetof(CcField, bricks), 84u);
  EXPECT_EQ(sizeof(CcWay), 204u);
  EXPECT_EQ(sizeof(CcDirection), 228u);
  EXPECT_EQ(offsetof(CcDirection, hits), 212u);
  EXPECT_EQ(sizeof(CcTerms), 240u);
  EXPECT_EQ(sizeof(CcPair), 264u);
  EXPECT_EQ(offsetof(CcPair, enough), 252u);
  EXPECT_EQ(sizeof(CcFound), 20u);
  EXPECT_EQ(sizeof(CcAnswer), 36u);
  EXPECT_EQ(sizeof(CcBin), 32u);
  EXPECT_EQ(sizeof(CcSprout), 112u);
  EXPECT_EQ(sizeof(CcPatchForce), 104u);
  EXPECT_EQ(sizeof(CcContactPatch), 368u);
  EXPECT_EQ(offsetof(CcContactPatch, points), 136u);
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

// Sums is CcSums under C++'s names (plugin/contact/sums.cpp).
TEST(Layout, SumsAreTheKernels) {
  static_assert(sizeof(Sums) == sizeof(CcSums));
  static_assert(sizeof(SideSums) == sizeof(CcSideSums));
  EXPECT_EQ(sizeof(CcSums), 632u);
  EXPECT_EQ(offsetof(SideSums, size), offsetof(CcSideSums, size));
  EXPECT_EQ(offsetof(SideSums, depth), offsetof(CcSideSums, depth));
  EXPECT_EQ(offsetof(Sums, side), offsetof(CcSums, side));
  EXPECT_EQ(offsetof(Sums, area), offsetof(CcSums, area));
  EXPECT_EQ(offsetof(Sums, first), offsetof(CcSums, first));
  EXPECT_EQ(offsetof(Sums, second), offsetof(CcSums, second));
  EXPECT_EQ(offsetof(Sums, normal), offsetof(CcSums, normal));
  EXPECT_EQ(offsetof(Sums, normalBy), offsetof(CcSums, normalBy));
  EXPECT_EQ(offsetof(Sums, place), offsetof(CcSums, place));
  EXPECT_EQ(offsetof(Sums, middle), offsetof(CcSums, middle));
  EXPECT_EQ(offsetof(Sums, apart), offsetof(CcSums, apart));
  EXPECT_EQ(offsetof(Sums, opening), offsetof(CcSums, opening));
  EXPECT_EQ(offsetof(Sums, deepest), offsetof(CcSums, deepest));
  EXPECT_EQ(offsetof(Sums, deep), offsetof(CcSums, deep));
  EXPECT_EQ(offsetof(Sums, hits), offsetof(CcSums, hits));
}

// A vector in a register of four doubles lies as the array that it is copied to.
TEST(Layout, WhatIsAddedUp) {
  EXPECT_EQ(sizeof(CcFour), 32u);
  EXPECT_EQ(offsetof(CcAdding, middle), offsetof(CcAdded, middle));
  EXPECT_EQ(offsetof(CcAdding, powers), offsetof(CcAdded, powers));
  EXPECT_EQ(offsetof(CcAdding, wallOther), offsetof(CcAdded, wallOther));
}

}  // namespace
}  // namespace cloudcontact
