// A device digitizes meshes and sums windows to the same bits as the CPU.
#include <cloudcontact/device/digitizer.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "device/skip_without_device.h"
#include "field/base_vector_bricks.h"
#include "mesh/mesh_topology.h"
#include "mesh/test_meshes.h"
#include "mesh/thread_meshes.h"
#include "voxels/preparation.h"

namespace cloudcontact::test::digitizer_test {
namespace {

const TissueTable kBone{{"bone", 2e4, .4, 3e9, 2970}};

Mesh torusMesh(double ring, double tube) {
  return revolvedMesh(64, 32, true, [=](double u, double s) {
    const double v = 2 * std::numbers::pi * s, r = ring + tube * std::cos(v);
    return Vec3(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
  });
}

Mesh openBox() {
  Mesh box = boxMesh({-9, -9, -9}, {9, 9, 9});
  box.triangles.resize(box.triangles.size() - 2);  // one face is missing
  return box;
}

struct Case {
  const char* name;
  Mesh mesh;
  double voxel;
};

// Round and flat, on and off the grid, thin, tiny, few large and many small triangles, along each
// axis.
std::vector<Case> cases() {
  const Eigen::Quaterniond none = Eigen::Quaterniond::Identity(), odd = oddTurn();
  const Vec3 aside(0.313, -0.271, 0.159);
  const Mesh box = boxMesh({-10, -12, -8}, {10, 12, 8});
  const Eigen::Quaterniond leaning(Eigen::AngleAxisd(0.04, Vec3(1, 0.7, 0.2).normalized()));
  std::vector<Case> all{
      // Steep, so that its few triangles have more pieces than fit at first.
      {"leaning tower", moved(boxMesh({-6, -6, -80}, {6.3, 6.2, 81}), leaning, aside), 1},
      {"sphere", sphereMesh(12.3, 4), 1},
      {"fine sphere", sphereMesh(9.1, 5), 1},
      {"torus", moved(torusMesh(14, 5), odd, aside), 1},
      {"box on the grid", box, 1},
      {"box half off the grid", moved(box, none, {0.25, 0, 0.5}), 1},
      {"box of odd size", boxMesh({-10.3, -12.1, -8.7}, {10.3, 12.1, 8.7}), 1},
      {"turned box", moved(box, odd, aside), 1},
      {"tall box", boxMesh({-3, -3, -60}, {3.3, 3.2, 61}), 1},
      {"long box", boxMesh({-60, -3, -3}, {61, 3.2, 3.3}), 1},
      {"wide box", boxMesh({-3, -60, -3}, {3.3, 61, 3.2}), 1},
      {"needle", tetrahedronMesh({0, 0, 0}, {40, 41, 90}, {1, 0, 0.2}, {0, 1, 0.1}), 1},
      {"cone",
       revolvedMesh(48, 8, false,
                    [](double u, double s) {
                      const double r = s < 1 ? 20 * s : 0;
                      return Vec3(r * std::cos(u), r * std::sin(u), s < 1 ? -70 * s : -61);
                    }),
       1},
      {"cylinder", moved(cylinderMesh(7.7, 31, 50), odd, aside), 1},
      {"thin plate", moved(boxMesh({-20, -20, -0.2}, {20, 20, 0.25}), odd, aside), 1},
      {"thinner plate", boxMesh({-20, -20, 0.1}, {20, 20, 0.14}), 1},
      {"tiny", sphereMesh(0.3, 2), 1},
      {"two balls", joined(sphereMesh(6.2, 3), moved(sphereMesh(5, 3), none, {20.3, 9, 13})), 1},
      {"soup of triangles", soup(sphereMesh(8, 3)), 1},
      {"inside out", turnedInsideOut(sphereMesh(8, 3)), 1},
      {"with cracks and missing facets", withHoles(sphereMesh(12.3, 4), 7, 3), 1},
      {"screw", threadedRod({4e-3, 2e-3, 1.1e-3}, 12e-3), 1.5e-4},
      {"nut", threadedRing({4e-3, 2e-3, 1.1e-3}, 6e-3, 7e-3, 1e-4), 1.5e-4},
  };
  return all;
}

void expectSame(const Cloud& got, const Cloud& want) {
  EXPECT_EQ(got.voxelSize(), want.voxelSize());
  EXPECT_EQ(got.origin(), want.origin());
  EXPECT_EQ(got.bricks(), want.bricks());
  EXPECT_EQ(got.voxels().table, want.voxels().table);
  EXPECT_EQ(got.voxels().coverage, want.voxels().coverage);
}

void expectSame(const BaseVectorField& got, const BaseVectorField& want) {
  const BaseVectorField::Bricks &g = got.bricks(), &w = want.bricks();
  EXPECT_EQ(g.table, w.table);
  ASSERT_EQ(g.blocks.size(), w.blocks.size());
  EXPECT_EQ(std::memcmp(g.blocks.data(), w.blocks.data(), g.blocks.size() * sizeof(FieldBlock)), 0);
  EXPECT_EQ(got.hash(), want.hash());
  const Eigen::Vector3i middle = want.size() / 2;
  for (int x = 0; x < want.size().x(); ++x)
    EXPECT_EQ(got.depth({x, middle.y(), middle.z()}), want.depth({x, middle.y(), middle.z()}));
}

TEST(Digitizer, DeviceVoxelsEqualCpu) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  std::size_t rounds = 0;
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    DigitizeSettings settings;
    settings.voxelSize = c.voxel;
    DigitizeReport report;
    const Cloud want = digitize(c.mesh, settings, &report);
    digitizer.run(c.mesh, settings);
    EXPECT_EQ(digitizer.message(), "");
    EXPECT_TRUE(digitizer.deviceReport().onDevice);
    expectSame(digitizer.cloud(), want);
    EXPECT_EQ(digitizer.report().closed, report.closed);
    EXPECT_EQ(digitizer.report().badColumns, report.badColumns);
    EXPECT_GT(want.voxels().coverage.size(), 0u);
    rounds = std::max(rounds, digitizer.deviceReport().rounds);
  }
  EXPECT_GT(rounds, 1u);  // some needed more memory than the first guess
}

// Mending is skipped only for meshes that it would not change.
TEST(Digitizer, WholeMeshesNeedNoMending) {
  const auto whole = [](const Mesh& mesh) {
    const auto prepared = preparedAsWhole(mesh);
    return prepared && isOneClosedSurface(prepared->closing.mesh);
  };
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const bool oneSurface = std::string(c.name) != "two balls" &&
                            std::string(c.name) != "with cracks and missing facets";
    EXPECT_EQ(whole(c.mesh), oneSurface);
    if (!oneSurface) continue;
    const Mesh mended = cloudcontact::mended(c.mesh);
    const Prepared prepared = *preparedAsWhole(c.mesh);
    EXPECT_EQ(prepared.closing.mesh.vertices, mended.vertices);
    EXPECT_EQ(prepared.closing.mesh.triangles, mended.triangles);
    EXPECT_EQ(prepared.closing.firstCap, mended.triangles.size());
  }
  Mesh turned = sphereMesh(8, 2), doubled = turned, flat;
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  doubled.triangles.push_back(doubled.triangles[7]);
  flat = Mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  for (const Mesh& mesh : {turned, doubled, flat, sheetMesh(8, 4), openBox()})
    EXPECT_FALSE(whole(mesh));
}

