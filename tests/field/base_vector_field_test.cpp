// The field of base vectors: depth on planes and balls, and cuts that equal a new field.
#include <gtest/gtest.h>

#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/voxels/pieces.h>

#include <random>

#include "voxels/small_clouds.h"

namespace cloudcontact::base_vector_field_test {
namespace {

constexpr double kVoxel = 1e-4;  // [m]
const Tissue kEnamel{"enamel", 2e4, .4, 3e9, 2970}, kDentin{"dentin", 5e3, .1, 6e8, 2140};

Cloud tooth() {
  return test::ballCloud(
      kVoxel, 5, Vec3(20.3, 19.6, 20.1), 16.4, {"enamel", "dentin"},
      [](int x, int y, int z) { return (Vec3(x, y, z) - Vec3(20, 20, 20)).norm() > 11 ? 0 : 1; });
}

// Worst error of depth() against the half-space n.x < offset near its surface [voxels].
double worstOnPlane(const Vec3& n, double offset) {
  const Cloud cloud = test::smallCloud(kVoxel, {3, 3, 3}, [&](int x, int y, int z) {
    int in = 0;
    for (int k = 0; k < 1000; ++k)
      in += n.dot(Vec3(x + (k % 10 + .5) / 10, y + (k / 10 % 10 + .5) / 10,
                       z + (k / 100 + .5) / 10)) < offset;
    return (in * 255 + 500) / 1000;
  });
  const BaseVectorField field(cloud, {kEnamel}, sphereWindow(kVoxel));
  double worst = 0;
  for (int z = 8; z < 16; ++z)
    for (int y = 8; y < 16; ++y)
      for (int x = 8; x < 16; ++x) {
        const double truth = offset - n.dot(Vec3(x + .5, y + .5, z + .5));
        const auto depth = field.depth({x, y, z});
        if (std::abs(truth) > 1 || !depth || field.coverage({x, y, z}) == 0) continue;
        worst = std::max(worst, std::abs(*depth / kVoxel - truth));
      }
  return worst;
}

TEST(BaseVectorField, DepthOnPlanes) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  EXPECT_LT(worstOnPlane(Vec3::UnitZ(), 12.3), 0.02);
  for (int k = 0; k < 12; ++k) {
    const Vec3 n = Vec3(normal(random), normal(random), normal(random)).normalized();
    EXPECT_LT(worstOnPlane(n, n.dot(Vec3(12.2, 11.9, 12.4))), 0.03) << n.transpose();
  }
}

// A ball's depth is right within the error of curvature, a tenth.
TEST(BaseVectorField, DepthOnABallAndDirection) {
  const Vec3 center(20.3, 19.6, 20.1);
  const BaseVectorField field(test::ballCloud(kVoxel, 5, center, 16.4), {kEnamel},
                              sphereWindow(kVoxel));
  double sum = 0, worst = 0;
  int count = 0;
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const Vec3 from = Vec3(x + .5, y + .5, z + .5) - center;
        if (std::abs(from.norm() - 16.4) > 0.8 || field.coverage({x, y, z}) == 0) continue;
        EXPECT_NEAR(*field.depth({x, y, z}) / kVoxel, 16.4 - from.norm(), 0.12);
        const double angle = std::acos(std::min(
            1.0, field.at({x, y, z}).toRepresentative.normalized().dot(from.normalized())));
        sum += angle, worst = std::max(worst, angle), ++count;
      }
  ASSERT_GT(count, 3000);
  EXPECT_LT(sum / count * 57.3, 0.6) << "a smooth window errs by 0.4 deg on planes";
  EXPECT_LT(worst * 57.3, 2.5);
}

TEST(BaseVectorField, InsideAllIsEven) {
  const BaseVectorField field(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel));
  const BaseVector f = field.at({20, 20, 20});
  EXPECT_EQ(f.toRepresentative.norm(), 0);
  EXPECT_EQ(f.fraction, 1);
  EXPECT_GT(*field.depth({20, 20, 20}), 2 * kVoxel);
  EXPECT_EQ(field.at({0, 0, 0}).fraction, 0) << "far outside";
  EXPECT_EQ(field.coverage({-1, 0, 0}), 0);
  EXPECT_EQ(field.coverage({1000, 0, 0}), 0);
}

