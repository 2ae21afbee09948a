// Replays of bodies that are cut: at each time the pieces of surface that are shown are the surface
// of the matter at that time, and a cut adds no more than what it changed.
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/pieces.h>
#include <gtest/gtest.h>

#include <cstring>

#include "io/json.h"
#include "program/scene_bodies.h"
#include "replay/gltf.h"
#include "replay/recorder.h"
#include "scene/primitive_mesh.h"
#include "scene/simulation.h"

namespace cloudcontact::program::replay_cutting_test {
namespace {

constexpr double kVoxelSize = 1e-3;

Cloud barCloud() {
  DigitizeSettings settings;
  settings.voxelSize = kVoxelSize;
  settings.threads = 1;
  return digitize(primitiveMesh(Box{Vec3(0.02, 0.006, 0.006)}, 1e-5), settings);
}

// Six times the signed volume under the triangles, by the divergence theorem.
template <class Vertices, class Corner>
double volumeUnder(const Vertices& vertices, std::size_t triangles, const Corner& corner) {
  double sum = 0;
  for (std::size_t t = 0; t < triangles; ++t) {
    const Vec3 a = vertices[corner(t, 0)].template cast<double>(),
               b = vertices[corner(t, 1)].template cast<double>(),
               c = vertices[corner(t, 2)].template cast<double>();
    sum += a.dot(b.cross(c));
  }
  return sum / 6;
}

double volumeOf(const Cloud& cloud) {
  const Mesh mesh = DisplayMesh(cloud).mesh();
  return volumeUnder(mesh.vertices, mesh.triangles.size(),
                     [&](std::size_t t, int k) { return std::size_t(mesh.triangles[t][k]); });
}

double volumeAt(const std::vector<SurfacePiece>& pieces, double time) {
  double sum = 0;
  for (const SurfacePiece& piece : pieces)
    if (piece.from <= time && time < piece.to)
      sum += volumeUnder(
          piece.mesh.positions, piece.mesh.corners.size() / 3,
          [&](std::size_t t, int k) { return piece.mesh.corners[3 * t + std::size_t(k)]; });
  return sum;
}

std::size_t trianglesOf(const std::vector<SurfacePiece>& pieces) {
  std::size_t count = 0;
  for (const SurfacePiece& piece : pieces) count += piece.mesh.corners.size() / 3;
  return count;
}

TEST(ChangingSurface, ShowsTheMatterOfItsTime) {
  const Cloud whole = barCloud();
  const Cloud once = cutCloud(whole, slice(whole, 0.010, 0.013));
  const Cloud twice = cutCloud(once, slice(once, -0.011, -0.010));
  ChangingSurface surface(whole, 0);
  surface.renew(whole, 0.5);
  surface.renew(once, 1);
  surface.renew(twice, 2);
  const auto pieces = surface.finish();
  const double size = volumeOf(whole);
  EXPECT_NEAR(volumeAt(pieces, 0.9), size, 1e-6 * size);
  EXPECT_NEAR(volumeAt(pieces, 1), volumeOf(once), 1e-6 * size);
  EXPECT_NEAR(volumeAt(pieces, 2.5), volumeOf(twice), 1e-6 * size);
  EXPECT_NEAR(volumeOf(once), size * 37 / 40, 2e-2 * size);
  // A slice across a long bar changes a small part of its surface.
  EXPECT_LT(trianglesOf(pieces), 2 * DisplayMesh(whole).mesh().triangles.size());
}

TEST(ChangingSurface, EndsWithItsBody) {
  ChangingSurface surface(barCloud(), 0);
  surface.end(1.5);
  const auto pieces = surface.finish();
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].to, 1.5);
}

nlohmann::json jsonOf(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  return nlohmann::json::parse(glb.substr(20, length));
}

SceneDescription fallingBar() {
  SceneBody bar = bodyWith("bar", SceneBox{Vec3(0.08, 0.024, 0.024)}, Vec3(0, 0, 1), 1);
  bar.collisions[0].isCuttable = true;
  bar.collisions[0].tissues = {{"", "pulp"}};
  SceneDescription scene;
  scene.bodies = {bar};
  return scene;
}

