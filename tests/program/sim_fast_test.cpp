// Bodies of a scene that are shot at a wall of two voxels, at up to a thousand meters a second:
// none passes it, whatever it is made of, at which step, and from where in a step it meets the
// wall.
#include <gtest/gtest.h>

#include "program/scene_bodies.h"
#include "scene/generated_mesh.h"
#include "scene/primitive_mesh.h"
#include "scene/shape_store.h"

namespace cloudcontact::program::sim_fast_test {
namespace {

constexpr double kSize = 0.1, kVoxel = 0.01;  // [m]

SceneGeometry meshOf(const std::string& name, Mesh mesh) {
  SceneMesh shape;
  shape.file = name;  // names the mesh in the cache of shapes
  shape.mesh = std::make_shared<const Mesh>(std::move(mesh));
  return shape;
}

Mesh nutOfSize() {
  Mesh nut = nutMesh(Thread(), 8e-3, 24e-3);
  for (Vec3& v : nut.vertices) v *= kSize / 24e-3;
  return nut;
}

struct Shot {
  std::string name;
  SceneGeometry geometry;
};

std::vector<Shot> shots() {
  return {{"ball", SceneSphere{kSize / 2}},
          {"box", SceneBox{Vec3::Constant(kSize)}},
          {"ball of a mesh", meshOf("ball", primitiveMesh(Sphere{kSize / 2}, 1e-4))},
          {"box of a mesh", meshOf("box", primitiveMesh(Box{Vec3::Constant(kSize / 2)}, 1e-3))},
          {"nut", meshOf("nut", nutOfSize())}};
}

// How far in front of the wall's middle the body ends [m].
double before(const Shot& shot, double speed, double step, double start,
              const std::shared_ptr<ShapeStore>& store) {
  const Mesh wall = primitiveMesh(Box{Vec3(kVoxel, 0.4, 0.4)}, 1e-3);
  SceneBody body = bodyWith(shot.name, shot.geometry, Vec3(-start, 0.02, 0.03), 1);
  body.pose.orientation = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized());
  body.linearVelocity = Vec3(speed, 0, 0);
  SceneDescription scene = sceneOf({bodyWith("wall", meshOf("wall", wall), Vec3::Zero(), 0), body});
  scene.gravity = Vec3::Zero();
  WorldSettings settings = voxels(kVoxel);
  settings.store = store;
  World world(scene, settings);
  const int steps = static_cast<int>(start / (speed * step)) + 12;
  for (int i = 0; i < steps; ++i) world.step(step);
  return -world.state(1).pose.position.x();
}

TEST(Fast, NothingPassesAWallOfTwoVoxels) {
  const auto store = std::make_shared<ShapeStore>();
  for (const Shot& shot : shots())
    for (const double speed : {3.0, 10.0, 30.0, 100.0, 1000.0})
      for (const double step : {1. / 60, 1. / 240, 1e-3})
        for (const double start : {0.3, 0.327, 0.351})
          EXPECT_GT(before(shot, speed, step, start, store), 0)
              << shot.name << " at " << speed << " m/s, " << step << " s, from " << start;
}

}  // namespace
}  // namespace cloudcontact::program::sim_fast_test
