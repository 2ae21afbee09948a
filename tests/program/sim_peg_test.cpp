// A peg slides home into its hole at any step. Its play is half a voxel a side: it nearly touches
// all around, from the chamfer to the floor.
#include <gtest/gtest.h>

#include "program/scene_bodies.h"
#include "scene/generated_mesh.h"
#include "scene/shape_store.h"
#include "scene/simulation.h"

namespace cloudcontact::program::sim_peg_test {
namespace {

constexpr double kPeg = 4e-3, kPlay = 0.05e-3, kStart = 7e-3, kMass = 0.02, kVoxel = 0.1e-3;
constexpr double kStiffness = 2e5, kDamping = 20;

SceneBody meshBody(const std::string& name, Mesh mesh, const Vec3& position, double mass) {
  SceneMesh shape;
  shape.file = name;  // names the mesh in the cache of shapes
  shape.mesh = std::make_shared<const Mesh>(std::move(mesh));
  SceneBody body = bodyWith(name, shape, position, mass);
  body.friction = 0.1;
  body.stiffness = kStiffness;
  body.damping = kDamping;
  return body;
}

// Starts that differ by less than a step or a voxel. The peg goes from wall to wall on its way, and
// a micrometer changes at which part of a step it reaches the floor.
struct Start {
  double higher = 0, turn = 0;  // [m], [rad]
};
constexpr Start kStarts[] = {{}, {1e-6, 0}, {1e-4, 0.02}};

SceneDescription sceneFrom(const Start& start) {
  SceneDescription scene;
  scene.bodies.push_back(bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0));
  scene.bodies.push_back(
      meshBody("hole", holeMesh(kPeg + kPlay, 11e-3, 8e-3, 0.5e-3), Vec3::Zero(), 0));
  scene.bodies.push_back(meshBody("peg", pegMesh(kPeg, 10e-3, 0.5e-3),
                                  Vec3(2e-5, -1e-5, kStart + start.higher), kMass));
  scene.bodies[2].pose.orientation = Eigen::AngleAxisd(0.002, Vec3(1, -0.5, 0).normalized()) *
                                     Eigen::AngleAxisd(0.3 + start.turn, Vec3::UnitZ());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) scene.bodies[i].model = int(i);
  return scene;
}

// The deepest landing: a peg that leans comes down on a corner, which the floor sees from a part of
// a step away, and then comes to rest against the spring. While the wall behind a peg was not seen
// (ContactFinder::lookBeside()), it went twice as deep.
double deepestLanding(double height, double step) {
  const double speed = std::sqrt(2 * kGravity * height);
  return speed * std::hypot(step / 2, std::sqrt(kMass / kStiffness));
}

class PegTest : public ::testing::TestWithParam<double> {};

TEST_P(PegTest, SlidesHome) {
  WorldSettings settings;
  settings.common.threads = 1;
  settings.voxel = kVoxel;
  settings.store = std::make_shared<ShapeStore>();
  SimulationSettings run;
  run.seconds = 0.2;
  run.step = 1 / GetParam();
  for (const Start& start : kStarts) {
    World world(sceneFrom(start), settings);
    double deepest = 0;
    run.observe = [&deepest](double, const World& now) {
      deepest = std::max(deepest, now.penetration());
    };
    const SimulationReport report = simulate(world, run);
    const BodyState& peg = report.bodies.back();
    const double height = kStart + start.higher;
    EXPECT_NEAR(peg.pose.position.z(), 0, kVoxel);
    EXPECT_LT(peg.pose.position.head<2>().norm(), kPlay + kVoxel);
    EXPECT_GT((peg.pose.orientation * Vec3::UnitZ()).z(), std::cos(0.02));
    EXPECT_LT(deepest, deepestLanding(height, run.step));
    EXPECT_LT(world.penetration(), kVoxel);
    EXPECT_LT(report.energyMax - report.energyStart.ofBodies(), 0.01 * kMass * kGravity * height);
  }
}

INSTANTIATE_TEST_SUITE_P(Hertz, PegTest,
                         ::testing::Values(180.0, 240.0, 480.0, 500.0, 1000.0, 2000.0));

}  // namespace
}  // namespace cloudcontact::program::sim_peg_test
