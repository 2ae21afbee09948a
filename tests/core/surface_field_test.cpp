// The field of a cloud against the true signed distance of the solid it was made of: depth and
// normal within a voxel of the surface, and the samples' places, normals and areas.
#include <cloudcontact/surface_field.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "field_cases.h"

namespace cloudcontact::testing {
namespace {

constexpr double kVoxel = 1e-3;  // [m]

const BodyMaker kMaker{kVoxel, Random(21)};
constexpr int kClouds = 2;

class SurfaceFieldOf : public ::testing::TestWithParam<SolidCase> {};

TEST_P(SurfaceFieldOf, KnowsDepthAndNormalAwayFromEdges) {
  const FieldErrors e = fieldErrors(GetParam(), 4, 1e10, 1, kClouds, kMaker);
  ASSERT_GT(e.points, 300);
  EXPECT_EQ(e.missing, 0);
  // A force within 3 % of k d at 0.3 voxel leaves 0.009 voxel for what does not average out.
  EXPECT_LE(std::abs(e.depthBias), 0.009);
  EXPECT_LE(e.depthMean, 0.02);
  EXPECT_LE(e.depthWorst, 0.1);
  // A voxel holds one plane, whose normal is the surface's at the voxel's middle: a point of it is
  // 0.383 voxel sideways of that in the mean, half the diagonal at worst, on a surface that turns
  // by 1 / radius a voxel. The rest is the fit's own error.
  const double turn = 180 / std::numbers::pi / GetParam().radius;
  EXPECT_LE(e.normalMean, 0.383 * turn + 0.1);
  EXPECT_LE(e.normalWorst, 0.87 * turn + 1);
}

TEST_P(SurfaceFieldOf, KnowsDepthAtEdgesFromInside) {
  if (GetParam().name.rfind("sphere", 0) == 0) GTEST_SKIP() << "a sphere has no edges";
  const FieldErrors e = fieldErrors(GetParam(), 0, 3, 0, kClouds, kMaker);
  ASSERT_GT(e.points, 300);
  EXPECT_EQ(e.missing, 0);
  EXPECT_LE(std::abs(e.depthBias), 0.02);
  EXPECT_LE(e.depthMean, 0.05);
  // An edge or a corner pressed into a face may be 0.3 voxel off (issue 2); two bodies share it.
  EXPECT_LE(e.depthWorst, 0.3);
}

// A field that claims material outside the solid makes a contact where nothing touches, however
// seldom; one that claims a gap inside lets a corner in.
TEST_P(SurfaceFieldOf, KnowsInsideFromOutside) {
  const FieldSides sides = fieldSides(GetParam(), kClouds, kMaker);
  ASSERT_GT(sides.outside, 1000);
  ASSERT_GT(sides.inside, 1000);
  EXPECT_LE(sides.falseOverlap, kSideSlack) << sides.falseOutside << " points of " << sides.outside;
  EXPECT_GE(sides.falseGap, -kSideSlack) << sides.falseInside << " points of " << sides.inside;
}

TEST_P(SurfaceFieldOf, SamplesCoverTheSurface) {
  BodyMaker maker{kVoxel, Random(22)};
  for (int k = 0; k < kClouds; ++k) {
    const SampleSums sums = sampleSums(GetParam(), GetParam().make(maker));
    EXPECT_NEAR(sums.area, GetParam().area, 0.01 * GetParam().area);
    EXPECT_NEAR(sums.volume, GetParam().volume, 0.01 * GetParam().volume);
    // A closed surface's vector area is zero: else a body under pressure from all sides moves.
    EXPECT_LE(sums.vectorArea.norm(), 2e-3 * GetParam().area);
    EXPECT_LE(sums.offMean, 0.02);
    EXPECT_LE(sums.offWorst, 0.3);
    EXPECT_LE(sums.normalMean, 0.5);
    // A wall's push beside its edge bends a contact's force over that edge.
    EXPECT_LE(std::abs(sums.stripWorst[1]), 0.1);
  }
}

TEST_P(SurfaceFieldOf, BoundsHoldTheSolid) {
  BodyMaker maker{kVoxel, Random(23)};
  const SolidCase& one = GetParam();
  const Body body = one.make(maker);
  const Eigen::AlignedBox3d bounds = body.field->bounds();
  // The farthest point of the solid along each axis of the grid, found by the samples' own places.
  Eigen::AlignedBox3d reached;
  for (std::size_t k = 0; k < body.field->sampleCount(); ++k) {
    const SurfaceSample s = body.field->sample(k);
    reached.extend(body.field->cloud().origin() +
                   kVoxel * Eigen::Map<const Eigen::Vector3f>(s.position).cast<double>());
  }
  const Vec3 slack = Vec3::Constant(1e-6 * kVoxel);
  EXPECT_TRUE(((bounds.min() - slack).array() <= reached.min().array()).all());
  EXPECT_TRUE(((bounds.max() + slack).array() >= reached.max().array()).all());
  EXPECT_LE((bounds.min() - reached.min()).cwiseAbs().maxCoeff(), 2 * kVoxel);
  EXPECT_LE((bounds.max() - reached.max()).cwiseAbs().maxCoeff(), 2 * kVoxel);
}

INSTANTIATE_TEST_SUITE_P(Solids, SurfaceFieldOf, ::testing::ValuesIn(solidCases()),
                         [](const ::testing::TestParamInfo<SolidCase>& param) {
                           return testName(param.param.name);
                         });

TEST(SurfaceField, RefusesAnEmptyCloud) {
  EXPECT_THROW(SurfaceField::build(Cloud()), std::invalid_argument);
}

TEST(SurfaceField, KnowsNothingFarOutside) {
  BodyMaker maker{kVoxel, Random(25)};
  const Body body = maker.box({12, 12, 12});
  EXPECT_FALSE(body.field->at(body.grid.toWorld(Vec3(0.05, 0, 0))).has_value());
  EXPECT_FALSE(body.field->at(body.grid.toWorld(Vec3(1e6, -1e6, 1e6))).has_value());
}

}  // namespace
}  // namespace cloudcontact::testing
