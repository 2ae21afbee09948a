// A device cuts a workpiece to the same bits as the CPU.
#include <cloudcontact/device/device_workpiece.h>
#include <cloudcontact/workpiece/cloud_solid.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>

#include "device/skip_without_device.h"
#include "field/base_vector_bricks.h"
#include "mesh/test_meshes.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::test::device_workpiece_test {
namespace {

constexpr double kVoxel = 1e-4;  // [m]
const Tissue kEnamel{"enamel", 2e4, .4, 3e9, 2970}, kDentin{"dentin", 5e3, .1, 6e8, 2140},
    kPulp{"pulp", 1e3, .1, 1e6, 1000}, kFilling{"filling", 2e4, .4, 3e9, 2140};

struct Piece {
  Cloud cloud;
  TissueTable tissues;
  WindowSettings window;

  BaseVectorField field() const { return BaseVectorField(cloud, tissues, window); }
};

// Bricks deep inside share their window sums.
Piece ball(const WindowSettings& window = sphereWindow(kVoxel)) {
  return {ballCloud(kVoxel, 7, Vec3(28.2, 27.9, 28.1), 27), {kEnamel}, window};
}

Piece tooth(const WindowSettings& window = sphereWindow(kVoxel)) {
  return {
      ballCloud(kVoxel, 5, Vec3(20.3, 19.6, 20.1), 16.4, {"enamel", "dentin", "pulp", "filling"},
                [](int x, int y, int z) {
                  const double r = (Vec3(x, y, z) - Vec3(20, 20, 20)).norm();
                  return r > 13 ? 0 : r < 4 ? 2 : x > 20 ? 3 : 1;
                }),
      {kEnamel, kDentin, kPulp, kFilling},
      window};
}

// Fills the whole grid.
Piece block(const Eigen::Vector3i& bricks) {
  return {smallCloud(kVoxel, bricks, [](int, int, int) { return 255; }),
          {kEnamel},
          sphereWindow(kVoxel)};
}

// Compares every voxel's sums, coverage and tissue, in shared and own blocks.
void expectSame(const BaseVectorField& got, const BaseVectorField& want) {
  const BaseVectorField::Bricks &g = got.bricks(), &w = want.bricks();
  ASSERT_EQ(g.table.size(), w.table.size());
  for (std::size_t e = 0; e < g.table.size(); ++e) {
    ASSERT_EQ(g.table[e] == kNoBlock, w.table[e] == kNoBlock) << "brick " << e;
    if (g.table[e] == kNoBlock) continue;
    ASSERT_EQ(std::memcmp(&g.blocks[std::size_t(g.table[e])], &w.blocks[std::size_t(w.table[e])],
                          sizeof(FieldBlock)),
              0)
        << "brick " << e;
  }
  EXPECT_EQ(got.hash(), want.hash());
  EXPECT_EQ(got.mass().mass, want.mass().mass);
  EXPECT_EQ(got.mass().inertia, want.mass().inertia);
  const Cloud a = got.cloud(), b = want.cloud();
  EXPECT_EQ(a.voxels().table, b.voxels().table);
  EXPECT_EQ(a.voxels().coverage, b.voxels().coverage);
  EXPECT_EQ(a.voxels().materialTable, b.voxels().materialTable);
  EXPECT_EQ(a.voxels().material, b.voxels().material);
  const Eigen::Vector3i middle = want.size() / 2;
  for (int x = 0; x < want.size().x(); ++x)
    EXPECT_EQ(got.depth({x, middle.y(), middle.z()}), want.depth({x, middle.y(), middle.z()}));
}

// Makes the same cuts on the CPU and on a device. Compiling for the device is slow, so each test
// has one of these.
struct Both {
  BaseVectorField cpu;
  DeviceWorkpiece device;

  explicit Both(const Piece& piece)
      : cpu(piece.field()), device(piece.field(), {Backend::OpenCl}) {}

