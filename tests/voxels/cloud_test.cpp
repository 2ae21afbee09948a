// Clouds made by hand: access, counts, mass properties, and input that the constructor refuses.
#include <cloudcontact/voxels/cloud.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

namespace cloudcontact::cloud_test {
namespace {

// 2 x 1 x 3 bricks: one with numbers, one solid, the rest empty.
std::shared_ptr<Cloud::Voxels> someVoxels() {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = {2, 1, 3};
  voxels->table = {kEmptyBrick, 0, kEmptyBrick, kSolidBrick, kEmptyBrick, kEmptyBrick};
  BrickCoverage brick{};
  brick[1 + 8 * (2 + 8 * 3)] = 100;
  brick[7 + 8 * (7 + 8 * 7)] = 255;
  voxels->coverage = {brick};
  return voxels;
}

TEST(Cloud, ReturnsItsVoxels) {
  const Cloud cloud(0.5, {1, 2, 3}, someVoxels());
  EXPECT_EQ(cloud.size(), Eigen::Vector3i(16, 8, 24));
  EXPECT_EQ(cloud.coverage(9, 2, 3), 100);
  EXPECT_EQ(cloud.coverage(15, 7, 7), 255);
  EXPECT_EQ(cloud.coverage(8, 0, 8), 255);
  EXPECT_EQ(cloud.coverage(7, 0, 8), 0);
  for (const Eigen::Vector3i& out :
       {Eigen::Vector3i(-1, 0, 0), Eigen::Vector3i(16, 0, 8), Eigen::Vector3i(9, 8, 9),
        Eigen::Vector3i(9, 0, 24), Eigen::Vector3i(9, -8, 9), Eigen::Vector3i(1 << 30, 0, 0)})
    EXPECT_EQ(cloud.coverage(out[0], out[1], out[2]), 0) << out.transpose();
  EXPECT_LT((cloud.center(0, 0, 0) - Vec3(1.25, 2.25, 3.25)).norm(), 1e-15);
  EXPECT_LT((cloud.center(9, 2, 3) - Vec3(5.75, 3.25, 4.75)).norm(), 1e-15);
  EXPECT_EQ(cloud.counts().inside, 512u + 1);
  EXPECT_EQ(cloud.counts().interface, 1u);
  EXPECT_GE(cloud.bytes(), 512u + 6 * 4);
}

TEST(Cloud, Empty) {
  const Cloud cloud;
  EXPECT_TRUE(cloud.empty());
  EXPECT_EQ(cloud.coverage(0, 0, 0), 0);
  EXPECT_EQ(cloud.counts().inside, 0u);
  EXPECT_EQ(cloud.massProperties().volume, 0);
  EXPECT_EQ(cloud.bytes(), 0u);
  EXPECT_EQ(cloud.size(), Eigen::Vector3i(0, 0, 0));
}

TEST(Cloud, MovedSharesItsVoxels) {
  const Cloud cloud(0.5, {1, 2, 3}, someVoxels());
  const Cloud moved = cloud.translated({10, 0, -1});
  EXPECT_EQ(&moved.voxels(), &cloud.voxels());
  EXPECT_LT((moved.origin() - Vec3(11, 2, 2)).norm(), 1e-15);
  EXPECT_LT(
      (moved.massProperties().centerOfMass - cloud.massProperties().centerOfMass - Vec3(10, 0, -1))
          .norm(),
      1e-12);
  EXPECT_THROW(cloud.translated({NAN, 0, 0}), std::invalid_argument);
}

// One solid brick is a cube, two in a row are a bar; also far from the origin.
TEST(Cloud, MassOfSolidBricks) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = {2, 1, 1};
  voxels->table = {kSolidBrick, kSolidBrick};
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(1000, -2000, 500)}) {
    const MassProperties mass = Cloud(0.25, at, voxels).massProperties();
    EXPECT_NEAR(mass.volume, 16, 1e-12);
    EXPECT_LT((mass.centerOfMass - at - Vec3(2, 1, 1)).norm(), 1e-9);
    const Eigen::Matrix3d truth = Vec3(16 / 12.0 * 8, 16 / 12.0 * 20, 16 / 12.0 * 20).asDiagonal();
    EXPECT_LT((mass.inertia - truth).norm(), 1e-9);
  }
}

// One voxel of 100/255: a small cube of that density.
TEST(Cloud, MassOfOneVoxel) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = {1, 1, 1};
  voxels->table = {0};
  voxels->coverage.resize(1);
  voxels->coverage[0].fill(0);
  voxels->coverage[0][3 + 8 * (4 + 8 * 5)] = 100;
  const MassProperties mass = Cloud(2, {0, 0, 0}, voxels).massProperties();
  EXPECT_NEAR(mass.volume, 8 * 100 / 255.0, 1e-12);
  EXPECT_LT((mass.centerOfMass - Vec3(7, 9, 11)).norm(), 1e-12);
  const Eigen::Matrix3d truth = mass.volume * 4 / 6 * Eigen::Matrix3d::Identity();
  EXPECT_LT((mass.inertia - truth).norm(), 1e-12);
}

TEST(Cloud, RefusesBadInput) {
  struct Bad {
    const char* name;
    double voxelSize;
    Vec3 origin;
    std::function<void(Cloud::Voxels&)> change;
    const char* message;
  };
  const auto nothing = [](Cloud::Voxels&) {};
  const Bad table[] = {
      {"zero size", 0, {0, 0, 0}, nothing, "voxelSize"},
      {"negative size", -1, {0, 0, 0}, nothing, "voxelSize"},
      {"NaN size", NAN, {0, 0, 0}, nothing, "voxelSize"},
      {"infinite size", INFINITY, {0, 0, 0}, nothing, "voxelSize"},
      {"NaN origin", 1, {0, NAN, 0}, nothing, "origin"},
      {"short table", 1, {0, 0, 0}, [](Cloud::Voxels& v) { v.table.pop_back(); }, "5 entries"},
      {"bad brick", 1, {0, 0, 0}, [](Cloud::Voxels& v) { v.table[0] = 1; }, "names brick 1"},
      {"bad code", 1, {0, 0, 0}, [](Cloud::Voxels& v) { v.table[0] = -3; }, "names brick -3"},
      {"negative", 1, {0, 0, 0}, [](Cloud::Voxels& v) { v.bricks[1] = -1; }, "negative"},
      {"huge", 1, {0, 0, 0}, [](Cloud::Voxels& v) { v.bricks.setConstant(2147483647); }, "bricks"},
  };
  for (const Bad& bad : table) {
    const auto voxels = someVoxels();
    bad.change(*voxels);
    try {
      const Cloud cloud(bad.voxelSize, bad.origin, voxels);
      ADD_FAILURE() << bad.name << " was accepted";
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(bad.message), std::string::npos)
          << bad.name << ": " << e.what();
    }
  }
  EXPECT_THROW(Cloud(1, {0, 0, 0}, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::cloud_test
