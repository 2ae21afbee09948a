// The project's own scenes get no advice, and no word during their steps.
#include <gtest/gtest.h>

#include <filesystem>

#include "scene/scene_clouds.h"
#include "scene/scene_file.h"
#include "scene/world.h"

namespace cloudcontact::program::sim_advice_test {
namespace {

namespace fs = std::filesystem;

void expectNoAdvice(const fs::path& file, const std::string& tissues = {}) {
  SCOPED_TRACE(file.string());
  const SceneDescription scene = loadScene(file);
  WorldSettings settings;
  settings.common.tissues.table = tissues;
  settings.voxel = defaultVoxel(scene, settings.common);
  ::testing::internal::CaptureStderr();
  World world(scene, settings);
  ::testing::internal::GetCapturedStderr();
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(world.advice(), std::vector<std::string>());
  for (int i = 0; i < 20; ++i) world.step(scene.step);
  EXPECT_EQ(world.advice(), std::vector<std::string>());
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

// Nor do those beside the tree, where there are any.
TEST(Advice, OwnScenesNeedNone) {
  const fs::path folder = fs::path(CLOUDCONTACT_SOURCE_DIR) / "tests" / "program";
  expectNoAdvice(folder / "milling.sdf");
  expectNoAdvice(folder / "tissue.sdf", (folder / "soft_tissues.json").string());
  const fs::path shared = fs::path(CLOUDCONTACT_SOURCE_DIR) / ".." / "shared" / "scenes";
  if (!fs::exists(shared)) return;
  for (const auto& entry : fs::directory_iterator(shared))
    if (entry.path().extension() == ".sdf") expectNoAdvice(entry.path());
}

// A link of a machine is mostly larger than the part of it that touches things.
TEST(Advice, ALinkMayHaveMoreInertiaThanItsCollision) {
  SceneDescription scene;
  SceneBody tool;
  tool.name = "tool";
  tool.friction = 0.3;
  tool.mass = 1;
  tool.inertia = 0.05 * Eigen::Matrix3d::Identity();
  tool.inertialPose = Pose{Eigen::Quaterniond::Identity(), Vec3(0, 0, 0.3)};
  tool.collisions.push_back({"tip", Pose(), SceneBox{Vec3(0.02, 0.02, 0.04)}});
  scene.bodies = {tool};
  WorldSettings settings;
  settings.voxel = 0.002;
  EXPECT_FALSE(World(scene, settings).advice().empty());
  SceneJoint joint;
  joint.name = "wrist";
  joint.kind = SceneJoint::Kind::Revolute;
  joint.child = 0;
  scene.joints = {joint};
  EXPECT_EQ(World(scene, settings).advice(), std::vector<std::string>());
}

}  // namespace
}  // namespace cloudcontact::program::sim_advice_test