  void cut(Span<const VoxelCut> cuts) { EXPECT_EQ(device.cut(cuts), cpu.cut(cuts)); }
  void compare() const {
    expectSame(device.field(), cpu);
    const MassProperties got = device.mass(), want = cpu.mass();
    EXPECT_EQ(got.volume, want.volume);
    EXPECT_EQ(got.mass, want.mass);
    EXPECT_EQ(got.centerOfMass, want.centerOfMass);
    EXPECT_EQ(got.inertia, want.inertia);
  }
};

#define MAKE_BOTH(both, piece) \
  Both both(piece);            \
  SKIP_WITHOUT(both.device)

std::vector<VoxelCut> boxOf(const VoxelIndex& low, const VoxelIndex& high, int left) {
  std::vector<VoxelCut> cuts;
  for (int z = low.z(); z < high.z(); ++z)
    for (int y = low.y(); y < high.y(); ++y)
      for (int x = low.x(); x < high.x(); ++x)
        cuts.push_back({{x, y, z}, static_cast<std::uint8_t>(left)});
  return cuts;
}

// A cluster of voxels in random order, some listed repeatedly, cut fully or in part.
std::vector<VoxelCut> cluster(std::mt19937& random, int edge) {
  std::uniform_int_distribution<int> place(0, edge - 1), size(1, 400), left(0, 254), wide(3, 12);
  std::vector<VoxelCut> cuts;
  const VoxelIndex middle(place(random), place(random), place(random));
  const int reach = wide(random);
  for (int k = size(random); k > 0; --k)
    cuts.push_back(
        {(middle + VoxelIndex(place(random) % reach, place(random) % reach, place(random) % reach))
             .cwiseMin(edge - 1),
         static_cast<std::uint8_t>(k % 3 ? 0 : left(random))});
  return cuts;
}

TEST(DeviceCut, OneCutAcrossBricks) {
  MAKE_BOTH(both, ball());
  both.compare();  // before any cut
  const std::vector<std::int32_t>& table = both.cpu.bricks().table;
  EXPECT_GT(std::count(table.begin(), table.end(), 0), 0) << "no brick shares the full windows";
  // From outside the material to the center, where bricks share a block.
  both.cut(boxOf({20, 27, 0}, {37, 34, 30}, 0));
  EXPECT_GT(both.device.report().changed, 1000u);
  EXPECT_GT(both.device.report().bricks, 20u);
  both.compare();
}

TEST(DeviceCut, FiftyRandomCuts) {
  MAKE_BOTH(both, ball());
  std::mt19937 random(7);
  std::vector<std::vector<VoxelCut>> cuts;
  for (int k = 0; k < 50; ++k) cuts.push_back(cluster(random, 56));
  std::sort(cuts.begin(), cuts.end(),
            [](const auto& a, const auto& b) { return a.size() > b.size(); });
  both.cut(cuts[0]);
  both.cut(cuts[1]);
  const std::size_t bytes = both.device.deviceBytes();
  EXPECT_GT(bytes, both.cpu.bytes());
  for (int k = 2; k < 50; ++k) both.cut(cuts[std::size_t(k)]);
  EXPECT_EQ(both.device.deviceBytes(), bytes) << "a step allocated memory";
  both.compare();
}

// Four tissues, two of equal density; each cut goes through several.
TEST(DeviceCut, SeveralTissues) {
  MAKE_BOTH(both, tooth());
  std::mt19937 random(5);
  for (int k = 0; k < 20; ++k) both.cut(cluster(random, 40));
  both.cut(boxOf({10, 18, 18}, {30, 23, 22}, 80));
  both.cut(boxOf({10, 18, 18}, {30, 23, 22}, 0));
  both.compare();
}

// At the edge of the grid, and then everything.
TEST(DeviceCut, EdgesAndEverything) {
  MAKE_BOTH(both, block({4, 3, 5}));
  both.cut(boxOf({0, 0, 0}, {32, 1, 40}, 13));
  both.cut(boxOf({31, 0, 0}, {32, 24, 40}, 0));
  both.cut(boxOf({0, 23, 39}, {1, 24, 40}, 0));
  both.compare();
  both.cut(boxOf({0, 0, 0}, {32, 24, 40}, 0));
  both.compare();
  EXPECT_EQ(both.device.field().mass().volume, 0);
  both.cut(boxOf({0, 0, 0}, {32, 24, 40}, 0));
  EXPECT_EQ(both.device.report().changed, 0u);
}

// A workpiece without material.
TEST(DeviceCut, EmptyWorkpiece) {
  const auto empty = [] {
    Piece piece = block({2, 1, 3});
    BaseVectorField field = piece.field();
    field.cut(boxOf({0, 0, 0}, {16, 8, 24}, 0));
    piece.cloud = field.cloud();
    return piece;
  };
  MAKE_BOTH(both, empty());
  EXPECT_EQ(std::count(both.cpu.bricks().table.begin(), both.cpu.bricks().table.end(), kNoBlock),
            6);
  both.compare();
  both.cut(boxOf({0, 0, 0}, {16, 8, 24}, 0));
  const PlacedSolid area = {Sphere{5 * kVoxel}};
  const Pose middle{Eigen::Quaterniond::Identity(), kVoxel * Vec3(8, 4, 12)};
  EXPECT_EQ(both.device.cut(area, middle), 0u);
  both.compare();
}

// A voxel's entries apply in order; those that would add material are ignored.
TEST(DeviceCut, VoxelsListedRepeatedly) {
  MAKE_BOTH(both, block({3, 3, 3}));
  std::vector<VoxelCut> cuts;
  for (const int left : {200, 220, 200, 100, 90, 120, 90, 255, 0, 30})
    cuts.push_back({{9, 10, 11}, static_cast<std::uint8_t>(left)});
  for (const int left : {0, 100, 0})
    cuts.push_back({{10, 10, 11}, static_cast<std::uint8_t>(left)});
  EXPECT_EQ(both.cpu.cut(cuts), 5u);
  EXPECT_EQ(both.device.cut(cuts), 5u);
  both.compare();
  std::mt19937 random(9);
  std::uniform_int_distribution<int> place(5, 11), left(0, 255);
  cuts.clear();
  for (int k = 0; k < 4000; ++k)
    cuts.push_back(
        {{place(random), place(random), place(random)}, static_cast<std::uint8_t>(left(random))});
  both.cut(cuts);
  both.compare();
  both.cut(boxOf({0, 0, 0}, {24, 24, 24}, 255));
  EXPECT_EQ(both.device.report().changed, 0u);
  both.compare();
}

// A list with one voxel over and over, as a tool at rest gives it: with falling coverage, in random
// order, and always the same. Comparing each entry with all others would take minutes.
TEST(DeviceCut, OneVoxelListed600000Times) {
  constexpr int kTimes = 600000;
  MAKE_BOTH(both, block({3, 3, 3}));
  std::mt19937 random(11);
  std::uniform_int_distribution<int> any(40, 254), place(0, 23);
  const auto cut = [&](const VoxelIndex& often, const std::function<int(int)>& left) {
    std::vector<VoxelCut> cuts;
    for (int k = 0; k < kTimes; ++k) {
      cuts.push_back({often, static_cast<std::uint8_t>(left(k))});
      if (k % 50 == 0) cuts.push_back({{place(random), place(random), place(random)}, 7});
    }
    both.cut(cuts);
  };
  cut({9, 10, 11}, [&](int k) { return 254 - k * 254LL / kTimes; });
  cut({12, 10, 11}, [&](int) { return any(random); });
  cut({12, 10, 11}, [&](int k) { return k == kTimes - 1 ? 0 : any(random); });
  cut({15, 10, 11}, [](int) { return 0; });
  cut({16, 10, 11}, [](int) { return 254; });
  both.compare();
  // Around the number of repeats that one work-item follows.
  std::vector<VoxelCut> cuts;
  for (const int times : {63, 64, 65, 66})
    for (int k = 0; k < times; ++k)
      cuts.push_back({{2, 2, times - 60}, static_cast<std::uint8_t>(any(random))});
  both.cut(cuts);
  both.compare();
}

// More voxels than fit in a step. Each is listed 36 times, the last time in another step.
TEST(DeviceCut, AMillionVoxels) {
  MAKE_BOTH(both, block({4, 3, 5}));
  std::vector<VoxelCut> cuts;
  for (int k = 0; k < 36; ++k)
    for (const VoxelCut& c : boxOf({0, 0, 0}, {32, 24, 40}, k < 35 ? 250 - k * 37 % 101 - k : 3))
      cuts.push_back(c);
  ASSERT_GT(cuts.size(), std::size_t{1} << 20);
  both.cut(cuts);
  both.compare();
  cuts.push_back({{32, 0, 0}, 0});
  EXPECT_THROW(both.device.cut(cuts), std::out_of_range);
  both.compare();
}

// Windows that are wide or off center, or whose sums a float cannot hold.
TEST(DeviceCut, WindowsOfAnyShape) {
  WindowSettings offCenter = sphereWindow(kVoxel);
  offCenter.area = {Sphere{2.5 * kVoxel}, {.position = kVoxel * Vec3(4.3, -2.1, 0.4)}};
  WindowSettings far = sphereWindow(kVoxel);
  far.area = {Sphere{2.5 * kVoxel}, {.position = kVoxel * Vec3(-11.3, 2.1, 9.4)}};
  WindowSettings even{PlacedSolid{Sphere{4.2 * kVoxel}}, WindowWeight::Even, Vec3::Zero()};
  WindowSettings flat{PlacedSolid{Box{kVoxel * Vec3(2.6, 1.4, 0.4)}}, WindowWeight::Even,
                      Vec3::Zero()};
  int which = 0;
  for (const WindowSettings& window : {offCenter, far, even, flat, sphereWindow(kVoxel, 9.5)}) {
    SCOPED_TRACE("window " + std::to_string(which++));
    MAKE_BOTH(both, tooth(window));
    std::mt19937 random(3);
    for (int k = 0; k < 3; ++k) both.cut(cluster(random, 40));
    both.cut(boxOf({3, 15, 13}, {38, 18, 16}, 0));
    both.compare();
  }
}

// Only the pose is uploaded; lists of voxels alternate with passes.
TEST(DeviceCut, ToolPasses) {
  MAKE_BOTH(both, tooth());
  const Cloud burr = ballCloud(kVoxel, 2, Vec3(8, 8, 8), 6.3);
  const PlacedSolid areas[] = {
      PlacedSolid{Sphere{5.3 * kVoxel}, {.position = kVoxel * Vec3(1, 0, 2)}},
      PlacedSolid{Box{kVoxel * Vec3(2.2, 9.1, 4.3)}},
      PlacedSolid{Ellipsoid{kVoxel * Vec3(3.2, 4.1, 8.3)}}, cloudSolid(burr)};
  std::mt19937 random(13);
  std::uniform_real_distribution<double> place(-3, 43), turn(-1, 1);
  std::size_t removed = 0, missed = 0;
  for (int k = 0; k < 40; ++k) {
    Pose pose;
    pose.position = kVoxel * Vec3(place(random), place(random), place(random));
    pose.orientation = Eigen::Quaterniond(1, turn(random), turn(random), turn(random)).normalized();
    const PlacedSolid& area = areas[k % 4];
    const std::size_t changed = both.device.cut(area, pose);
    EXPECT_EQ(changed, both.cpu.cut(cutsOf(both.cpu, area, pose))) << k;
    removed += changed;
    missed += changed == 0;
    if (k % 5 == 0) both.cut(cluster(random, 40));
  }
  EXPECT_GT(removed, 3000u);
  EXPECT_GT(missed, 0u);
  both.compare();
  EXPECT_EQ(both.device.cut(areas[0], {Eigen::Quaterniond::Identity(), Vec3(1, 0, 0)}), 0u);
  EXPECT_THROW(both.device.cut(PlacedSolid{}, {}), std::invalid_argument);
  both.compare();
}

// Digitized and cut on the device; the digitizer keeps its own field.
TEST(DeviceCut, FieldDigitizedOnTheDevice) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  EXPECT_THROW(DeviceWorkpiece{digitizer}, std::logic_error);
  const Mesh mesh = sphereMesh(27.3, 4);
  DigitizeSettings settings;
  settings.voxelSize = 1;
  digitizer.run(mesh, settings, {kEnamel}, sphereWindow(1));
  ASSERT_TRUE(digitizer.deviceReport().onDevice) << digitizer.message();
  const BaseVectorField untouched(digitize(mesh, settings), {kEnamel}, sphereWindow(1));
  BaseVectorField cpu(digitize(mesh, settings), {kEnamel}, sphereWindow(1));
  DeviceWorkpiece piece(digitizer);
  ASSERT_EQ(piece.backend(), Backend::OpenCl) << piece.message();
  expectSame(piece.field(), cpu);
  std::mt19937 random(4);
  for (int k = 0; k < 10; ++k) {
    const std::vector<VoxelCut> cuts = cluster(random, cpu.size().minCoeff());
    EXPECT_EQ(piece.cut(cuts), cpu.cut(cuts));
  }
  expectSame(piece.field(), cpu);
  expectSame(digitizer.field(), untouched);
}