// A hundred random cuts, of whole voxels and parts, at the surface and inside: after each, the
// field equals one built from the rest.
TEST(BaseVectorField, AfterCutsItEqualsANewField) {
  for (const double radius : {1.5, 2.5, 6.0}) {
    BaseVectorField field(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel, radius));
    std::mt19937 random(7);
    std::uniform_int_distribution<int> place(0, 39), size(1, 60), left(0, 254);
    for (int cut = 0; cut < 20; ++cut) {
      std::vector<VoxelCut> cuts;
      const VoxelIndex middle(place(random), place(random), place(random));
      for (int k = size(random); k > 0; --k)
        cuts.push_back(
            {(middle + VoxelIndex(place(random) % 7, place(random) % 7, place(random) % 7))
                 .cwiseMin(39),
             static_cast<std::uint8_t>(k % 3 ? 0 : left(random))});
      field.cut(cuts);
    }
    const BaseVectorField built(field.cloud(), {kEnamel, kDentin}, sphereWindow(kVoxel, radius));
    EXPECT_EQ(field.hash(), built.hash()) << radius;
    EXPECT_NE(field.hash(),
              BaseVectorField(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel, radius)).hash());
  }
}

// Rows across bricks and both tissues, removed in three steps, with windows that reach to the
// neighboring bricks, beyond them, and to one side only.
TEST(BaseVectorField, CutsAcrossBricksEqualANewField) {
  WindowSettings aside = sphereWindow(kVoxel);
  aside.area = {Sphere{2.5 * kVoxel}, {.position = kVoxel * Vec3(4.3, -2.1, 0.4)}};
  for (const WindowSettings& window : {sphereWindow(kVoxel), sphereWindow(kVoxel, 9.5), aside}) {
    BaseVectorField field(tooth(), {kEnamel, kDentin}, window);
    for (const int left : {200, 90, 0}) {
      std::vector<VoxelCut> cuts;
      for (int z = 13; z < 19; ++z)
        for (int y = 6; y < 10; ++y)
          for (int x = 3; x < 38; ++x)
            if ((x * 7 + y + z + left) % 11 > 0)
              cuts.push_back({{x, y, z}, static_cast<std::uint8_t>(left)});
      EXPECT_GT(field.cut(cuts), 300u);
    }
    const BaseVectorField built(field.cloud(), {kEnamel, kDentin}, window);
    EXPECT_EQ(field.hash(), built.hash());
    EXPECT_EQ(field.mass().inertia, built.mass().inertia);
  }
}

// Deep inside, bricks share a block until a cut comes near. Then they get their own, and the other
// blocks may move in memory.
TEST(BaseVectorField, ACutDeepInsideEqualsANewField) {
  const Cloud ball = test::ballCloud(kVoxel, 8, Vec3(32.2, 31.9, 32.1), 30);
  BaseVectorField field(ball, {kEnamel}, sphereWindow(kVoxel));
  std::vector<VoxelCut> cuts;
  for (int k = 0; k < 1000; ++k) cuts.push_back({{26 + k % 10, 27 + k / 10 % 10, 25 + k / 100}, 0});
  EXPECT_EQ(field.cut(cuts), 1000u);
  EXPECT_EQ(field.hash(), BaseVectorField(field.cloud(), {kEnamel}, sphereWindow(kVoxel)).hash());
}

