// Sphere trees: every node encloses its subtree.
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/objects/sphere_tree.h>

#include "objects/test_objects.h"

namespace cloudcontact::sphere_tree_test {
namespace {

using namespace test;

std::vector<SphereTree> trees() {
  const Cloud nut = nutCloud();
  return {SphereTree(nut), SphereTree(inscribedSpheres(nut)), SphereTree(surfacePoints(nut)),
          SphereTree(centerPoints(nut, 2))};
}

TEST(SphereTree, NodesEncloseTheirSubtrees) {
  for (const SphereTree& tree : trees()) {
    const auto& nodes = tree.nodes();
    ASSERT_EQ(nodes.size(), 2 * tree.leaves().size() - 1);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].second == 0) {
        EXPECT_EQ(nodes[i].center, tree.leaves()[nodes[i].leaf].center);
        EXPECT_EQ(nodes[i].radius, tree.leaves()[nodes[i].leaf].radius);
        continue;
      }
      for (const std::size_t child : {i + 1, std::size_t{nodes[i].second}})
        EXPECT_LE((nodes[child].center - nodes[i].center).norm() + nodes[child].radius,
                  nodes[i].radius * (1 + 1e-9));
    }
    // Spheres around spheres grow: the root is at most twice the body (14.7 voxels from its middle
    // to its farthest corner).
    EXPECT_LT(nodes[0].radius, 2.1 * 14.7 * kH);
  }
}

// The tree of a cloud, or of points that fill one, gives the same body.
TEST(SphereTree, GivesTheSameBody) {
  for (const Cloud& cloud : {nutCloud(), twoMaterials()}) {
    expectSameVoxels(toCloud(SphereTree(cloud), kH), cloud);
    expectSameVoxels(toCloud(SphereTree(centerPoints(cloud)), kH), cloud);
  }
  const SphereCloud spheres = inscribedSpheres(nutCloud());
  expectSameVoxels(toCloud(SphereTree(spheres), kH), toCloud(spheres, kH));
  double volume = 0;
  const SphereCloud ofCubes = toSpheres(SphereTree(centerPoints(ballCloud(9))));
  for (const double r : ofCubes.radii) volume += 4 * std::numbers::pi / 3 * r * r * r;
  EXPECT_NEAR(volume / (double(ofCubes.radii.size()) * kH * kH * kH), 1, 1e-9);
}

TEST(SphereTree, ItemsAreTheSources) {
  const SphereCloud spheres = inscribedSpheres(nutCloud());
  const SphereTree tree(spheres);
  for (const SphereTree::Leaf& leaf : tree.leaves()) {
    EXPECT_EQ(leaf.center, spheres.centers[leaf.item]);
    EXPECT_EQ(leaf.radius, spheres.radii[leaf.item]);
  }
}

TEST(SphereTree, EmptyAndBadInput) {
  EXPECT_TRUE(SphereTree().empty());
  EXPECT_TRUE(SphereTree(Cloud()).empty());
  EXPECT_TRUE(SphereTree().nodes().empty());
  EXPECT_THROW(toCloud(SphereTree(), kH), std::invalid_argument);
  EXPECT_THROW(toCloud(SphereTree(surfacePoints(ballCloud(5))), kH), std::invalid_argument);
  const auto tree = [](SphereTree::Leaf leaf) {
    return SphereTree(SphereTree::Kind::Spheres, {leaf});
  };
  EXPECT_NO_THROW(tree({Vec3(0, 0, 0), 1, 1, 0, 0}));
  EXPECT_THROW(tree({Vec3(NAN, 0, 0), 1, 1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(tree({Vec3(0, 0, 0), -1, 1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(tree({Vec3(0, 0, 0), 1, 0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(tree({Vec3(0, 0, 0), 1, 1, 2, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::sphere_tree_test