// The CPU's field is uploaded.
TEST(DeviceCut, FieldDigitizedOnTheCpu) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  const Mesh mesh = joined(sphereMesh(12.3, 3), sphereMesh(9.3, 3));  // one inside the other
  DigitizeSettings settings;
  settings.voxelSize = 1;
  digitizer.run(mesh, settings, {kEnamel}, sphereWindow(1));
  ASSERT_FALSE(digitizer.deviceReport().onDevice);
  BaseVectorField cpu(digitize(mesh, settings), {kEnamel}, sphereWindow(1));
  DeviceWorkpiece piece(digitizer);
  ASSERT_EQ(piece.backend(), Backend::OpenCl) << piece.message();
  const std::vector<VoxelCut> cuts = boxOf({3, 12, 12}, {20, 15, 16}, 0);
  EXPECT_EQ(piece.cut(cuts), cpu.cut(cuts));
  expectSame(piece.field(), cpu);
}

TEST(DeviceCut, VoxelOutsideTheGridThrowsFirst) {
  MAKE_BOTH(both, ball());
  for (const VoxelIndex& bad : {VoxelIndex(28, 28, 56), VoxelIndex(-1, 28, 28)}) {
    const VoxelCut cuts[] = {{{28, 28, 28}, 0}, {bad, 0}};
    EXPECT_THROW(both.device.cut(cuts), std::out_of_range);
    EXPECT_THROW(both.cpu.cut(cuts), std::out_of_range);
  }
  both.compare();
  both.cut({});
  both.compare();
}

