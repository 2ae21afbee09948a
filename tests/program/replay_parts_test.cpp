// Parts of a replay: packed bytes, shaded meshes, voxel shells.
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <random>

#include "replay/page.h"
#include "replay/shaded_mesh.h"
#include "replay/voxel_shell.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program::replay_parts_test {
namespace {

// RFC 4648, section 10.
TEST(Packed, SpellsBase64) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(Packed, UnpacksToTheSameBytes) {
  std::mt19937 random(1);
  std::string bytes(100'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = char(i < 50'000 ? random() : i / 999);
  const std::string packed = deflated(bytes);
  EXPECT_LT(packed.size(), 60'000u);
  std::string back(bytes.size(), '\1');
  uLongf size = back.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(back.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  EXPECT_EQ(back, bytes);
}

TEST(ShadedMesh, ABoxHasFlatFaces) {
  const ShadedMesh box = shaded(primitiveMesh(Box{Vec3(1, 2, 3)}, 0.1));
  ASSERT_EQ(box.corners.size() % 3, 0u);
  for (std::size_t i = 0; i < box.corners.size(); i += 3) {
    const auto& a = box.positions[box.corners[i]];
    const Eigen::Vector3f across =
        (box.positions[box.corners[i + 1]] - a).cross(box.positions[box.corners[i + 2]] - a);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(box.normals[box.corners[i + std::size_t(k)]].dot(across.normalized()), 1, 1e-5);
  }
}

TEST(ShadedMesh, ASphereIsSmooth) {
  const Mesh mesh = primitiveMesh(Sphere{2}, 0.02);
  const ShadedMesh sphere = shaded(mesh);
  EXPECT_EQ(sphere.positions.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < sphere.positions.size(); ++i)
    EXPECT_GT(sphere.normals[i].dot(sphere.positions[i].normalized()), std::cos(0.02));
}

// Triangles without area still have a normal.
TEST(ShadedMesh, BadTrianglesHaveNormalsToo) {
  Mesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  mesh.triangles = {{0, 1, 2}, {0, 0, 1}};
  for (const auto& normal : shaded(mesh).normals) EXPECT_NEAR(normal.norm(), 1, 1e-6);
}

Cloud boxCloud(const Vec3& size, double voxel) {
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  return digitize(primitiveMesh(Box{size / 2}, 0.1 * voxel), settings);
}

// A cloud with full voxels up to a corner, and a layer of the given coverage beyond.
Cloud blockCloud(const Eigen::Vector3i& full, int beyond) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = Eigen::Vector3i(4, 3, 2);
  for (int brick = 0; brick < 4 * 3 * 2; ++brick) {
    const Eigen::Vector3i low = 8 * Eigen::Vector3i(brick % 4, brick / 4 % 3, brick / 12);
    BrickCoverage coverage{};
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Eigen::Vector3i at = low + Eigen::Vector3i(i % 8, i / 8 % 8, i / 64);
      if ((at.array() < full.array()).all())
        coverage[std::size_t(i)] = 255;
      else if ((at.array() <= full.array()).all())
        coverage[std::size_t(i)] = std::uint8_t(beyond);
    }
    const bool solid =
        std::all_of(coverage.begin(), coverage.end(), [](int c) { return c == 255; });
    voxels->table.push_back(solid ? kSolidBrick : std::int32_t(voxels->coverage.size()));
    if (!solid) voxels->coverage.push_back(coverage);
  }
  return Cloud(0.1, Vec3(1, 2, 3), voxels);
}

// The shell of a block is its outer layer, and the open faces are its surface.
TEST(VoxelShell, OfABlockIsItsOuterLayer) {
  const int nx = 20, ny = 13, nz = 9;
  const VoxelShell shell = voxelShell(blockCloud({nx, ny, nz}, 127));
  EXPECT_EQ(shell.x.size(), std::size_t(nx * ny * nz - (nx - 2) * (ny - 2) * (nz - 2)));
  std::map<int, int> sides;
  for (const std::uint8_t open : shell.open)
    for (int face = 0; face < 6; ++face) sides[face] += open >> face & 1;
  for (const int side : {0, 1}) {
    EXPECT_EQ(sides[side], ny * nz);
    EXPECT_EQ(sides[2 + side], nx * nz);
    EXPECT_EQ(sides[4 + side], nx * ny);
  }
  EXPECT_EQ(shell.origin, Vec3(1, 2, 3));
}

// Voxels that are half full count.
TEST(VoxelShell, CountsHalfFullVoxels) {
  const VoxelShell shell = voxelShell(blockCloud({20, 13, 9}, 128));
  EXPECT_EQ(shell.x.size(), std::size_t(21 * 14 * 10 - 19 * 12 * 8));
  EXPECT_EQ(std::count(shell.coverage.begin(), shell.coverage.end(), 128),
            21 * 14 * 10 - 20 * 13 * 9);
}

TEST(VoxelShell, OfALargeCloudIsInBlocks) {
  const Cloud cloud = boxCloud(Vec3(6.4, 6.4, 6.4), 0.1);
  const VoxelShell fine = voxelShell(cloud), coarse = voxelShell(cloud, 10'000);
  EXPECT_EQ(fine.block, 1);
  EXPECT_EQ(coarse.block, 2);
  EXPECT_DOUBLE_EQ(coarse.edge, 0.2);
  EXPECT_LE(coarse.x.size(), 10'000u);
  // The same body, with equal width and position.
  const auto span = [](const VoxelShell& s) {
    const auto [low, high] = std::minmax_element(s.x.begin(), s.x.end());
    return std::pair(s.origin.x() + s.edge * *low, s.origin.x() + s.edge * (*high + 1));
  };
  EXPECT_NEAR(span(fine).first, span(coarse).first, 0.11);
  EXPECT_NEAR(span(fine).second, span(coarse).second, 0.11);
}

}  // namespace
}  // namespace cloudcontact::program::replay_parts_test
