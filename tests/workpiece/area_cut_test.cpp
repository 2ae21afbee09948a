// Cuts by areas: volumes against closed forms.
#include <cloudcontact/workpiece/cloud_solid.h>
#include <cloudcontact/workpiece/cutter.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "voxels/small_clouds.h"

namespace cloudcontact::area_cut_test {
namespace {

constexpr double kVoxel = 1e-4;  // [m]
const Tissue kEnamel{"enamel", 2e4, .4, 3e9, 2970};

BaseVectorField block() {
  const Cloud cloud = test::smallCloud(kVoxel, {5, 5, 5}, [](int, int, int) { return 255; });
  return BaseVectorField(cloud.translated(kVoxel * Vec3(-3, 7, 2)), {kEnamel},
                         sphereWindow(kVoxel));
}

Pose poseOf(const Vec3& place, double angle) {
  Pose pose;
  pose.position = kVoxel * place;
  pose.orientation = Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized());
  return pose;
}

// Volume that cuts remove [voxels].
double removed(const std::vector<VoxelCut>& cuts) {
  double sum = 0;
  for (const VoxelCut& c : cuts) sum += 255 - c.coverage;
  return sum / 255;
}

TEST(AreaCut, ABoxAlongTheGridLeavesTheMaterialOutside) {
  const BaseVectorField field = block();
  // Voxels 4 to 8 and a fifth of the ninth along x, whole voxels along y and z.
  const PlacedSolid area{Box{kVoxel * Vec3(2.6, 2, 3)}};
  const Vec3 middle = Vec3(4 + 2.6, 12, 20) + Vec3(-3, 7, 2);
  const std::vector<VoxelCut> cuts = cutsOf(field, area, poseOf(middle, 0));
  double whole = 0, parts = 0;
  for (const VoxelCut& c : cuts) {
    const VoxelIndex v = c.voxel;
    const bool in = v.y() >= 10 && v.y() < 14 && v.z() >= 17 && v.z() < 23;
    ASSERT_TRUE(in && v.x() >= 4 && v.x() <= 9) << v.transpose();
    EXPECT_EQ(c.coverage, v.x() < 9 ? 0 : 255 - 51) << v.transpose();
    (v.x() < 9 ? whole : parts) += 1;
  }
  EXPECT_EQ(whole, 5 * 4 * 6);
  EXPECT_EQ(parts, 4 * 6);
}

TEST(AreaCut, VolumesAreThoseOfTheAreas) {
  const BaseVectorField field = block();
  const Vec3 middle = Vec3(20.2, 19.7, 20.4) + Vec3(-3, 7, 2);
  const double ball = 4 / 3.0 * std::numbers::pi;
  EXPECT_NEAR(removed(cutsOf(field, PlacedSolid{Sphere{12.3 * kVoxel}}, poseOf(middle, 0.3))),
              ball * std::pow(12.3, 3), 0.003 * ball * std::pow(12.3, 3));
  const Vec3 half(9.2, 6.1, 11.3);
  EXPECT_NEAR(removed(cutsOf(field, PlacedSolid{Box{kVoxel * half}}, poseOf(middle, 0.7))),
              8 * half.prod(), 0.01 * 8 * half.prod());
  EXPECT_NEAR(removed(cutsOf(field, PlacedSolid{Ellipsoid{kVoxel * half}}, poseOf(middle, 0.7))),
              ball * half.prod(), 0.01 * ball * half.prod());
  const Cloud cloud = test::ballCloud(kVoxel, 3, Vec3(12, 12, 12), 9.4);
  const PlacedSolid area = cloudSolid(cloud, poseOf(Vec3(-12, -12, -12), 0));
  EXPECT_NEAR(removed(cutsOf(field, area, poseOf(middle, 0.7))), ball * std::pow(9.4, 3),
              0.02 * ball * std::pow(9.4, 3));
}

TEST(AreaCut, ACloudIsCutAsTheFieldThatIsMadeOfIt) {
  const Cloud cloud = test::smallCloud(kVoxel, {5, 4, 3}, [](int, int, int) {
                        return 255;
                      }).translated(kVoxel * Vec3(-3, 7, 2));
  const BaseVectorField field(cloud, {kEnamel}, sphereWindow(kVoxel));
  const PlacedSolid area{Sphere{6.3 * kVoxel}};
  const Pose tool = poseOf(Vec3(14, 26, 12), 0.3);
  const auto of = cutsOf(field, area, tool), cuts = cutsOf(cloud, area, tool);
  ASSERT_EQ(cuts.size(), of.size());
  ASSERT_GT(cuts.size(), 1000u);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    EXPECT_EQ(cuts[i].voxel, of[i].voxel);
    EXPECT_EQ(cuts[i].coverage, of[i].coverage);
  }
}

// An area beside the tool's origin, turned: the pose moves it too.
TEST(AreaCut, ThePoseMovesTheArea) {
  const BaseVectorField field = block();
  const Pose inTool = poseOf(Vec3(4, -2, 1), 0.4), tool = poseOf(Vec3(17, 26, 22), 0.9);
  const Vec3 half = kVoxel * Vec3(6.2, 3.1, 8.3);
  const auto one = cutsOf(field, PlacedSolid{Box{half}, inTool}, tool),
             other = cutsOf(field, PlacedSolid{Box{half}, tool * inTool}, {});
  ASSERT_EQ(one.size(), other.size());
  EXPECT_GT(one.size(), 500u);
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].voxel, other[k].voxel);
    EXPECT_NEAR(one[k].coverage, other[k].coverage, 1);
  }
}

TEST(AreaCut, PartlyAndWhollyOutsideTheGrid) {
  BaseVectorField field = block();
  const PlacedSolid ball{Sphere{10 * kVoxel}};
  // Half of it is in.
  const double half = removed(cutsOf(field, ball, poseOf(Vec3(-3, 27, 22), 0)));
  EXPECT_NEAR(half, 2 / 3.0 * std::numbers::pi * 1000, 10);
  EXPECT_NO_THROW(field.cut(cutsOf(field, ball, poseOf(Vec3(-3, 27, 22), 0))));
  EXPECT_TRUE(cutsOf(field, ball, poseOf(Vec3(-15, 27, 22), 0)).empty());
  EXPECT_TRUE(cutsOf(field, ball, poseOf(Vec3(1e30, 0, 0), 0)).empty());
}

TEST(AreaCut, RejectsBadInputWithAReason) {
  const BaseVectorField field = block();
  EXPECT_THROW(cutsOf(field, PlacedSolid{Sphere{0}}, {}), std::invalid_argument);
  Pose bad;
  bad.position.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cutsOf(field, PlacedSolid{Sphere{kVoxel}}, bad), std::invalid_argument);
  bad = {};
  bad.orientation.coeffs().setZero();
  EXPECT_THROW(cutsOf(field, PlacedSolid{Sphere{kVoxel}}, bad), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::area_cut_test