TEST(DeviceCut, WithoutADeviceFallsBackToCpu) {
  ::setenv("OCL_ICD_VENDORS", CLOUDCONTACT_SOURCE_DIR "/kernels", 1);  // no *.icd there
  BaseVectorField cpu = tooth().field();
  DeviceWorkpiece piece(tooth().field(), {Backend::OpenCl});
  EXPECT_EQ(piece.backend(), Backend::Cpu);
  EXPECT_NE(piece.message().find("the CPU cuts"), std::string::npos) << piece.message();
  EXPECT_NE(piece.message().find("OpenCL"), std::string::npos) << piece.message();
  EXPECT_TRUE(piece.device().empty());
  std::mt19937 random(5);
  const std::vector<VoxelCut> cuts = cluster(random, 40);
  EXPECT_EQ(piece.cut(cuts), cpu.cut(cuts));
  expectSame(piece.field(), cpu);
  EXPECT_EQ(piece.mass().inertia, cpu.mass().inertia);
  DeviceWorkpiece silent(tooth().field());
  EXPECT_TRUE(silent.message().empty());
  Digitizer digitizer({Backend::OpenCl});
  DigitizeSettings settings;
  settings.voxelSize = 1;
  digitizer.run(sphereMesh(8, 2), settings, {kEnamel}, sphereWindow(1));
  DeviceWorkpiece other(digitizer);
  EXPECT_EQ(other.backend(), Backend::Cpu);
  EXPECT_NE(other.message().find("no OpenCL device"), std::string::npos) << other.message();
  expectSame(other.field(), digitizer.field());
}

