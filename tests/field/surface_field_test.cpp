// The field of a cloud compared with the true signed distance of the original solid: depth and
// normal within a voxel of the surface, and the positions, normals and areas of the samples.
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "field/field_cases.h"

namespace cloudcontact::testing::surface_field_test {
namespace {

constexpr double kVoxel = 1e-3;  // [m]

const BodyMaker kMaker{kVoxel, Random(21)};
constexpr int kClouds = 2;

class SurfaceFieldOf : public ::testing::TestWithParam<SolidCase> {};

TEST_P(SurfaceFieldOf, KnowsDepthAndNormalAwayFromEdges) {
  const FieldErrors e = fieldErrors(GetParam(), 4, 1e10, 1, kClouds, kMaker);
  ASSERT_GT(e.points, 300);
  EXPECT_EQ(e.missing, 0);
  // A force within 3 % of k d at a depth of 0.3 voxel allows a bias of 0.009 voxel.
  EXPECT_LE(std::abs(e.depthBias), 0.009);
  EXPECT_LE(e.depthMean, 0.02);
  EXPECT_LE(e.depthWorst, 0.1);
  // A voxel holds one plane with the surface's normal at the voxel's center. Points of the voxel
  // lie 0.383 voxel beside the center on average, half a diagonal at most, and the surface turns by
  // 1 / radius per voxel. The rest is the error of the fit.
  const double turn = 180 / std::numbers::pi / GetParam().radius;
  EXPECT_LE(e.normalMean, 0.383 * turn + 0.1);
  EXPECT_LE(e.normalWorst, 0.87 * turn + 1);
}

// Solids with edges.
class EdgedFieldOf : public SurfaceFieldOf {};

TEST_P(EdgedFieldOf, KnowsDepthAtEdgesFromInside) {
  const FieldErrors e = fieldErrors(GetParam(), 0, 3, 0, kClouds, kMaker);
  ASSERT_GT(e.points, 300);
  EXPECT_EQ(e.missing, 0);
  EXPECT_LE(std::abs(e.depthBias), 0.02);
  EXPECT_LE(e.depthMean, 0.05);
  // The error of a contact at an edge or corner may be 0.3 voxel, shared by two bodies.
  EXPECT_LE(e.depthWorst, 0.3);
}

// A field that claims material outside the solid creates false contacts; one that claims a gap
// inside lets corners penetrate.
TEST_P(SurfaceFieldOf, DistinguishesInsideFromOutside) {
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
    // The vector area of a closed surface is zero; otherwise uniform pressure moves the body.
    EXPECT_LE(sums.vectorArea.norm(), 2e-3 * GetParam().area);
    EXPECT_LE(sums.offMean, 0.02);
    EXPECT_LE(sums.offWorst, 0.3);
    EXPECT_LE(sums.normalMean, 0.5);
    // An error of a wall's force beside an edge would turn the contact force there.
    EXPECT_LE(std::abs(sums.stripWorst[1]), 0.1);
  }
}

TEST_P(SurfaceFieldOf, BoundsContainTheSolid) {
  BodyMaker maker{kVoxel, Random(23)};
  const SolidCase& one = GetParam();
  const Body body = one.make(maker);
  const Eigen::AlignedBox3d bounds = body.field->bounds();
  // The farthest points of the solid along the grid's axes, from the samples' positions.
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

std::vector<SolidCase> edgedCases() {
  std::vector<SolidCase> cases = solidCases();
  std::erase_if(cases, [](const SolidCase& one) { return one.name.starts_with("sphere"); });
  return cases;
}

std::string nameOf(const ::testing::TestParamInfo<SolidCase>& param) {
  return testName(param.param.name);
}

INSTANTIATE_TEST_SUITE_P(Solids, SurfaceFieldOf, ::testing::ValuesIn(solidCases()), nameOf);
INSTANTIATE_TEST_SUITE_P(Solids, EdgedFieldOf, ::testing::ValuesIn(edgedCases()), nameOf);

// An L, 24 x 20 x 14 voxels. At the ends of its inner edge, a concave edge and two convex ones meet
// in a vertex that no fit explains, as at the end of a thread.
constexpr double kLength = 24, kWidth = 20, kHeight = 14, kInnerX = 11, kInnerY = 9;

Mesh lMesh() {
  const Eigen::Vector2d outline[6] = {
      {0, 0}, {kLength, 0}, {kLength, kInnerY}, {kInnerX, kInnerY}, {kInnerX, kWidth}, {0, kWidth}};
  Mesh mesh;
  for (const double z : {0.0, kHeight})
    for (const Eigen::Vector2d& p : outline)
      mesh.vertices.push_back(kVoxel * Vec3(p.x(), p.y(), z));
  const int flat[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  for (const auto& t : flat) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
  }
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    mesh.triangles.push_back({k, next, next + 6});
    mesh.triangles.push_back({k, next + 6, k + 6});
  }
  return mesh;
}

// Distance to the nearest face from inside, or to the inner edge.
double trueDepthInL(const Vec3& p) {
  const double sides =
      std::min({p.x(), p.y(), p.z(), kLength - p.x(), kWidth - p.y(), kHeight - p.z()});
  return std::min(sides,
                  std::hypot(std::max(0.0, kInnerX - p.x()), std::max(0.0, kInnerY - p.y())));
}

// A voxel below the surface without a plane would count as deep inside, and a contact there would
// throw bodies apart.
TEST(SurfaceField, HasPlanesInAllVoxelsBelowTheSurface) {
  BodyMaker maker{kVoxel, Random(26)};
  for (int k = 0; k < 8; ++k) {
    const Body body = maker.cloud(lMesh());
    for (int drawn = 0; drawn < 60000; ++drawn) {
      const Vec3 at = maker.random.inCube().cwiseProduct(Vec3(kLength, kWidth, kHeight));
      const double truth = trueDepthInL(at);
      if (truth < 0.1 || truth > 1) continue;
      const auto found = body.field->at(body.grid.toWorld(at * kVoxel));
      ASSERT_TRUE(found) << "cloud " << k << ", " << truth << " voxels deep at " << at.transpose();
      ASSERT_LT(found->depth / kVoxel, truth + 1) << "cloud " << k << " at " << at.transpose();
    }
  }
}

// Depth below the nearest face of a box; outside it, above the farthest.
double trueDepthInBox(const Vec3& p, double edge) {
  return 0.5 * edge - p.cwiseAbs().maxCoeff();
}

// The edges of a box along the grid, whatever part of a voxel its faces fill. With two of these
// parts a quadric explains the edges as well as their planes do, and is 0.28 voxel off.
TEST(SurfaceField, FitsTheEdgesOfABoxOfAnySize) {
  BodyMaker maker{kVoxel, Random(27)};
  for (int part = 0; part < 60; ++part) {
    const double edge = 13 + part / 60.0;
    DigitizeSettings settings;
    settings.voxelSize = kVoxel;
    const auto field =
        SurfaceField::build(digitize(boxMesh(Vec3::Constant(edge * kVoxel)), settings));
    for (int drawn = 0; drawn < 2000; ++drawn) {
      // Within a voxel of an edge, or of a corner.
      Vec3 at = edge * (maker.random.inCube() - Vec3::Constant(0.5));
      const int along = drawn % 3;
      for (int axis = 0; axis < 3; ++axis)
        if (axis != along)
          at[axis] = std::copysign(0.5 * edge + 2 * maker.random.inCube().x() - 1, at[axis]);
      const double truth = trueDepthInBox(at, edge);
      if (std::abs(truth) > 0.5) continue;
      const auto found = field->at(at * kVoxel);
      ASSERT_TRUE(found) << "edge " << edge << " at " << at.transpose();
      ASSERT_NEAR(found->depth / kVoxel, truth, 0.01)
          << "edge " << edge << " at " << at.transpose();
    }
  }
}

TEST(SurfaceField, RejectsAnEmptyCloud) {
  EXPECT_THROW(SurfaceField::build(Cloud()), std::invalid_argument);
}

TEST(SurfaceField, HasNoPointFarOutside) {
  BodyMaker maker{kVoxel, Random(25)};
  const Body body = maker.box({12, 12, 12});
  EXPECT_FALSE(body.field->at(body.grid.toWorld(Vec3(0.05, 0, 0))).has_value());
  EXPECT_FALSE(body.field->at(body.grid.toWorld(Vec3(1e6, -1e6, 1e6))).has_value());
}

}  // namespace
}  // namespace cloudcontact::testing::surface_field_test