// Windows for the faster kernel, and others that are too wide or off center.
TEST(Digitizer, DeviceFieldsEqualCpu) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  const WindowSettings windows[] = {
      sphereWindow(1),
      sphereWindow(1, 1.2),
      {PlacedSolid{Box{Vec3(1.5, 2.5, 3.5)}}, WindowWeight::Even, Vec3(0.2, 0, 0)},
      sphereWindow(1, 5.5),
      {PlacedSolid{Sphere{2.5}, {.position = Vec3(4, 0, 1)}}, WindowWeight::Smooth, Vec3::Zero()},
  };
  const Mesh meshes[] = {moved(torusMesh(19, 10.5), oddTurn(), {0.313, -0.271, 0.159}),
                         boxMesh({-21, -22, -23}, {21, 22.3, 23.4})};
  for (const Mesh& mesh : meshes)
    for (const WindowSettings& window : windows) {
      SCOPED_TRACE(&window - windows);
      DigitizeSettings settings;
      settings.voxelSize = 1;
      digitizer.run(mesh, settings, kBone, window);
      EXPECT_EQ(digitizer.message(), "");
      const Cloud cloud = digitize(mesh, settings);
      expectSame(digitizer.cloud(), cloud);
      BaseVectorField got = digitizer.field(), want(cloud, kBone, window);
      expectSame(got, want);
      // A field from the device can be cut.
      const VoxelCut cut{want.size() / 2, 0};
      got.cut({&cut, 1});
      want.cut({&cut, 1});
      EXPECT_EQ(got.hash(), want.hash());
    }
}

