// Octrees: exact conversion both ways, merged cubes, and changes in place that equal a rebuild.
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/voxels/digitize.h>

#include <map>
#include <random>

#include "objects/test_objects.h"

namespace cloudcontact::octree_test {
namespace {

using namespace test;

TEST(Octree, ConvertsBackToTheCloud) {
  for (const Cloud& cloud : {ballCloud(10), nutCloud(), twoMaterials()}) {
    const Octree octree(cloud);
    expectSameVoxels(octree.cloud(), cloud);
    EXPECT_EQ(octree.cloud().origin(), cloud.origin());
    EXPECT_TRUE(Octree(octree.cloud()) == octree);
  }
}

// A cube of 16 voxels on a lattice of 16 is one leaf; the leaves of a ball grow with its surface.
TEST(Octree, MergesEqualCubes) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = {4, 4, 4};
  voxels->table.assign(64, kEmptyBrick);
  for (int b = 0; b < 8; ++b)
    voxels->table[(b & 1) + 4 * (b >> 1 & 1) + 16 * (b >> 2)] = kSolidBrick;
  const Octree octree(Cloud(1e-3, {0, 0, 0}, voxels));
  EXPECT_EQ(octree.cubes(), 8u);
  EXPECT_EQ(octree.at(Vector3i(3, 15, 9)).edge, 16);
  EXPECT_EQ(octree.at(Vector3i(3, 15, 9)).coverage, 255);
  EXPECT_EQ(octree.at(Vector3i(16, 0, 0)).coverage, 0);
  const double r = 20;
  const Octree ball(ballCloud(r));
  const VoxelCounts counts = ballCloud(r).counts();
  EXPECT_LT(ball.cubes(), 3 * counts.interface);
  EXPECT_LT(ball.cubes(), (counts.inside + counts.interface) / 2);
}

TEST(Octree, AgreesWithTheCloud) {
  const Cloud cloud = nutCloud();
  const Octree octree(cloud);
  const Vector3i size = cloud.size();
  for (int z = -1; z <= size.z(); ++z)
    for (int y = -1; y <= size.y(); ++y)
      for (int x = -1; x <= size.x(); ++x)
        ASSERT_EQ(octree.at({x, y, z}).coverage, cloud.coverage(x, y, z));
}

// All cubes that a box touches, each once, and few others visited.
TEST(Octree, FindsTheCubesInABox) {
  const Cloud cloud = ballCloud(12);
  const Octree octree(cloud);
  const double h = cloud.voxelSize();
  const auto boxOf = [&](const Octree::Cube& c) {
    const Vec3 low = cloud.origin() + h * c.low.cast<double>();
    return Eigen::AlignedBox3d(low, Vec3(low.array() + h * c.edge));
  };
  std::vector<Octree::Cube> all;
  octree.forEachIn({Vec3::Constant(-1), Vec3::Constant(1)},
                   [&](const Octree::Cube& c) { all.push_back(c); });
  double volume = 0;
  for (const Octree::Cube& c : all)
    volume += std::pow(c.edge * h, 3) * static_cast<double>(c.coverage) / 255;
  EXPECT_NEAR(volume, cloud.massProperties().volume, 1e-9 * volume);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-15 * h, 15 * h);
  for (int i = 0; i < 200; ++i) {
    Eigen::AlignedBox3d box(Vec3(at(random), at(random), at(random)));
    box.extend(Vec3(at(random), at(random), at(random)));
    std::size_t expected = 0, found = 0;
    for (const Octree::Cube& c : all) expected += boxOf(c).intersects(box);
    octree.forEachIn(box, [&](const Octree::Cube& c) {
      ++found;
      EXPECT_TRUE(boxOf(c).intersects(box));
    });
    EXPECT_EQ(found, expected);
  }
}

// Random changes, also back to the start: the tree always equals that of the changed voxels, with
// as many cubes.
TEST(Octree, ChangesInPlaceEqualARebuild) {
  const Cloud cloud = twoMaterials();
  Octree octree(cloud);
  const Octree first = octree;
  std::mt19937 random(7);
  std::map<int, std::pair<Vector3i, std::array<int, 2>>> before;
  const Vector3i size = cloud.size();
  for (int i = 0; i < 4000; ++i) {
    Vector3i v;
    for (int k = 0; k < 3; ++k)
      v[k] = size[k] / 3 + static_cast<int>(random() % static_cast<unsigned>(size[k] / 3));
    before.try_emplace(
        v[0] + size[0] * (v[1] + size[1] * v[2]), v,
        std::array<int, 2>{cloud.coverage(v[0], v[1], v[2]), cloud.material(v[0], v[1], v[2])});
    const unsigned what = random() % 4;
    octree.set(v, what == 0 ? 255 : what == 1 ? 100 : 0, static_cast<std::uint8_t>(random() % 2));
  }
  const Octree rebuilt(octree.cloud());
  EXPECT_TRUE(octree == rebuilt);
  EXPECT_EQ(octree.cubes(), rebuilt.cubes());
  EXPECT_FALSE(octree == first);
  for (const auto& [key, was] : before)
    octree.set(was.first, static_cast<std::uint8_t>(was.second[0]),
               static_cast<std::uint8_t>(was.second[1]));
  EXPECT_TRUE(octree == first);
  EXPECT_EQ(octree.cubes(), first.cubes());
}

TEST(Octree, RefusesBadVoxelsAndMaterials) {
  Octree octree(ballCloud(5));
  EXPECT_THROW(octree.set({-1, 0, 0}, 255), std::invalid_argument);
  EXPECT_THROW(octree.set({0, 0, octree.size()[2]}, 255), std::invalid_argument);
  EXPECT_THROW(octree.set({0, 0, 0}, 255, 1), std::invalid_argument);
  EXPECT_THROW(Octree().set({0, 0, 0}, 255), std::invalid_argument);
  EXPECT_EQ(Octree().cubes(), 0u);
  EXPECT_TRUE(Octree().cloud().empty());
  EXPECT_TRUE(Octree(Cloud()) == Octree());
}

}  // namespace
}  // namespace cloudcontact::octree_test
