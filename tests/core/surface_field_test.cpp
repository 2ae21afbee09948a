// The field of a cloud against the true signed distance of the solid it was made of: depth and
// normal within a voxel of the surface, and the samples' places, normals and areas.
#include <cloudcontact/surface_field.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact_cases.h"

namespace cloudcontact::testing {
namespace {

constexpr double kVoxel = 1e-3;  // [m]

// What is true at a point of the solid's frame, in voxels.
struct True {
  double depth;
  Vec3 normal;
  double toEdge;  // distance to the nearest edge: infinite on a sphere
};
using Solid = std::function<True(const Vec3&)>;

True trueSphere(double radius, const Vec3& p) {
  return {radius - p.norm(), p.normalized(), 1e9};
}

// Beside faces only, where every definition of distance agrees; inside it holds at edges too.
True trueBox(const Vec3& half, const Vec3& p) {
  const Vec3 depths = half - p.cwiseAbs();
  int axis = 0;
  const double depth = depths.minCoeff(&axis);
  double second = 1e9;
  for (int k = 0; k < 3; ++k) {
    if (k != axis) second = std::min(second, depths[k]);
  }
  return {depth, Vec3::Unit(axis) * (p[axis] < 0 ? -1.0 : 1.0), second};
}

True trueCylinder(double radius, double half, const Vec3& p) {
  const double across = std::hypot(p.x(), p.y());
  const double side = radius - across, cap = half - std::abs(p.z());
  if (cap < side) return {cap, Vec3::UnitZ() * (p.z() < 0 ? -1.0 : 1.0), side};
  return {side, Vec3(p.x(), p.y(), 0) / across, cap};
}

struct Case {
  std::string name;
  std::function<Body(BodyMaker&)> make;
  Solid truth;
  Vec3 half;  // of the bounds [voxels]
  double area, volume;
  double radius = 1e9;  // of curvature
  double deepest = 1;   // below this depth no face is nearer than the other
};

// How gtest names a case in a failure.
void PrintTo(const Case& one, std::ostream* out) {
  *out << one.name;
}

std::vector<Case> cases() {
  const double pi = std::numbers::pi;
  std::vector<Case> all;
  for (const double r : {10.0, 16.0, 40.0}) {
    all.push_back({"sphere" + std::to_string(std::lround(r)),
                   [r](BodyMaker& make) { return make.sphere(r); },
                   [r](const Vec3& p) { return trueSphere(r, p); }, Vec3::Constant(r),
                   4 * pi * r * r, 4 * pi / 3 * r * r * r, r});
    all.push_back({"cylinder" + std::to_string(std::lround(r)),
                   [r](BodyMaker& make) { return make.cylinder(r, 30); },
                   [r](const Vec3& p) { return trueCylinder(r, 15, p); }, Vec3(r, r, 15),
                   2 * pi * r * (r + 30), pi * r * r * 30, r});
  }
  for (const auto& [name, aligned, z] : {std::tuple{"box", false, 20.6},
                                         {"box-aligned", true, 20.6},
                                         {"plate3", false, 3.0},
                                         {"plate2", false, 2.0}}) {
    const Vec3 edges(26.3, 31.2, z);
    const bool alongAxes = aligned;
    all.push_back({name, [=](BodyMaker& make) { return make.box(edges, alongAxes); },
                   [=](const Vec3& p) { return trueBox(edges / 2, p); }, edges / 2,
                   2 * (edges.x() * edges.y() + edges.y() * edges.z() + edges.z() * edges.x()),
                   edges.prod(), 1e9, std::min(1.0, edges.z() / 2 - 0.2)});
  }
  return all;
}

// In voxels and degrees.
struct FieldErrors {
  double depthBias = 0, depthMean = 0, depthWorst = 0, normalMean = 0, normalWorst = 0;
  int points = 0, missing = 0;
};

void compareAt(FieldErrors& errors, const Body& body, const Vec3& solidPoint, const True& truth) {
  const auto found = body.field->at(body.grid.toWorld(solidPoint * kVoxel));
  if (!found) {
    ++errors.missing;
    return;
  }
  const double depth = found->depth / kVoxel - truth.depth;
  const Vec3 normal = body.grid.orientation * truth.normal;
  const double degrees = std::atan2(normal.cross(found->normal).norm(), normal.dot(found->normal)) *
                         180 / std::numbers::pi;
  ++errors.points;
  errors.depthBias += depth;
  errors.depthMean += std::abs(depth);
  errors.depthWorst = std::max(errors.depthWorst, std::abs(depth));
  errors.normalMean += degrees;
  errors.normalWorst = std::max(errors.normalWorst, degrees);
}

// At points within a voxel of the surface, away from edges by `least` to `most` voxels.
FieldErrors fieldErrors(const Case& one, double least, double most, double outermost) {
  BodyMaker maker{kVoxel, Random(21)};
  FieldErrors errors;
  for (int k = 0; k < 2; ++k) {
    const Body body = one.make(maker);
    for (int drawn = 0; drawn < 20000; ++drawn) {
      const Vec3 at =
          (2 * maker.random.inCube() - Vec3::Ones()).cwiseProduct(one.half + Vec3::Constant(1.5));
      const True truth = one.truth(at);
      if (truth.depth > one.deepest || truth.depth < -outermost) continue;
      if (truth.toEdge < least || truth.toEdge >= most) continue;
      compareAt(errors, body, at, truth);
    }
  }
  errors.depthBias /= errors.points;
  errors.depthMean /= errors.points;
  errors.normalMean /= errors.points;
  return errors;
}

class SurfaceFieldOf : public ::testing::TestWithParam<Case> {};

TEST_P(SurfaceFieldOf, KnowsDepthAndNormalAwayFromEdges) {
  const FieldErrors e = fieldErrors(GetParam(), 4, 1e10, 1);
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
  const FieldErrors e = fieldErrors(GetParam(), 0, 3, 0);
  ASSERT_GT(e.points, 300);
  EXPECT_EQ(e.missing, 0);
  EXPECT_LE(std::abs(e.depthBias), 0.02);
  EXPECT_LE(e.depthMean, 0.05);
  // An edge or a corner pressed into a face may be 0.3 voxel off (issue 2); two bodies share it.
  EXPECT_LE(e.depthWorst, 0.3);
}

// Sums over all samples of clouds of one solid, in voxels, in the solid's frame.
struct SampleSums {
  double area = 0, volume = 0, offMean = 0, offWorst = 0, normalMean = 0;
  Vec3 vectorArea = Vec3::Zero();
};

SampleSums sampleSums(const Case& one, const Body& body) {
  SampleSums sums;
  const Vec3 origin = body.field->cloud().origin();
  for (std::size_t k = 0; k < body.field->sampleCount(); ++k) {
    const SurfaceSample s = body.field->sample(k);
    const Vec3 inGrid = Eigen::Map<const Eigen::Vector3f>(s.position).cast<double>();
    const Vec3 normalInGrid = Eigen::Map<const Eigen::Vector3f>(s.normal).cast<double>();
    const Vec3 at = body.grid.toLocal(origin + kVoxel * inGrid) / kVoxel;
    const Vec3 normal = body.grid.orientation.conjugate() * normalInGrid;
    const True truth = one.truth(at);
    sums.area += s.area;
    sums.vectorArea += s.area * normal;
    sums.volume += s.area * normal.dot(at) / 3;  // divergence theorem
    sums.offMean += s.area * std::abs(truth.depth);
    sums.offWorst = std::max(sums.offWorst, std::abs(truth.depth));
    // Degrees; nearer to an edge either face may be meant.
    if (truth.toEdge > 1) {
      sums.normalMean += s.area * truth.normal.cross(normal).norm() * 180 / std::numbers::pi;
    }
  }
  sums.offMean /= sums.area;
  sums.normalMean /= sums.area;
  return sums;
}

TEST_P(SurfaceFieldOf, SamplesCoverTheSurface) {
  BodyMaker maker{kVoxel, Random(22)};
  for (int k = 0; k < 2; ++k) {
    const SampleSums sums = sampleSums(GetParam(), GetParam().make(maker));
    EXPECT_NEAR(sums.area, GetParam().area, 0.01 * GetParam().area);
    EXPECT_NEAR(sums.volume, GetParam().volume, 0.01 * GetParam().volume);
    // A closed surface's vector area is zero: else a body under pressure from all sides moves.
    EXPECT_LE(sums.vectorArea.norm(), 1e-3 * GetParam().area);
    EXPECT_LE(sums.offMean, 0.02);
    EXPECT_LE(sums.offWorst, 0.3);
    EXPECT_LE(sums.normalMean, 0.5);
  }
}

TEST_P(SurfaceFieldOf, BoundsHoldTheSolid) {
  BodyMaker maker{kVoxel, Random(23)};
  const Case& one = GetParam();
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

INSTANTIATE_TEST_SUITE_P(Solids, SurfaceFieldOf, ::testing::ValuesIn(cases()),
                         [](const ::testing::TestParamInfo<Case>& param) {
                           return testName(param.param.name);
                         });

TEST(SurfaceField, RefusesAnEmptyCloudAndABadWindow) {
  EXPECT_THROW(SurfaceField::build(Cloud()), std::invalid_argument);
  BodyMaker maker{kVoxel, Random(24)};
  const Body body = maker.box({8, 8, 8});
  for (const double window : {0.0, -1.0, std::nan("")}) {
    FieldSettings settings;
    settings.window = window;
    EXPECT_THROW(SurfaceField::build(body.field->cloud(), settings), std::invalid_argument)
        << "window " << window;
  }
}

TEST(SurfaceField, KnowsNothingFarOutside) {
  BodyMaker maker{kVoxel, Random(25)};
  const Body body = maker.box({12, 12, 12});
  EXPECT_FALSE(body.field->at(body.grid.toWorld(Vec3(0.05, 0, 0))).has_value());
  EXPECT_FALSE(body.field->at(body.grid.toWorld(Vec3(1e6, -1e6, 1e6))).has_value());
}

}  // namespace
}  // namespace cloudcontact::testing