TEST(Digitizer, FallsBackToCpuWithAMessage) {
  Digitizer digitizer({Backend::OpenCl});
  SKIP_WITHOUT(digitizer);
  const Mesh ball = sphereMesh(8, 3), shifted = moved(ball, oddTurn(), {5, 0.3, 0.2});
  const struct {
    Mesh mesh;
    const char* why;
  } cases[] = {
      {openBox(), "large holes"},
      {joined(ball, shifted), "shells"},
      {joined(ball, turnedInsideOut(sphereMesh(5, 3))), "shells"},
  };
  DigitizeSettings settings;
  settings.voxelSize = 1;
  for (const auto& c : cases) {
    digitizer.run(c.mesh, settings, kBone, sphereWindow(1));
    EXPECT_FALSE(digitizer.deviceReport().onDevice);
    EXPECT_NE(digitizer.message().find(c.why), std::string::npos) << digitizer.message();
    const Cloud cloud = digitize(c.mesh, settings);
    expectSame(digitizer.cloud(), cloud);
    EXPECT_EQ(digitizer.field().hash(), BaseVectorField(cloud, kBone, sphereWindow(1)).hash());
  }
  digitizer.run(ball, settings);
  EXPECT_EQ(digitizer.message(), "");
  EXPECT_TRUE(digitizer.deviceReport().onDevice);
}

void rejectsBadInput(Backend backend) {
  Digitizer digitizer({backend});
  EXPECT_THROW(digitizer.cloud(), std::logic_error);
  DigitizeSettings settings;
  const Mesh ball = sphereMesh(8, 2);
  EXPECT_THROW(digitizer.run(ball, settings), std::invalid_argument);  // no voxel size
  settings.voxelSize = 1;
  EXPECT_THROW(digitizer.run(Mesh{}, settings), std::invalid_argument);
  EXPECT_THROW(digitizer.run(sheetMesh(8, 4), settings), std::invalid_argument);
  EXPECT_THROW(digitizer.run(ball, settings, TissueTable{}, sphereWindow(1)),
               std::invalid_argument);
  settings.maxBytes = 1000;
  EXPECT_THROW(digitizer.run(ball, settings), std::length_error);
  EXPECT_THROW(digitizer.cloud(), std::logic_error);
  settings.maxBytes = 1 << 30;
  digitizer.run(ball, settings);
  expectSame(digitizer.cloud(), digitize(ball, settings));
  EXPECT_THROW(digitizer.field(), std::logic_error);
}

TEST(Digitizer, RejectsBadInput) {
  rejectsBadInput(Backend::Cpu);
  rejectsBadInput(Backend::OpenCl);
}

}  // namespace
}  // namespace cloudcontact::test::digitizer_test
