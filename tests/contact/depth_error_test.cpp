// The error that a contact states covers the true one, on grids, in poses and at resolutions that
// its constants were not measured on (docs/measurements.md, "Error of a depth").
#include <cloudcontact/contact/depth_error.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "contact/contact_cases.h"

namespace depth_error_test {

namespace ct = cloudcontact::testing;
using namespace cloudcontact;

namespace {

constexpr std::uint64_t kSeed = 20260722;

struct Stated {
  double error = 0, truth = 0;  // [voxels]
};

// Of a case over grids, poses, depths and numbers of samples; without poses that do not touch.
std::vector<Stated> statedErrors(const ct::ContactCase& one, double voxel, int instances) {
  std::vector<Stated> all;
  ct::BodyMaker maker{voxel, ct::Random(kSeed), {}};
  for (int k = 0; k < instances; ++k) {
    const ct::Instance instance = one.make(maker);
    const Pose world{maker.random.rotation(), 100 * voxel * maker.random.inCube()};
    for (const double depth : {0.2, 0.45, 0.85})
      for (const std::size_t samples : {std::size_t{60}, ContactSettings::kSamples}) {
        ContactSettings settings;
        settings.samples = samples;
        const ct::Placed placed = instance.place(depth * voxel);
        const ContactBody a = instance.a.at(world * placed.a), b = instance.b.at(world * placed.b);
        ContactFinder finder;
        const ContactResult& found = finder.find(a, b, settings);
        if (found.patches.empty()) continue;
        const double off = ct::compare(found, placed.truth, world, settings, voxel).depth;
        all.push_back({depthError(a, b, found) / voxel, std::abs(off)});
      }
  }
  return all;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

class CaseErrors : public ::testing::TestWithParam<ct::ContactCase> {};

TEST_P(CaseErrors, AreCovered) {
  int covered = 0, all = 0;
  for (const double voxel : {1e-3, 3e-5})
    for (const Stated& s : statedErrors(GetParam(), voxel, voxel == 1e-3 ? 3 : 1)) {
      ++all;
      covered += s.truth <= s.error;
    }
  ASSERT_GT(all, 16);
  EXPECT_GE(covered, 0.95 * all) << covered << " of " << all;
}

std::vector<ct::ContactCase> known() {
  return ct::contactCases();
}

INSTANTIATE_TEST_SUITE_P(All, CaseErrors, ::testing::ValuesIn(known()),
                         [](const auto& one) { return ct::testName(one.param.name); });

// Not by stating the worst for all: faces are known ten times as well as crossed edges.
TEST(DepthError, TellsFacesFromEdges) {
  const auto typical = [](const char* name) {
    std::vector<double> errors;
    for (const Stated& s : statedErrors(ct::contactCase(name), 1e-3, 2)) errors.push_back(s.error);
    return median(errors);
  };
  const double face = typical("face-slab"), ball = typical("sphere24-slab"),
               crossed = typical("crossed90");
  EXPECT_LT(face, 0.02);
  EXPECT_LT(ball, 0.06);
  EXPECT_GT(crossed, 5 * ball);
  EXPECT_LT(face, ball);
}

// One ball and one block, from 6 to 45 voxels a radius. Depths are the same in meters.
TEST(DepthError, FollowsTheResolution) {
  const double radius = 9e-3;
  std::vector<double> typical;
  for (const double parts : {6.3, 12.5, 25.0}) {
    const double voxel = radius / parts;
    ct::BodyMaker maker{voxel, ct::Random(kSeed), {}};
    std::vector<double> errors;
    int covered = 0, all = 0;
    for (int k = 0; k < 5; ++k) {
      const ct::Body block = maker.box(Vec3(1.7, 1.9, 0.6) * parts), ball = maker.sphere(parts);
      for (const double depth : {1.1e-4, 2.3e-4, 4.1e-4}) {
        const double height = 0.3 * radius + radius - depth;
        const ContactBody a = block.at({}), b = ball.at({maker.random.rotation(), {0, 0, height}});
        ContactFinder finder;
        const ContactResult& found = finder.find(a, b, {});
        ASSERT_FALSE(found.patches.empty());
        errors.push_back(depthError(a, b, found));
        covered += std::abs(found.patches.front().depth - depth) <= errors.back();
        ++all;
      }
    }
    EXPECT_GE(covered, 0.93 * all) << parts;
    typical.push_back(median(errors));
  }
  for (std::size_t k = 1; k < typical.size(); ++k) EXPECT_LT(typical[k], 0.8 * typical[k - 1]) << k;
}

// Depth of a ball by its closed form, on walls down to half a voxel.
TEST(DepthError, GrowsWhereAWallIsThin) {
  const double voxel = 1e-3;
  const auto stated = [&](double thick) {
    ct::BodyMaker maker{voxel, ct::Random(kSeed), {}};
    std::vector<double> errors;
    int covered = 0;
    for (int k = 0; k < 6; ++k) {
      const ct::Body plate = maker.box({40, 36, thick}), ball = maker.sphere(20);
      for (const double depth : {0.15, 0.25}) {
        const Pose above{Eigen::Quaterniond::Identity(), {0, 0, (thick / 2 + 20 - depth) * voxel}};
        const ContactBody a = plate.at({}), b = ball.at(above);
        ContactFinder finder;
        const ContactResult& found = finder.find(a, b, {});
        if (found.patches.empty()) continue;
        double deepest = 0;
        for (const Patch& p : found.patches) deepest = std::max(deepest, p.depth / voxel);
        errors.push_back(depthError(a, b, found) / voxel);
        covered += std::abs(deepest - depth) <= errors.back();
      }
    }
    EXPECT_GE(covered, 0.9 * double(errors.size())) << thick;
    return median(errors);
  };
  const double solid = stated(8);
  EXPECT_LT(solid, 0.1);
  EXPECT_GT(stated(0.7), 3 * solid);
}

// Gaps of bodies that nearly touch.
TEST(DepthError, CoversGaps) {
  const double voxel = 1e-3;
  ContactSettings settings;
  settings.margin = 2 * voxel;
  int covered = 0, all = 0;
  for (const char* name : {"sphere16-slab", "cylinder16-across", "face-slab", "edge-slab",
                           "corner-slab", "crossed90", "primitive-edge"}) {
    ct::BodyMaker maker{voxel, ct::Random(kSeed), {}};
    for (int k = 0; k < 2; ++k) {
      const ct::Instance instance = ct::contactCase(name).make(maker);
      for (const double gap : {0.2, 0.5, 1.0}) {
        const ct::Placed placed = instance.place(-gap * voxel);
        const ContactBody a = instance.a.at(placed.a), b = instance.b.at(placed.b);
        ContactFinder finder;
        const ContactResult& found = finder.find(a, b, settings);
        if (found.patches.empty()) continue;
        double nearest = -1;
        for (const Patch& p : found.patches) nearest = std::max(nearest, p.depth);
        covered += std::abs(nearest + gap * voxel) <= depthError(a, b, found);
        ++all;
      }
    }
  }
  ASSERT_GT(all, 30);
  EXPECT_GE(covered, 0.95 * all) << covered << " of " << all;
}

TEST(DepthError, IsZeroWithoutAContact) {
  EXPECT_EQ(depthError({}, {}, {}), 0);
}

}  // namespace

}  // namespace depth_error_test
