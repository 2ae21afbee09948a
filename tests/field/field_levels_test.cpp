// Fields of several voxel sizes: built when asked for, equal whoever asks, and each with the error
// of its surface.
#include <cloudcontact/field/field_levels.h>
#include <cloudcontact/voxels/coarser_cloud.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "contact/contact_cases.h"
#include "field/level_error.h"
#include "field/mesh_field.h"
#include "mesh/thread_meshes.h"

namespace field_levels_test {

namespace ct = cloudcontact::testing;
using namespace cloudcontact;

namespace {

constexpr double kVoxel = 0.5e-3;

Cloud cloudOf(const Mesh& mesh, double voxel = kVoxel) {
  DigitizeSettings how;
  how.voxelSize = voxel;
  how.threads = 1;
  return digitize(mesh, how);
}

FieldSettings alone() {
  FieldSettings how;
  how.threads = 1;
  return how;
}

Mesh turned(const Mesh& mesh) {
  return ct::transformed(mesh,
                         Pose{Eigen::Quaterniond(0.9, 0.3, 0.2, 0.25).normalized(), Vec3::Zero()});
}

TEST(FieldLevels, BuildWhatIsAskedForAndNoMore) {
  const FieldLevels levels(cloudOf(ct::sphereMesh(16e-3, 1e-6)), alone());
  ASSERT_EQ(levels.count(), 4) << "64 voxels across: 64, 32, 16, 8";
  EXPECT_EQ(levels.coarsest(0.3e-3), 3);
  EXPECT_TRUE(levels.isBuilt(3));
  const std::size_t coarse = levels.bytes();
  for (const int level : {0, 1, 2}) EXPECT_FALSE(levels.isBuilt(level)) << level;
  EXPECT_DOUBLE_EQ(levels.field(3)->cloud().voxelSize(), 8 * kVoxel);
  EXPECT_DOUBLE_EQ(levels.voxelSize(3), 8 * kVoxel);
  levels.field(0);
  EXPECT_GT(levels.bytes(), 10 * coarse);
  EXPECT_FALSE(levels.isBuilt(1));
}

TEST(FieldLevels, AreTheSameWhoeverAsksFirst) {
  const Cloud cloud = cloudOf(turned(ct::boxMesh({20e-3, 14e-3, 12e-3})));
  const FieldLevels one(cloud, alone()), other(cloud, alone());
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < 5; ++k)
      threads.emplace_back([&other, k] {
        for (int i = 0; i < other.count(); ++i) other.error((k + i) % other.count());
      });
  }
  for (int level = 0; level < one.count(); ++level) {
    EXPECT_EQ(one.field(level)->hash(), other.field(level)->hash());
    EXPECT_EQ(one.error(level), other.error(level));
  }
}

// A plane through a cube, by summing up a fine grid of points.
TEST(LevelError, FindsAPlaneByItsCoverage) {
  ct::Random random(5);
  for (int k = 0; k < 12; ++k) {
    const Vec3 n = k == 0 ? Vec3(0, -1, 0) : Vec3(random.rotation() * Vec3::UnitX());
    const double depth = random.uniform(-0.3, 0.3);
    constexpr int kParts = 60;
    int inside = 0;
    for (int i = 0; i < kParts * kParts * kParts; ++i) {
      const Vec3 x =
          (Vec3(i % kParts, i / kParts % kParts, i / kParts / kParts) + Vec3::Constant(0.5)) /
              kParts -
          Vec3::Constant(0.5);
      inside += n.dot(x) < depth;
    }
    const double share = double(inside) / (kParts * kParts * kParts);
    EXPECT_NEAR(depthByCoverage(n, share), depth, 0.6 / kParts) << n.transpose();
  }
}

// The true surface, in places that no voxel knows, is where the level says, within its error. At
// edges the depth of a place beside the edge may be that of another face.
TEST(FieldLevels, StateTheErrorOfTheirSurface) {
  const double radius = 16e-3;
  const FieldLevels ball(cloudOf(ct::sphereMesh(radius, 1e-6)), alone());
  ct::Random random(11);
  for (int level = 1; level < ball.count(); ++level) {
    double squares = 0, most = 0;
    constexpr int kPlaces = 2000;
    for (int k = 0; k < kPlaces; ++k) {
      const auto at = ball.field(level)->at(random.rotation() * Vec3(radius, 0, 0));
      ASSERT_TRUE(at);
      squares += at->depth * at->depth / kPlaces;
      most = std::max(most, std::abs(at->depth));
    }
    EXPECT_LT(std::sqrt(squares), ball.error(level)) << level;
    EXPECT_LT(most, 4 * ball.error(level)) << level;
    EXPECT_LT(ball.error(level), 6 * std::sqrt(squares) + 0.05 * kVoxel) << level;
  }
}

