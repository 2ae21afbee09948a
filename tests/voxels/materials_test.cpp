// Bodies of several materials, from nested meshes.
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/voxels/cloud_file.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "mesh/test_meshes.h"

namespace cloudcontact::materials_test {
namespace {

constexpr double kVoxel = 0.01;

// A block of 0.3 x 0.3 x 0.2 with a core, and a pocket in the core. Voxels that an inner face cuts
// are inside by eight tenths at the low faces and by two tenths at the high ones.
std::vector<NamedMesh> nested() {
  return {{"shell", test::boxMesh(Vec3(0, 0, 0), Vec3(0.3, 0.3, 0.2))},
          {"core", test::boxMesh(Vec3(0.032, 0.032, 0.052), Vec3(0.262, 0.262, 0.142))},
          {"pocket", test::boxMesh(Vec3(0.102, 0.102, 0.082), Vec3(0.192, 0.152, 0.112))}};
}

DigitizeSettings settings() {
  DigitizeSettings s;
  s.voxelSize = kVoxel;
  return s;
}

std::map<std::string, double> volumes(const Cloud& cloud) {
  std::map<std::string, double> sums;
  const Eigen::Vector3i n = cloud.size();
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x)
        if (const int c = cloud.coverage(x, y, z))
          sums[cloud.materials()[cloud.material(x, y, z)]] += c / 255.0 * std::pow(kVoxel, 3);
  return sums;
}

std::string materialAt(const Cloud& cloud, const Vec3& place) {
  const Eigen::Vector3i v =
      ((place - cloud.origin()) / cloud.voxelSize()).array().floor().cast<int>();
  return cloud.materials()[cloud.material(v.x(), v.y(), v.z())];
}

// Boundaries between materials run along voxel faces: two tenths of a voxel outside the mesh at the
// low faces and two tenths inside at the high ones, which cancels.
TEST(Materials, HaveTheirVolumes) {
  const Cloud cloud = digitize(nested(), settings());
  ASSERT_EQ(cloud.materials(), (std::vector<std::string>{"shell", "core", "pocket"}));
  const auto v = volumes(cloud);
  const double block = 0.3 * 0.3 * 0.2, core = 0.23 * 0.23 * 0.09, pocket = 0.09 * 0.05 * 0.03;
  EXPECT_NEAR(v.at("pocket"), pocket, 1e-3 * pocket);
  EXPECT_NEAR(v.at("core") + v.at("pocket"), core, 1e-3 * core);
  EXPECT_NEAR(v.at("shell") + v.at("core") + v.at("pocket"), block, 1e-4 * block);
  EXPECT_EQ(materialAt(cloud, Vec3(0.015, 0.15, 0.1)), "shell");
  EXPECT_EQ(materialAt(cloud, Vec3(0.05, 0.05, 0.1)), "core");
  EXPECT_EQ(materialAt(cloud, Vec3(0.15, 0.13, 0.1)), "pocket");
}

TEST(Materials, DoNotDependOnTheOrderOfTheMeshes) {
  auto meshes = nested();
  const Cloud one = digitize(meshes, settings());
  std::reverse(meshes.begin(), meshes.end());
  const Cloud other = digitize(meshes, settings());
  EXPECT_EQ(volumes(one), volumes(other));
}

// Materials do not change coverage.
TEST(Materials, DoNotChangeCoverage) {
  const Cloud with = digitize(nested(), settings());
  const Cloud without = digitize(merged(nested()), settings());
  EXPECT_EQ(with.voxels().table, without.voxels().table);
  EXPECT_EQ(with.voxels().coverage, without.voxels().coverage);
  EXPECT_TRUE(without.materials().empty());
  EXPECT_EQ(without.material(10, 10, 10), 0);
}

// Half a shell bounds no volume; the other meshes keep their materials.
TEST(Materials, PartsWithoutAVolumeBelongToTheLargest) {
  auto meshes = nested();
  Mesh& shell = meshes[0].mesh;
  NamedMesh lid{"lid", shell};
  lid.mesh.triangles.assign(shell.triangles.begin(), shell.triangles.begin() + 2);
  shell.triangles.erase(shell.triangles.begin(), shell.triangles.begin() + 2);
  meshes.push_back(lid);
  const Cloud cloud = digitize(meshes, settings());
  EXPECT_EQ(materialAt(cloud, Vec3(0.15, 0.13, 0.1)), "pocket");
  EXPECT_EQ(materialAt(cloud, Vec3(0.15, 0.15, 0.005)), "shell");
  EXPECT_EQ(materialAt(cloud, Vec3(0.15, 0.15, 0.195)), "shell");
  EXPECT_EQ(std::count(cloud.materials().begin(), cloud.materials().end(), "lid"), 0);
}

TEST(Materials, StandSideBySide) {
  const Cloud cloud = digitize({{"left", test::boxMesh({0, 0, 0}, {0.1, 0.1, 0.1})},
                                {"right", test::boxMesh({0.15, 0, 0}, {0.35, 0.1, 0.1})}},
                               settings());
  EXPECT_EQ(materialAt(cloud, Vec3(0.05, 0.05, 0.05)), "left");
  EXPECT_EQ(materialAt(cloud, Vec3(0.2, 0.05, 0.05)), "right");
}

// The bounded volume decides which mesh is inside, even where its faces are doubled.
TEST(Materials, ADoubledCoreStaysInItsShell) {
  auto meshes = nested();
  Mesh& core = meshes[1].mesh = test::boxMesh({0.02, 0.02, 0.02}, {0.28, 0.28, 0.18});
  const auto once = core.triangles;
  core.triangles.insert(core.triangles.end(), once.begin(), once.end());
  const Cloud cloud = digitize(meshes, settings());
  EXPECT_EQ(materialAt(cloud, Vec3(0.05, 0.05, 0.1)), "core");
  EXPECT_EQ(materialAt(cloud, Vec3(0.005, 0.15, 0.1)), "shell");
}

// Intersecting bodies: the smaller has the bricks that both fill, and no brick is stored in vain.
TEST(Materials, BricksAreStoredOnce) {
  const Cloud cloud = digitize({{"long", test::boxMesh({0, 0, 0}, {0.64, 0.16, 0.16})},
                                {"half", test::boxMesh({0.2, 0, 0}, {0.64, 0.16, 0.16})},
                                {"cross", test::boxMesh({0.08, 0, 0}, {0.4, 0.16, 0.16})}},
                               settings());
  const auto& table = cloud.voxels().materialTable;
  for (std::size_t b = 0; b < cloud.voxels().material.size(); ++b)
    EXPECT_EQ(std::count(table.begin(), table.end(), std::int32_t(b)), 1);
  EXPECT_EQ(materialAt(cloud, Vec3(0.21, 0.08, 0.08)), "cross");
}

TEST(Materials, OfAnEmptyCloudAreNone) {
  EXPECT_TRUE(Cloud().materials().empty());
}

TEST(Materials, RefuseBadTables) {
  EXPECT_THROW(digitize(std::vector<NamedMesh>{}, settings()), std::invalid_argument);
  const Cloud cloud = digitize(nested(), settings());
  const auto broken = [&](auto breakIt) {
    auto voxels = std::make_shared<Cloud::Voxels>(cloud.voxels());
    breakIt(*voxels);
    return [voxels] { Cloud(kVoxel, Vec3::Zero(), voxels); };
  };
  EXPECT_THROW(broken([](Cloud::Voxels& v) { v.materialTable.pop_back(); })(),
               std::invalid_argument);
  EXPECT_THROW(broken([](Cloud::Voxels& v) { v.materialTable[0] = -4; })(), std::invalid_argument);
  EXPECT_THROW(broken([](Cloud::Voxels& v) { v.materialTable[0] = 1 << 20; })(),
               std::invalid_argument);
  EXPECT_THROW(broken([](Cloud::Voxels& v) { v.material.at(0)[5] = 3; })(), std::invalid_argument);
  EXPECT_THROW(broken([](Cloud::Voxels& v) { v.materials[1] = std::string("a\0b", 3); })(),
               std::invalid_argument);
}

class MaterialFile : public ::testing::Test {
 protected:
  MaterialFile() {
    folder = std::filesystem::temp_directory_path() /
             (std::string("cloudcontact_materials_") +
              ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
              std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    std::filesystem::create_directories(folder);
  }
  ~MaterialFile() override { std::filesystem::remove_all(folder); }
  std::filesystem::path folder;
};

TEST_F(MaterialFile, KeepsThem) {
  const Cloud cloud = digitize(nested(), settings());
  saveCloud(cloud, folder / "a.cloud");
  const Cloud back = loadCloud(folder / "a.cloud");
  EXPECT_EQ(back.materials(), cloud.materials());
  EXPECT_EQ(back.voxels().materialTable, cloud.voxels().materialTable);
  EXPECT_EQ(back.voxels().material, cloud.voxels().material);
  EXPECT_EQ(volumes(back), volumes(cloud));
}

// A file that is truncated anywhere, or has any byte changed, is refused.
TEST_F(MaterialFile, BrokenIsRefused) {
  saveCloud(digitize(nested(), settings()), folder / "a.cloud");
  std::ifstream in(folder / "a.cloud", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const auto refused = [&](const std::string& text) {
    std::ofstream(folder / "b.cloud", std::ios::binary) << text;
    EXPECT_THROW(loadCloud(folder / "b.cloud"), std::runtime_error);
  };
  for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 40)
    refused(bytes.substr(0, length));
  for (std::size_t at = 0; at < bytes.size(); at += at < 120 ? 1 : 1 + bytes.size() / 40) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x40);
    refused(changed);
  }
}

TEST_F(MaterialFile, PartsOfAMeshFileHaveTheirNames) {
  std::ofstream out(folder / "two.obj");
  int base = 0;
  for (const NamedMesh& part : nested()) {
    out << "o " << part.name << '\n';
    for (const Vec3& v : part.mesh.vertices) out << "v " << v.transpose() << '\n';
    for (const auto& t : part.mesh.triangles)
      out << "f " << (t.array() + 1 + base).matrix().transpose() << '\n';
    base += static_cast<int>(part.mesh.vertices.size());
  }
  out.close();
  const auto parts = loadMeshParts(folder / "two.obj");
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].name, "shell");
  EXPECT_EQ(parts[2].name, "pocket");
  EXPECT_EQ(loadMesh(folder / "two.obj").triangles.size(), 36u);
}

}  // namespace
}  // namespace cloudcontact::materials_test
