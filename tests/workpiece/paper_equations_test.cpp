// One test per equation of the paper, on clouds of a few voxels computed by hand.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/collision_finder.h>
#include <cloudcontact/workpiece/reaction.h>

#include "voxels/small_clouds.h"

namespace cloudcontact::paper_equations_test {
namespace {

constexpr double kVoxel = 1e-3;  // [m]
constexpr double kExact = 1e-12;

const Tissue kHard{"hard", 3000, 6, 2e9, 2000}, kSoft{"soft", 1000, 2, 1e9, 1000},
    kThird{"third", 500, 1, 4e9, 1000};

// Four voxels in a row along x, the first at (2,2,2).
Cloud row(const std::vector<std::string>& materials = {},
          const std::function<int(int, int, int)>& tissue = {}) {
  return test::smallCloud(
      kVoxel, {1, 1, 1},
      [](int x, int y, int z) { return x >= 2 && x < 6 && y == 2 && z == 2 ? 255 : 0; }, materials,
      tissue);
}

// C: a box of 3x3x3 voxels, evenly weighed, with Gr in its middle.
WindowSettings cube() {
  return {PlacedSolid{Box{Vec3::Constant(1.5 * kVoxel)}}, WindowWeight::Even, Vec3::Zero()};
}

// D: the voxels from `first` to `last` of the row.
Detection detect(int first, int last) {
  Detection d;
  const Vec3 low(first, 1.5, 1.5), high(last + 1, 3.5, 3.5);
  d.area = {Box{kVoxel * 0.5 * (high - low)},
            {Eigen::Quaterniond::Identity(), kVoxel * 0.5 * (low + high)}};
  d.membership = Membership::Whole;
  d.hardness = false;
  return d;
}

// k = sum of N k / sum of N: two hard voxels and one soft one.
TEST(PaperEquation, One_StiffnessIsTheMeanOverTheCollisionVoxels) {
  const Cloud cloud = row({"hard", "soft"}, [](int x, int, int) { return x < 4 ? 0 : 1; });
  const BaseVectorField field(cloud, {kHard, kSoft}, cube());
  CollisionFinder finder;
  const Collision& c = finder.find(field, {}, detect(2, 4), {});
  ASSERT_EQ(c.voxels.size(), 3u);
  EXPECT_NEAR(c.stiffness, (2 * 3000 + 1000) / 3.0, kExact * 3000);
}

TEST(PaperEquation, Two_DampingLikewise) {
  const Cloud cloud =
      row({"hard", "soft", "third"}, [](int x, int, int) { return std::min(x - 2, 2); });
  const BaseVectorField field(cloud, {kHard, kSoft, kThird}, cube());
  CollisionFinder finder;
  const Collision& c = finder.find(field, {}, detect(2, 5), {});
  EXPECT_NEAR(c.damping, (6 + 2 + 1 + 1) / 4.0, kExact);
}

TEST(PaperEquation, Three_ForceIsSpringAndDamper) {
  Collision c;
  c.count = 1, c.stiffness = 2000, c.damping = 5;
  EXPECT_NEAR(kelvinVoigt(c, 1e-3, 0.1), 2000 * 1e-3 + 5 * 0.1, kExact);
  EXPECT_EQ(kelvinVoigt(c, 1e-3, -10), 0) << "it never pulls";
  EXPECT_EQ(kelvinVoigt(c, 0, 1), 0) << "nor acts where nothing is in";
}

// C around the first voxel holds it and its neighbor: Gc half a voxel along x.
TEST(PaperEquation, Four_BaseVectorRunsFromTheCenterOfGravity) {
  const BaseVectorField field(row(), {kHard}, cube());
  const double expected[4] = {-0.5, 0, 0, 0.5};
  for (int k = 0; k < 4; ++k) {
    const BaseVector f = field.at({2 + k, 2, 2});
    EXPECT_NEAR((f.toRepresentative - Vec3(expected[k] * kVoxel, 0, 0)).norm(), 0, kExact);
    EXPECT_NEAR(f.fraction, (k == 0 || k == 3 ? 2 : 3) / 27.0, kExact);
  }
}

TEST(PaperEquation, Five_DigitalNormalIsTheirMean) {
  const BaseVectorField field(row(), {kHard}, cube());
  CollisionFinder finder;
  const Collision& two = finder.find(field, {}, detect(2, 3), {});
  EXPECT_NEAR((two.mean - Vec3(-0.25 * kVoxel, 0, 0)).norm(), 0, kExact);
  const Collision& all = finder.find(field, {}, detect(2, 5), {});
  EXPECT_NEAR(all.mean.norm(), 0, kExact) << "from both ends they cancel";
}

// Densities 2 and 1: Gc of the second voxel is (2 (-1) + 2 (0) + 1 (1)) / 5. Hardnesses 1 and 1/2.
TEST(PaperEquation, FivePrime_HardnessDensityAndCuttingAbility) {
  const Cloud cloud = row({"hard", "soft"}, [](int x, int, int) { return x < 4 ? 0 : 1; });
  const BaseVectorField field(cloud, {kHard, kSoft}, cube());
  EXPECT_NEAR(field.at({3, 2, 2}).toRepresentative.x(), 0.2 * kVoxel, kExact);
  EXPECT_NEAR(field.at({4, 2, 2}).toRepresentative.x(), 0.25 * kVoxel, kExact);
  CollisionFinder finder;
  Detection d = detect(3, 4);
  d.hardness = true;
  EXPECT_NEAR(finder.find(field, {}, d, {}).mean.x(), (1 * 0.2 + 0.5 * 0.25) / 2 * kVoxel, kExact);
  // The part of the tool at the fifth voxel has ability 3, the rest a tenth.
  d.ability = 0.1;
  d.parts.push_back({PlacedSolid{Box{Vec3::Constant(0.4 * kVoxel)},
                                 {Eigen::Quaterniond::Identity(), kVoxel * Vec3(4.5, 2.5, 2.5)}},
                     3});
  EXPECT_NEAR(finder.find(field, {}, d, {}).mean.x(), (0.1 * 1 * 0.2 + 3 * 0.5 * 0.25) / 2 * kVoxel,
              kExact);
}

TEST(PaperEquation, Six_ForceAlongTheDigitalNormalDividedByItsLengthOrNot) {
  const Cloud cloud = row({"hard", "soft"}, [](int x, int, int) { return x < 3 ? 0 : 1; });
  const BaseVectorField field(cloud, {kHard, kSoft}, cube());
  CollisionFinder finder;
  const Collision& c = finder.find(field, {}, detect(2, 3), {});
  Reaction r;
  react(c, field, 8, 1e-3, 0, Vec3::Zero(), Direction::Unit, r);
  EXPECT_NEAR((r.onTool.force - Vec3(-8, 0, 0)).norm(), 0, kExact * 8);
  // One voxel each, k 3000 and 1000: three quarters and one.
  EXPECT_NEAR(r.tissues[0].x(), -6, kExact * 8);
  EXPECT_NEAR(r.tissues[1].x(), -2, kExact * 8);
  react(c, field, 8, 1e-3, 0, Vec3::Zero(), Direction::Unscaled, r);
  EXPECT_NEAR((r.onTool.force - 8 * c.mean / kVoxel).norm(), 0, kExact * 8);
  EXPECT_LT(r.onTool.force.norm(), 4);
}

}  // namespace
}  // namespace cloudcontact::paper_equations_test