TEST(FieldLevels, KnowWhereTheyDoNotSeeAFeature) {
  // 16, 8 and 4 voxels a pitch.
  const Thread thread{8e-3, 4e-3, 2e-3};
  const FieldLevels rod(cloudOf(threadedRod(thread, 24e-3), 0.25e-3), alone());
  const Eigen::AlignedBox3d middle(Vec3(-1, -1, -8e-3), Vec3(1, 1, 8e-3));
  EXPECT_LT(rod.error(1, middle), 0.15 * thread.depth);
  EXPECT_GT(rod.error(2, middle), 0.2 * thread.depth);
  EXPECT_GT(rod.error(1), rod.error(1, middle)) << "the ends' slivers are not seen";
  // 7.5, 3.8, 1.9 and 0.9 voxels thick.
  const FieldLevels thin(cloudOf(turned(ct::boxMesh({20e-3, 16e-3, 1.5e-3})), 0.2e-3), alone());
  ASSERT_EQ(thin.count(), 4);
  EXPECT_LT(thin.error(1), 0.1e-3);
  EXPECT_LT(thin.error(2), 0.2e-3);
  EXPECT_GT(thin.error(3), 0.5e-3) << "its other side is nearer than a voxel";
}

TEST(FieldLevels, KnowErrorsPlaceByPlace) {
  // A slot of 3 voxels' width in one end of a long block.
  const auto inside = [](const Eigen::Vector3i& v) {
    const bool block = (v.array() >= 3).all() && v.x() < 93 && v.y() < 37 && v.z() < 37;
    const bool slot = v.x() > 80 && v.y() >= 20 && v.y() < 23;
    return block && !slot;
  };
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = {12, 5, 5};
  for (int b = 0; b < 12 * 25; ++b) {
    BrickCoverage brick;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Eigen::Vector3i v(8 * (b % 12) + (k & 7), 8 * (b / 12 % 5) + (k >> 3 & 7),
                              8 * (b / 60) + (k >> 6));
      brick[static_cast<std::size_t>(k)] = inside(v) ? 255 : 0;
    }
    voxels->table.push_back(b);
    voxels->coverage.push_back(brick);
  }
  const FieldLevels levels(Cloud(1e-3, Vec3::Zero(), voxels), alone());
  const Eigen::AlignedBox3d plain(Vec3(0, 0, 0), Vec3(0.04, 0.04, 0.04)),
      slotted(Vec3(0.082, 0, 0), Vec3(0.1, 0.04, 0.04));
  EXPECT_LT(levels.error(2, plain), 0.5e-3);
  EXPECT_GT(levels.error(2, slotted), 1e-3);
  EXPECT_EQ(levels.error(2), levels.error(2, slotted));
  EXPECT_EQ(levels.error(2, Eigen::AlignedBox3d(Vec3(1, 1, 1), Vec3(2, 2, 2))), 0);
}

TEST(FieldLevels, AreScaledWithTheirBody) {
  const auto small = std::make_shared<const FieldLevels>(
      cloudOf(turned(ct::boxMesh({20e-3, 14e-3, 12e-3}))), alone());
  const FieldLevels large(small, 3);
  EXPECT_EQ(large.count(), small->count());
  for (const int level : {1, 2}) {
    EXPECT_DOUBLE_EQ(large.voxelSize(level), 3 * small->voxelSize(level));
    EXPECT_DOUBLE_EQ(large.error(level), 3 * small->error(level));
    EXPECT_DOUBLE_EQ(large.field(level)->cloud().voxelSize(), large.voxelSize(level));
  }
  EXPECT_FALSE(small->isBuilt(0));
}

TEST(FieldLevels, RefuseAnEmptyBody) {
  EXPECT_THROW(FieldLevels{Cloud()}, std::invalid_argument);
  EXPECT_THROW(FieldLevels(std::shared_ptr<const SurfaceField>()), std::invalid_argument);
}

}  // namespace

}  // namespace field_levels_test