// More bricks than FieldChanges holds, with a voxel or two in each.
TEST(BaseVectorField, CutsInEveryBrickEqualANewField) {
  const Cloud ball = test::ballCloud(kVoxel, 10, Vec3(40.2, 39.9, 40.1), 38);
  BaseVectorField field(ball, {kEnamel}, sphereWindow(kVoxel));
  std::vector<VoxelCut> cuts;
  for (int k = 0; k < 2000; ++k)
    cuts.push_back(
        {8 * VoxelIndex(k % 10, k / 10 % 10, k / 100 % 10) + VoxelIndex(k % 7, k % 5, 3 + k / 1000),
         std::uint8_t(k % 100)});
  EXPECT_GT(field.cut(cuts), 600u);
  EXPECT_EQ(field.hash(), BaseVectorField(field.cloud(), {kEnamel}, sphereWindow(kVoxel)).hash());
}

// The octree, updated voxel by voxel, equals that of the rest.
// A half of the tooth, by any window: as made from its cloud, at all voxels that have a window.
TEST(BaseVectorField, OfAPartEqualsANewField) {
  const Cloud cloud = tooth();
  for (const double radius : {2.5, 9.0}) {
    const WindowSettings window = sphereWindow(kVoxel, radius);
    const BaseVectorField whole(cloud, {kEnamel, kDentin}, window);
    for (const int at : {4, 17, 24, 33}) {
      std::vector<VoxelCut> cuts;
      for (int z = at; z < 40; ++z)
        for (int y = 0; y < 40; ++y)
          for (int x = 0; x < 40; ++x)
            cuts.push_back({{x, y, z}, static_cast<std::uint8_t>(z == at ? 77 : 0)});
      const Cloud part = cutCloud(cloud, cuts);
      const BaseVectorField known = whole.ofPart(part), made(part, {kEnamel, kDentin}, window);
      EXPECT_EQ(known.hash(), made.hash()) << at;
      EXPECT_EQ(known.mass().mass, made.mass().mass);
      for (int z = 0; z < 40; ++z)
        for (int y = 3; y < 40; y += 4)
          EXPECT_EQ(known.coverage({20, y, z}), part.coverage(20, y, z));
    }
  }
  const BaseVectorField field(cloud, {kEnamel, kDentin}, sphereWindow(kVoxel));
  EXPECT_THROW(field.ofPart(Cloud()), std::invalid_argument);
  EXPECT_THROW(field.ofPart(cloud.translated(Vec3(kVoxel, 0, 0))), std::invalid_argument);
}

TEST(BaseVectorField, TheOctreeFollowsTheCuts) {
  BaseVectorField field(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel));
  Octree octree(tooth());
  const Octree whole = octree;
  std::mt19937 random(11);
  std::uniform_int_distribution<int> place(2, 32);
  for (int cut = 0; cut < 10; ++cut) {
    std::vector<VoxelCut> cuts;
    const VoxelIndex corner(place(random), place(random), place(random));
    for (int k = 0; k < 216; ++k)
      cuts.push_back({corner + VoxelIndex(k % 6, k / 6 % 6, k / 36), std::uint8_t(k % 5 ? 0 : 77)});
    field.cut(cuts);
    for (const VoxelCut& c : cuts)
      octree.set(c.voxel, field.coverage(c.voxel),
                 static_cast<std::uint8_t>(field.tissue(c.voxel)));
  }
  EXPECT_TRUE(octree == Octree(field.cloud()));
  EXPECT_FALSE(octree == whole);
}

TEST(BaseVectorField, CutInAnyOrderIsTheSame) {
  std::vector<VoxelCut> cuts;
  for (int k = 0; k < 300; ++k)
    cuts.push_back({{15 + k % 7, 14 + k / 7 % 7, 4 + k / 49}, std::uint8_t(k % 2 ? 0 : 90)});
  BaseVectorField one(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel));
  one.reserve();
  const std::size_t changed = one.cut(cuts);
  EXPECT_GT(changed, 150u);
  EXPECT_EQ(one.cut(cuts), 0u) << "nothing is left to take";
  std::shuffle(cuts.begin(), cuts.end(), std::mt19937(3));
  BaseVectorField two(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel));
  EXPECT_EQ(two.cut(cuts), changed);
  EXPECT_EQ(one.hash(), two.hash());
  EXPECT_EQ(one.mass().mass, two.mass().mass);
}