// A grid wider than the device's voxel coordinates.
TEST(DeviceCut, TooWideAGridFallsBackToCpu) {
  const auto longRod = [] {
    return smallCloud(kVoxel, {8193, 1, 1}, [](int x, int, int) { return x < 8 ? 255 : 0; });
  };
  const BaseVectorField cpu(longRod(), {kEnamel}, sphereWindow(kVoxel));
  DeviceWorkpiece piece(BaseVectorField(longRod(), {kEnamel}, sphereWindow(kVoxel)),
                        {Backend::OpenCl});
  if (maySkip(piece)) GTEST_SKIP() << piece.message();
  EXPECT_EQ(piece.backend(), Backend::Cpu);
  EXPECT_NE(piece.message().find("wider"), std::string::npos) << piece.message();
  EXPECT_EQ(piece.field().hash(), cpu.hash());
}

// Many places of a tool: the device gives the bits of the CPU, and both the means of the collision
// finder.
TEST(DeviceWorkpiece, DigitalNormalsOfManyAreas) {
  const Piece piece = tooth();
  BaseVectorField field = piece.field();
  Detection tool;
  tool.area = {Sphere{6 * kVoxel}, {}};
  tool.parts = {{{Sphere{3 * kVoxel}, {}}, 0.4}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 40);
  std::vector<std::vector<CollisionVoxel>> areas;
  std::vector<Vec3> means;
  CollisionFinder finder;
  const Vec3 origin = field.origin();
  for (int k = 0; k < 50; ++k) {
    const Vec3 at = origin + kVoxel * Vec3(place(random), place(random), place(random));
    const Collision& found = finder.find(field, {}, tool, {Eigen::Quaterniond::Identity(), at});
    areas.push_back(found.voxels);
    means.push_back(found.mean);
  }
  areas.emplace_back();  // an empty one
  means.push_back(Vec3::Zero());
  const std::vector<Span<const CollisionVoxel>> spans(areas.begin(), areas.end());
  const DeviceWorkpiece onCpu(piece.field(), {});
  const std::vector<DigitalNormal> cpu = onCpu.digitalNormals(spans);
  ASSERT_EQ(cpu.size(), areas.size());
  int felt = 0;
  for (std::size_t k = 0; k < areas.size(); ++k) {
    EXPECT_LT((cpu[k].mean - means[k]).norm(), 1e-7 * kVoxel) << k;  // shares are floats
    felt += means[k].norm() > 0.1 * kVoxel;
  }
  EXPECT_GT(felt, 10);
  CollisionVoxel outside;
  outside.voxel = {1000, 0, 0};
  const Span<const CollisionVoxel> bad[] = {{&outside, 1}};
  EXPECT_THROW(onCpu.digitalNormals(bad), std::out_of_range);
  DeviceWorkpiece onDevice(piece.field(), {Backend::OpenCl, false});
  SKIP_WITHOUT(onDevice);
  const std::vector<DigitalNormal> device = onDevice.digitalNormals(spans);
  for (std::size_t k = 0; k < areas.size(); ++k) {
    EXPECT_EQ(device[k].mean, cpu[k].mean) << k;
    EXPECT_EQ(device[k].count, cpu[k].count) << k;
  }
}

}  // namespace
}  // namespace cloudcontact::test::device_workpiece_test
