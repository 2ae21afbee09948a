// The depth of faces that touch lightly does not depend on corners that the field leaves blunt.
// Over the corners of a nut's bore, the plane in the middle of a sample leans by 60 deg; by that
// plane alone the pair is 0.05 voxel too deep, and gets less deep where it is pressed more.
#include <gtest/gtest.h>

#include <cloudcontact/contact/contact_finder.h>

#include "field/mesh_field.h"
#include "mesh/plain_nut.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::testing::blunt_corners_test {
namespace {

constexpr double kVoxel = 1e-3, kHigh = 10e-3;

std::shared_ptr<const SurfaceField> nut() {
  static const auto field = fieldOf(plainNut(24e-3, 12e-3, kHigh), kVoxel);
  return field;
}

std::shared_ptr<const SurfaceField> block() {
  static const Vec3 half(10e-3, 10e-3, kHigh / 2);
  static const auto field = fieldOf(test::boxMesh(-half, half), kVoxel);
  return field;
}

// Of two bodies that lie on each other, turned by `turn` [rad], `overlap` deep [voxels].
double depth(const SurfaceField& low, const SurfaceField& high, double turn, double overlap) {
  ContactBody a, b;
  a.field = &low;
  b.field = &high;
  b.pose.orientation = Eigen::AngleAxisd(turn, Vec3::UnitZ());
  b.pose.position = Vec3(3e-4, 0, kHigh - overlap * kVoxel);
  ContactFinder finder;
  return depthOf(finder.find(a, b, {})) / kVoxel;
}

class BluntCorners : public ::testing::TestWithParam<double> {};

TEST_P(BluntCorners, LeaveTheDepthOfFacesAsItIs) {
  for (const double turn : {0.0, 0.05, 0.11, 0.3, 0.7}) {
    EXPECT_NEAR(depth(*nut(), *nut(), turn, GetParam()), GetParam(), 0.02) << turn;
    EXPECT_NEAR(depth(*nut(), *block(), turn, GetParam()), GetParam(), 0.02) << turn;
    EXPECT_NEAR(depth(*block(), *nut(), turn, GetParam()), GetParam(), 0.02) << turn;
  }
}

INSTANTIATE_TEST_SUITE_P(Overlaps, BluntCorners,
                         ::testing::Values(0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2));

}  // namespace
}  // namespace cloudcontact::testing::blunt_corners_test