// The removed part and the rest add up; the whole has a ball's mass and inertia.
TEST(BaseVectorField, MassOfAShelledBall) {
  const double r = 16.4 * kVoxel;
  BaseVectorField field(test::ballCloud(kVoxel, 5, Vec3(20.3, 19.6, 20.1), 16.4), {kDentin},
                        sphereWindow(kVoxel));
  const MassProperties whole = field.mass();
  const double mass = 2140 * 4 / 3.0 * M_PI * r * r * r;
  EXPECT_NEAR(whole.mass, mass, 2e-3 * mass);
  EXPECT_NEAR((whole.centerOfMass - kVoxel * Vec3(20.3, 19.6, 20.1)).norm(), 0, 2e-3 * kVoxel);
  EXPECT_NEAR((whole.inertia - 0.4 * mass * r * r * Eigen::Matrix3d::Identity()).norm(), 0,
              5e-3 * mass * r * r);
  std::vector<VoxelCut> cuts;
  for (int k = 0; k < 1000; ++k) cuts.push_back({{20 + k % 10, 15 + k / 10 % 10, 15 + k / 100}, 0});
  field.cut(cuts);
  const double voxel = kVoxel * kVoxel * kVoxel;
  const MassProperties rest = field.mass();
  EXPECT_NEAR(whole.volume - rest.volume, 1000 * voxel, 1e-9 * voxel * 1000);
  // The centers of both parts balance.
  const Vec3 block = kVoxel * Vec3(25, 20, 20);
  EXPECT_NEAR((whole.mass * whole.centerOfMass -
               (rest.mass * rest.centerOfMass + 2140 * 1000 * voxel * block))
                  .norm(),
              0, 1e-12 * whole.mass * 1e-3);
}

TEST(BaseVectorField, RejectsBadInputWithAReason) {
  EXPECT_THROW(BaseVectorField(Cloud(), {kEnamel}, sphereWindow(kVoxel)), std::invalid_argument);
  EXPECT_THROW(BaseVectorField(tooth(), {kEnamel}, sphereWindow(kVoxel)), std::invalid_argument);
  Tissue bad = kEnamel;
  bad.density = 0;
  EXPECT_THROW(BaseVectorField(tooth(), {bad, kDentin}, sphereWindow(kVoxel)),
               std::invalid_argument);
  WindowSettings none = sphereWindow(kVoxel, 0.01);
  EXPECT_THROW(BaseVectorField(tooth(), {kEnamel, kDentin}, none), std::invalid_argument);
  none = sphereWindow(kVoxel, 1000);
  EXPECT_THROW(BaseVectorField(tooth(), {kEnamel, kDentin}, none), std::length_error);
  BaseVectorField field(tooth(), {kEnamel, kDentin}, sphereWindow(kVoxel));
  const std::uint64_t before = field.hash();
  const VoxelCut cuts[] = {{{20, 20, 20}, 0}, {{20, 20, 40}, 0}};
  EXPECT_THROW(field.cut(cuts), std::out_of_range);
  EXPECT_EQ(field.hash(), before) << "nothing was cut";
}

TEST(Tissues, DentalTableAndItsErrors) {
  const TissueTable table = dentalTissues();
  validate(table);
  ASSERT_EQ(table.size(), 4u);
  EXPECT_GT(table[0].hardness, 3 * table[1].hardness) << "enamel HV 275, dentin 66";
  EXPECT_GT(table[1].hardness, table[3].hardness) << "caries is softer than dentin";
  EXPECT_EQ(tissuesOf(table, {"pulp", "enamel"})[0].name, "pulp");
  EXPECT_THROW(tissuesOf(table, {"bone"}), std::invalid_argument);
  EXPECT_THROW(dentalTissues(-1), std::invalid_argument);
  TissueTable twice = {kEnamel, kEnamel};
  EXPECT_THROW(validate(twice), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::base_vector_field_test
