// One test per figure of the paper (6 to 9): areas of any shape, representative points at any
// place, and workpieces of several materials, on small clouds computed by hand.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/cloud_solid.h>
#include <cloudcontact/workpiece/collision_finder.h>

#include "voxels/small_clouds.h"

namespace cloudcontact::paper_figures_test {
namespace {

constexpr double kVoxel = 0.5e-3;  // [m]
constexpr double kExact = 1e-12;
const Tissue kTooth{"tooth", 1000, 1, 1e9, 2000};

// Solid below z = 8 voxels, 16 by 16 wide.
Cloud slab() {
  return test::smallCloud(kVoxel, {2, 2, 2}, [](int, int, int z) { return z < 8 ? 255 : 0; });
}

// 5x5x5 voxels.
Cloud toolCloud() {
  return test::smallCloud(kVoxel, {1, 1, 1}, [](int x, int y, int z) {
    return std::max({x, y, z}) < 5 ? 255 : 0;
  });
}

WindowSettings window(const PlacedSolid& area, const Vec3& representative = Vec3::Zero()) {
  return {area, WindowWeight::Even, representative};
}

std::size_t voxelsIn(const BaseVectorField& field, const PlacedSolid& area, const Vec3& at) {
  Detection d;
  d.area = area;
  d.membership = Membership::Whole;
  CollisionFinder finder;
  return finder.find(field, {}, d, {Eigen::Quaterniond::Identity(), at}).voxels.size();
}

// The tool stands two voxels deep in the slab.
TEST(PaperFigure, Six_CollisionDetectionAreaOfAnyShape) {
  const BaseVectorField field(slab(), {kTooth},
                              window(PlacedSolid{Box{Vec3::Constant(1.5 * kVoxel)}}));
  const Cloud tool = toolCloud();
  const Vec3 place = kVoxel * Vec3(4, 4, 6);
  const Vec3 middle = Vec3::Constant(2.5 * kVoxel);
  // (a) the whole tool: two layers of 5x5.
  EXPECT_EQ(voxelsIn(field, cloudSolid(tool), place), 50u);
  // (b) a box of 3x3x3 voxels around its middle reaches 1 voxel above the slab: nothing;
  //     one of 3x3x5 all along the tool: two layers of 3x3.
  const Pose at{Eigen::Quaterniond::Identity(), middle};
  EXPECT_EQ(voxelsIn(field, PlacedSolid{Box{kVoxel * Vec3(1.5, 1.5, 0.49)}, at}, place), 0u);
  EXPECT_EQ(voxelsIn(field, PlacedSolid{Box{kVoxel * Vec3(1.5, 1.5, 2.5)}, at}, place), 18u);
  // (c) the cutting surface only, a voxel thick: the whole lowest layer and the rim of the next.
  const Cloud surface = surfaceLayer(tool, kVoxel);
  EXPECT_EQ(voxelsIn(field, cloudSolid(surface), place), 25u + 16u);
  // ... and only its tip.
  const PlacedSolid tip =
      PlacedSolid{Box{kVoxel * Vec3(2.6, 2.6, 0.6)},
                  {Eigen::Quaterniond::Identity(), kVoxel * Vec3(2.5, 2.5, 0.5)}};
  EXPECT_EQ(voxelsIn(field, cloudSolid(surfaceLayer(tool, kVoxel, &tip)), place), 25u);
  // (d) an ellipsoid of semi-axes 2.5, 1.5, 2.5. The lowest layer, at z = -2, has voxels with
  //     (x/2.5)^2 + (y/1.5)^2 <= 0.36: the middle one and its neighbors along x. The next, at -1,
  //     has those with <= 0.84: |x| <= 2, and at |y| = 1 |x| <= 1.
  const PlacedSolid ellipsoid{Ellipsoid{kVoxel * Vec3(2.5, 1.5, 2.5)}, at};
  EXPECT_EQ(voxelsIn(field, ellipsoid, place), 3u + (5u + 2 * 3u));
}

// Three collision voxels beside a wall's corner, as in the figure; C as box, ball and ellipsoid.
TEST(PaperFigure, Seven_CuttableAreaOfAnyShape) {
  const auto at = [](const PlacedSolid& area, const VoxelIndex& v) {
    return Vec3(BaseVectorField(slab(), {kTooth}, window(area)).at(v).toRepresentative / kVoxel);
  };
  const VoxelIndex top(8, 8, 7);
  // Box 3x3x3: of three layers the upper is empty: Gc half a voxel down. Box 3x3x5: two of five.
  EXPECT_NEAR((at(PlacedSolid{Box{kVoxel * Vec3(1.5, 1.5, 1.5)}}, top) - Vec3(0, 0, 0.5)).norm(), 0,
              kExact);
  EXPECT_NEAR((at(PlacedSolid{Box{kVoxel * Vec3(1.5, 1.5, 2.5)}}, top) - Vec3(0, 0, 1)).norm(), 0,
              kExact);
  // One voxel deeper the box of three is full.
  EXPECT_NEAR(at(PlacedSolid{Box{kVoxel * Vec3(1.5, 1.5, 1.5)}}, top - VoxelIndex(0, 0, 1)).norm(),
              0, kExact);
  // A ball of radius R: below its plane z = 1/2, volume and moment of a ball less a cap:
  // Gc_z = -(pi/4) (R^2 - 1/4)^2 / V, V = pi (2 R^3 / 3 + R^2 / 2 - 1/24).
  const auto ball = [](double r) {
    const double c = r * r - 0.25;
    return 0.25 * c * c / (2 * r * r * r / 3 + r * r / 2 - 1 / 24.0);
  };
  const Vec3 sphere = at(PlacedSolid{Sphere{2.5 * kVoxel}}, top);
  EXPECT_NEAR(sphere.z(), ball(2.5), 0.004 * ball(2.5));
  EXPECT_NEAR(sphere.head<2>().norm(), 0, kExact);
  // An ellipsoid is that ball stretched: along z by two, so the plane stands at a quarter.
  const Vec3 stretched = at(PlacedSolid{Ellipsoid{kVoxel * Vec3(2.5, 2.5, 5)}}, top);
  const double r = 2.5, p = 0.25, c = r * r - p * p;
  const double expected = 2 * 0.25 * c * c / (2 * r * r * r / 3 + r * r * p - p * p * p / 3);
  EXPECT_NEAR(stretched.z(), expected, 0.004 * expected);
  // C off to the side of its voxel (any offset): a box wholly in the slab, then wholly out.
  const Pose below{Eigen::Quaterniond::Identity(), kVoxel * Vec3(0, 0, -4)};
  EXPECT_NEAR(
      (at(PlacedSolid{Box{Vec3::Constant(1.5 * kVoxel)}, below}, top) - Vec3(0, 0, 4)).norm(), 0,
      kExact);
  const Pose above{Eigen::Quaterniond::Identity(), kVoxel * Vec3(0, 0, 4)};
  EXPECT_EQ(at(PlacedSolid{Box{Vec3::Constant(1.5 * kVoxel)}, above}, top).norm(), 0);
  // Any cloud: the tool itself, with its corner at the voxel's center.
  const Pose corner{Eigen::Quaterniond::Identity(), Vec3::Constant(-0.5 * kVoxel)};
  EXPECT_NEAR((at(cloudSolid(toolCloud(), corner), top) - Vec3(-2, -2, 0)).norm(), 0, 0.2)
      << "a cloud's depth is rounded at its edges";
}

// Moving Gr moves every base vector, and their mean, by the same amount.
TEST(PaperFigure, Eight_RepresentativePointIsAConstantBias) {
  const PlacedSolid area{Sphere{2.5 * kVoxel}};
  const PlacedSolid askew{Box{kVoxel * Vec3(2.5, 1.5, 1.5)},
                          {Eigen::Quaterniond::Identity(), kVoxel * Vec3(1, 0, 0)}};
  EXPECT_NEAR((centerOfGravity(askew) - kVoxel * Vec3(1, 0, 0)).norm(), 0, kExact);
  const Cloud wedge = test::smallCloud(
      kVoxel, {1, 1, 1}, [](int x, int y, int z) { return x < 3 && y == 0 && z <= x ? 255 : 0; });
  const PlacedSolid wedgeArea = cloudSolid(wedge);
  EXPECT_NEAR((centerOfGravity(wedgeArea) - kVoxel * Vec3(11 / 6.0, 0.5, 7 / 6.0)).norm(), 0,
              kExact);
  EXPECT_NEAR((centerOfBounds(wedgeArea) - kVoxel * Vec3(1.5, 0.5, 1.5)).norm(), 0, kExact);

  Detection d;
  d.area = {Sphere{3 * kVoxel}};
  d.hardness = false;
  const Pose tool{Eigen::Quaterniond::Identity(), kVoxel * Vec3(7.7, 8.2, 9.3)};
  CollisionFinder finder;
  const BaseVectorField plain(slab(), {kTooth}, window(area));
  const Vec3 without = finder.find(plain, {}, d, tool).mean;
  ASSERT_GT(without.z(), 0.3 * kVoxel);
  for (const Vec3& gr : {Vec3(1, 0, 0), Vec3(0, -2, 0.5), Vec3(0.3, 0.3, -3)}) {
    const BaseVectorField biased(slab(), {kTooth}, window(area, kVoxel * gr));
    EXPECT_NEAR((finder.find(biased, {}, d, tool).mean - without - kVoxel * gr).norm(), 0, kExact);
  }
}

// The tooth of the figure: a block with the collision area at its upper left corner, first uniform,
// then with its left two columns harder and denser.
TEST(PaperFigure, Nine_SeveralMaterials) {
  const auto inBlock = [](int x, int y, int z) {
    return x >= 4 && x < 12 && z >= 4 && z < 12 && y == 4 ? 255 : 0;
  };
  const PlacedSolid c{Box{Vec3::Constant(1.5 * kVoxel)}};
  const BaseVectorField uniform(test::smallCloud(kVoxel, {2, 1, 2}, inBlock), {kTooth}, window(c));
  // (c): the second collision voxel of the upper row: C holds three by two voxels.
  EXPECT_NEAR((uniform.at({5, 4, 11}).toRepresentative / kVoxel - Vec3(0, 0, 0.5)).norm(), 0,
              kExact);
  // (d): at the corner two by two; in the left column three by two.
  EXPECT_NEAR((uniform.at({4, 4, 11}).toRepresentative / kVoxel - Vec3(-0.5, 0, 0.5)).norm(), 0,
              kExact);
  EXPECT_NEAR((uniform.at({4, 4, 9}).toRepresentative / kVoxel - Vec3(-0.5, 0, 0)).norm(), 0,
              kExact);

  const Tissue enamel{"enamel", 3000, 1, 3e9, 3000}, dentin{"dentin", 1000, 1, 1e9, 1000};
  const Cloud layered = test::smallCloud(kVoxel, {2, 1, 2}, inBlock, {"enamel", "dentin"},
                                         [](int x, int, int) { return x < 6 ? 0 : 1; });
  const BaseVectorField field(layered, {enamel, dentin}, window(c));
  // (g): the columns 4, 5, 6 weigh 3, 3, 1: Gc at (-3 + 1) / 7 along x.
  EXPECT_NEAR((field.at({5, 4, 11}).toRepresentative / kVoxel - Vec3(2 / 7.0, 0, 0.5)).norm(), 0,
              kExact);
  // (h): deep in the left column nothing changes; in the dentin beside it 3, 1, 1.
  EXPECT_NEAR((field.at({4, 4, 9}).toRepresentative / kVoxel - Vec3(-0.5, 0, 0)).norm(), 0, kExact);
  EXPECT_NEAR((field.at({6, 4, 11}).toRepresentative / kVoxel - Vec3(2 / 5.0, 0, 0.5)).norm(), 0,
              kExact);
  // The mean over both, weighed with h = 1 and 1/3, leans toward the dentin; the uniform one does
  // not.
  Detection d;
  d.membership = Membership::Whole;
  d.area = {Box{kVoxel * Vec3(1, 0.5, 0.5)},
            {Eigen::Quaterniond::Identity(),
             kVoxel * Vec3(6, 4.5, 11.5)}};  // voxels 5 and 6 of the upper row
  CollisionFinder finder;
  EXPECT_NEAR((finder.find(field, {}, d, {}).mean / kVoxel -
               0.5 * (Vec3(2 / 7.0, 0, 0.5) + Vec3(2 / 5.0, 0, 0.5) / 3))
                  .norm(),
              0, kExact);
  EXPECT_NEAR((finder.find(uniform, {}, d, {}).mean / kVoxel - Vec3(0, 0, 0.5)).norm(), 0, kExact);
}

}  // namespace
}  // namespace cloudcontact::paper_figures_test