WorldSettings inVoxels() {
  WorldSettings settings;
  settings.common.threads = 1;
  settings.voxel = kVoxelSize;
  return settings;
}

// Its end is cut off, and the run of a minute ends before the next frame.
TEST(ReplayOfCuts, ARunThatEndsEarlyShowsItsLastCut) {
  World world(fallingBar(), inVoxels());
  Recorder recorder;
  recorder.begin(world, "take", 60, kStep);
  recorder.record(0, world);
  const double size = volumeOf(world.matter(0));
  for (int n = 1; n <= 5; ++n) {
    world.step(kStep);
    if (n == 4) world.cut(0, slice(world.matter(0), 0.036, 0.05));
    recorder.record(n * kStep, world);
  }
  recorder.close(world);
  const Replay replay = recorder.finish();
  ASSERT_EQ(world.bodyCount(), 1u);
  EXPECT_NEAR(volumeAt(replay.takes[0].bodies[0].surface, 5 * kStep), size * 76 / 80, 2e-3 * size);
  EXPECT_EQ(replay.takes[0].frames.back().time, 5 * kStep);
}

// A bar in free fall is cut through after half the time, and the piece then cut away.
TEST(ReplayOfCuts, HasThePieceFromItsTimeOn) {
  World world(fallingBar(), inVoxels());
  const double seconds = 0.5;
  Recorder recorder;
  recorder.begin(world, "take", seconds, kStep);
  recorder.record(0, world);
  const double size = volumeOf(world.matter(0));
  double cutAt = 0;
  std::vector<double> left;
  for (int n = 1; n <= 120; ++n) {
    world.step(kStep);
    if (n == 60) {
      world.cut(0, slice(world.matter(0), 0.010, 0.014));
      cutAt = n * kStep;
      left = {world.mass(0), world.mass(1)};
    }
    if (n == 90) world.cut(1, slice(world.matter(1), -1, 1));
    recorder.record(n * kStep, world);
  }
  const Replay replay = recorder.finish();
  const auto& bodies = replay.takes[0].bodies;
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[1].name, "bar piece 1");
  EXPECT_FALSE(bodies[0].drawn.isPlane());
  for (const SurfacePiece& piece : bodies[1].surface) EXPECT_EQ(piece.from, cutAt);
  EXPECT_EQ(bodies[1].keys.front().time, cutAt);
  EXPECT_NEAR(volumeAt(bodies[0].surface, cutAt - kStep), size, 1e-6 * size);
  EXPECT_NEAR(volumeAt(bodies[0].surface, cutAt) + volumeAt(bodies[1].surface, cutAt),
              size * 76 / 80, 2e-3 * size);

  ASSERT_EQ(bodies[0].masses.size(), 2u);
  EXPECT_NEAR(*bodies[0].masses[0].mass, 1, 1e-6);
  EXPECT_EQ(bodies[0].masses[1].mass, left[0]);
  ASSERT_EQ(bodies[1].masses.size(), 2u);
  EXPECT_EQ(bodies[0].masses[1].time, cutAt);
  EXPECT_EQ(bodies[1].masses[0].time, cutAt);
  EXPECT_EQ(bodies[1].masses[0].mass, left[1]);
  EXPECT_FALSE(bodies[1].masses[1].mass);  // gone

  const auto json = jsonOf(gltfBytes(replay));
  int steps = 0;
  for (const auto& channel : json["animations"][0]["channels"]) {
    if (channel["target"]["path"] != "scale") continue;
    const auto& sampler = json["animations"][0]["samplers"][channel["sampler"].get<int>()];
    EXPECT_EQ(sampler["interpolation"], "STEP");
    ++steps;
  }
  EXPECT_GE(steps, 3);  // what goes, what comes, and the piece
}

}  // namespace
}  // namespace cloudcontact::program::replay_cutting_test
