// A peg slides home into its hole at any step. Its play is half a voxel a side: it nearly touches
// all around, from the chamfer to the floor.
#include <gtest/gtest.h>

#include "program/scene_bodies.h"
#include "scene/generated_mesh.h"
#include "scene/simulation.h"

namespace cloudcontact::program {
namespace {

constexpr double kPeg = 4e-3, kPlay = 0.05e-3, kStart = 7e-3, kMass = 0.02;

SceneBody meshBody(const std::string& name, Mesh mesh, const Vec3& position, double mass) {
  SceneMesh shape;
  shape.file = name;  // names the mesh in the cache of shapes
  shape.mesh = std::make_shared<const Mesh>(std::move(mesh));
  SceneBody body = bodyWith(name, shape, position, mass);
  body.friction = 0.1;
  body.stiffness = 2e5;
  body.damping = 20;
  return body;
}

class PegTest : public testing::TestWithParam<double> {};

TEST_P(PegTest, SlidesHome) {
  SceneDescription scene;
  scene.bodies.push_back(bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0));
  scene.bodies.push_back(
      meshBody("hole", holeMesh(kPeg + kPlay, 11e-3, 8e-3, 0.5e-3), Vec3::Zero(), 0));
  scene.bodies.push_back(
      meshBody("peg", pegMesh(kPeg, 10e-3, 0.5e-3), Vec3(2e-5, -1e-5, kStart), kMass));
  scene.bodies[2].pose.orientation = Eigen::AngleAxisd(0.002, Vec3(1, -0.5, 0).normalized()) *
                                     Eigen::AngleAxisd(0.3, Vec3::UnitZ());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) scene.bodies[i].model = int(i);
  WorldSettings settings;
  settings.common.threads = 1;
  settings.voxel = 0.1e-3;
  World world(scene, settings);
  SimulationSettings run;
  run.seconds = 0.2;
  run.step = 1 / GetParam();
  run.instants = 40;
  const SimulationReport report = simulate(world, run);
  const BodyState& peg = report.bodies.back();
  EXPECT_NEAR(peg.pose.position.z(), 0, 0.1e-3);
  EXPECT_LT(peg.pose.position.head<2>().norm(), 1.5 * kPlay);
  EXPECT_GT((peg.pose.orientation * Vec3::UnitZ()).z(), std::cos(0.02));
  EXPECT_LT(report.maxPenetration, 0.2e-3);  // v sqrt(m / k) on the floor is 0.12
  EXPECT_LT(report.energyMax - report.energyStart.ofBodies(), 0.01 * kMass * kGravity * kStart);
}

INSTANTIATE_TEST_SUITE_P(Hertz, PegTest, testing::Values(240.0, 480.0, 500.0, 1000.0));

}  // namespace
}  // namespace cloudcontact::program
