// Beyond an edge a side's plane is not the body's surface. Samples under a box, just outside its
// bottom edges, stand across the extended sides and must not be pushed by them.
#include <gtest/gtest.h>

#include <cloudcontact/contact/contact_finder.h>

#include <numbers>

#include "field/mesh_field.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::testing::edge_sides_test {
namespace {

constexpr double kVoxel = 0.1, kHalf = 0.5, kStiffness = 1e4;

class EdgeSides : public ::testing::TestWithParam<double> {
 protected:
  // A block on a slab, turned about the vertical, its bottom `depth` voxels below the slab's top.
  double push(double depth, const Vec3& aside, bool swapped) {
    static const auto slab =
        fieldOf(test::boxMesh(Vec3(-1.5, -1.5, -1), Vec3(1.5, 1.5, 0)), kVoxel);
    static const auto block =
        fieldOf(test::boxMesh(-kHalf * Vec3::Ones(), kHalf * Vec3::Ones()), kVoxel);
    ContactBody low{slab.get(), nullptr, {}, {}}, high{block.get(), nullptr, {}, {}};
    high.pose.position = aside + (kHalf - depth * kVoxel) * Vec3::UnitZ();
    high.pose.orientation = Eigen::AngleAxisd(GetParam() * std::numbers::pi / 180, Vec3::UnitZ());
    ContactSettings settings;
    settings.law = KelvinVoigt{kStiffness, 0};
    const ContactResult contact =
        finder_.find(swapped ? high : low, swapped ? low : high, settings);
    Vec3 sum = Vec3::Zero();
    for (const ContactPoint& p : contact.points) sum += p.stiffness * p.depth * p.normal;
    return sum.norm() / (kStiffness * kVoxel);
  }
  ContactFinder finder_;
};

// The weights of two such samples in a million would do: the pair's stiffness is theirs.
TEST_P(EdgeSides, PushNothingThatLiesBelowThem) {
  for (const double shift : {0.0, 0.013, 0.3, 0.31})
    for (const double gap : {0.01, 0.05, 0.1})
      for (const bool swapped : {false, true})
        EXPECT_EQ(push(-gap, Vec3(shift, 0.7 * shift, 0), swapped), 0) << shift << ' ' << gap;
}

TEST_P(EdgeSides, DoNotAddToTheFaces) {
  for (const double shift : {0.0, 0.013, 0.3, 0.31})
    for (const double depth : {0.05, 0.1, 0.3})
      for (const bool swapped : {false, true})
        EXPECT_NEAR(push(depth, Vec3(shift, 0.7 * shift, 0), swapped), depth, 0.01)
            << shift << ' ' << depth;
}

INSTANTIATE_TEST_SUITE_P(Degrees, EdgeSides, ::testing::Values(0.0, 0.1, 1.0, 3.0, 10.0, 45.0));

}  // namespace
}  // namespace cloudcontact::testing::edge_sides_test
