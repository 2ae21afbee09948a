// Display meshes: closed after any cut, of the right volume, and updated brick by brick.
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/display_mesh.h>
#include <gtest/gtest.h>

#include <numbers>
#include <set>
#include <stdexcept>

#include "workpiece/cut_cases.h"

namespace cloudcontact::testing::display_mesh_test {
namespace {

void expectClosed(const Mesh& mesh, const std::string& what) {
  const MeshReport report = inspect(mesh);
  EXPECT_EQ(report.openEdges, 0u) << what;
  EXPECT_EQ(report.overusedEdges, 0u) << what;
  EXPECT_EQ(report.degenerateTriangles, 0u) << what;
}

TEST(DisplayMesh, OfASphereIsClosedAndHasItsVolume) {
  for (const double radius : {15.0, 19.3}) {
    const Cloud cloud = cloudOf(ball({22.3, 22.1, 21.8}, radius), {6, 6, 6});
    const Mesh mesh = DisplayMesh(cloud, 1).mesh();
    expectClosed(mesh, "sphere");
    const double volume = 4 * std::numbers::pi / 3 * std::pow(1e-3 * radius, 3);
    EXPECT_NEAR(inspect(mesh).volume, volume, 0.005 * volume);
    const double area = 4 * std::numbers::pi * std::pow(1e-3 * radius, 2);
    EXPECT_NEAR(inspect(mesh).area, area, 0.03 * area);
  }
}

// Faces along the grid lie where coverage puts them, to the last bits of a float.
TEST(DisplayMesh, OfABoxLiesOnItsFaces) {
  const Cloud cloud = cloudOf(
      [](const Vec3& p) {
        return ((p - Vec3(12, 12, 12)).cwiseAbs().array() < Vec3(7.75, 6.25, 5).array()).all();
      },
      {3, 3, 3});
  const Mesh mesh = DisplayMesh(cloud, 1).mesh();
  expectClosed(mesh, "box");
  Eigen::AlignedBox3d box;
  for (const Vec3& p : mesh.vertices) box.extend((p - cloud.origin()) / cloud.voxelSize());
  EXPECT_LT((box.max() - Vec3(19.75, 18.25, 17)).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LT((box.min() - Vec3(4.25, 5.75, 7)).cwiseAbs().maxCoeff(), 0.01);
}

// Voxels that meet at edges and corners, and a grid that is full to its border.
TEST(DisplayMesh, IsClosedAfterAnyCut) {
  Random random(9);
  Cloud dust = cloudOf([](const Vec3&) { return true; }, {3, 2, 2});
  expectClosed(DisplayMesh(dust, 1).mesh(), "full grid");
  for (int k = 0; k < 4; ++k) {
    dust = cutCloud(dust, specks(dust, random, 900));
    const Mesh mesh = DisplayMesh(dust, 1).mesh();
    EXPECT_GT(mesh.triangles.size(), 4000u);
    expectClosed(mesh, "dust " + std::to_string(k));
    EXPECT_GT(inspect(mesh).volume, 0);
  }
}

void expectEqual(const DisplayMesh& a, const DisplayMesh& b, const std::string& what) {
  ASSERT_EQ(a.bricks(), b.bricks()) << what;
  for (int i = 0; i < a.bricks(); ++i) {
    ASSERT_EQ(a.brick(i) == nullptr, b.brick(i) == nullptr) << what;
    if (!a.brick(i)) continue;
    ASSERT_EQ(a.brick(i)->vertices, b.brick(i)->vertices) << what;
    ASSERT_EQ(a.brick(i)->triangles, b.brick(i)->triangles) << what;
    ASSERT_EQ(a.brick(i)->materials, b.brick(i)->materials) << what;
  }
}

TEST(DisplayMesh, UpdateEqualsARebuild) {
  Random random(11);
  Cloud cloud = cloudOf(tooth({20, 20, 22}), {5, 5, 5});
  DisplayMesh mesh(cloud, 1);
  for (int k = 0; k < 8; ++k) {
    const Vec3 at = random.inCube().cwiseProduct(cloud.size().cast<double>());
    cloud = cutCloud(
        cloud, k == 4 ? sawn(cloud, 15.9, 16.2) : bite(cloud, 0.5 * (at + Vec3(20, 20, 26)), 4));
    cloud = cloud.translated(Vec3(0, 0.01, 0));
    std::vector<const DisplayBrick*> before;
    for (int i = 0; i < mesh.bricks(); ++i) before.push_back(mesh.brick(i));
    const std::vector<int> made = mesh.renew(cloud);
    expectEqual(mesh, DisplayMesh(cloud, 2), "cut " + std::to_string(k));
    const std::set<int> rebuilt(made.begin(), made.end());
    for (int i = 0; i < mesh.bricks(); ++i)
      if (!rebuilt.count(i)) {
        ASSERT_EQ(mesh.brick(i), before[i]) << "an unchanged brick must stay";
      }
    if (k != 4) {
      EXPECT_LE(made.size(), 64u) << "a ball of 8 voxels is in at most 3 bricks along an axis";
    }
    expectClosed(mesh.mesh(), "cut " + std::to_string(k));
  }
}

// Two halves of two materials: each triangle has the material of the voxels under it.
TEST(DisplayMesh, KnowsMaterials) {
  const Cloud one = cloudOf(ball({12, 12, 12}, 9), {3, 3, 3});
  auto voxels = std::make_shared<Cloud::Voxels>(one.voxels());
  voxels->materials = {"left", "right"};
  for (std::size_t t = 0; t < voxels->table.size(); ++t)
    voxels->materialTable.push_back(t % 3 == 0 ? -1 : -2);
  const Cloud cloud(one.voxelSize(), one.origin(), voxels);
  std::vector<std::uint8_t> materials;
  const Mesh mesh = DisplayMesh(cloud, 1).mesh(&materials);
  ASSERT_EQ(materials.size(), mesh.triangles.size());
  int right = 0;
  for (std::size_t k = 0; k < materials.size(); ++k) {
    Vec3 middle = Vec3::Zero();
    for (int i = 0; i < 3; ++i) middle += mesh.vertices[mesh.triangles[k][i]] / 3;
    const double x = (middle.x() - cloud.origin().x()) / cloud.voxelSize();
    if (std::abs(x - 8) > 1) {
      ASSERT_EQ(materials[k], x > 8 ? 1 : 0);
    }
    right += materials[k];
  }
  EXPECT_GT(right, int(materials.size() / 2));
}

TEST(DisplayMesh, RefusesBadInput) {
  EXPECT_THROW(DisplayMesh{Cloud()}, std::invalid_argument);
  DisplayMesh mesh(cloudOf(ball({12, 12, 12}, 9), {3, 3, 3}), 1);
  EXPECT_THROW(mesh.renew(Cloud()), std::invalid_argument);
  EXPECT_THROW(mesh.renew(cloudOf(ball({12, 12, 12}, 9), {3, 3, 4})), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::display_mesh_test
