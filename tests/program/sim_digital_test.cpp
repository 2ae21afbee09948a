// Scenes of digital objects: every kind moves with the mass, inertia and place of what it was made
// from, and parts of a mesh file keep their tissues.
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "io/errors.h"
#include "program/obj_file.h"
#include "program/scene_bodies.h"
#include "scene/primitive_mesh.h"
#include "scene/scene_shapes.h"
#include "scene/simulation.h"

namespace cloudcontact::program::sim_digital_test {
namespace {

const Vec3 kEdges(0.12, 0.08, 0.04);  // of a brick [m]
constexpr double kVoxelSize = 0.005;  // [m]

Mesh brickMesh(const Vec3& edges = kEdges, const Vec3& center = Vec3::Zero()) {
  Mesh mesh = primitiveMesh(Box{edges / 2}, 1e-4);
  for (Vec3& v : mesh.vertices) v += center;
  return mesh;
}

Cloud brickCloud() {
  DigitizeSettings settings;
  settings.voxelSize = kVoxelSize;
  settings.threads = 1;
  return digitize(brickMesh(), settings);
}

class DigitalScene : public ::testing::Test {
 protected:
  DigitalScene() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string("cloudcontact_") + info->test_suite_name() + info->name();
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::create_directories(folder_);
    settings_.common.threads = 1;
    settings_.voxel = kVoxelSize;
  }
  ~DigitalScene() override { std::filesystem::remove_all(folder_); }

  SceneBody brick(const DigitalObject& object, const Vec3& position) const {
    saveObject(object, folder_ / "brick.cloud");
    SceneBody body =
        bodyWith("brick", SceneMesh{folder_ / "brick.cloud", Vec3::Ones(), nullptr}, position, 1);
    body.mass.reset();
    return body;
  }

  std::filesystem::path folder_;
  WorldSettings settings_;
};

struct Kind {
  const char* name;
  DigitalObject (*make)();
  double tolerance;  // of mass and inertia
  double tilt;       // [rad]
};

class EveryKind : public DigitalScene, public testing::WithParamInterface<Kind> {};

// The collision stands upright in the body, so that the voxels' axes are not the body's.
TEST_P(EveryKind, HasTheMassOfTheBrick) {
  SceneBody body = brick(GetParam().make(), Vec3::Zero());
  body.collisions[0].pose = {
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX())), Vec3(0, 0, 0.3)};
  SceneShapes shapes(settings_.common, kVoxelSize);
  const BodyParts parts = shapes.make(body);
  const double mass = 1000 * kEdges.prod(), close = GetParam().tolerance;
  const Vec3 upright(kEdges.x(), kEdges.z(), kEdges.y()), squares = upright.cwiseAbs2();
  const Vec3 truth =
      mass / 12 *
      Vec3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
  EXPECT_NEAR(parts.mass, mass, close * mass);
  EXPECT_LT((parts.inertia - truth).cwiseAbs().maxCoeff(), close * truth.maxCoeff());
  EXPECT_LT((parts.frame.position - Vec3(0, 0, 0.3)).norm(), 1e-4);
  EXPECT_FALSE(parts.isMeasured);
}

// It stands on its short side, as its collision does, and sinks in by less than half a voxel.
TEST_P(EveryKind, StandsOnTheFloor) {
  SceneBody body = brick(GetParam().make(), Vec3(0, 0, kEdges.y() / 2));
  body.collisions[0].pose.orientation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX());
  SceneDescription scene;
  scene.bodies = {bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0), body};
  scene.bodies[1].model = 1;
  for (SceneBody& each : scene.bodies) each.friction = 0.5;
  World world(scene, settings_);
  for (int n = 0; n < 120; ++n) world.step(kStep);
  const Pose& at = world.pose(1);
  EXPECT_NEAR(at.position.z(), kEdges.y() / 2, 0.5 * kVoxelSize);
  EXPECT_LT(at.position.head<2>().norm(), 0.2 * kVoxelSize);
  EXPECT_GT((at.orientation * Vec3::UnitZ()).z(), std::cos(GetParam().tilt));
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, EveryKind,
    ::testing::Values(
        Kind{"voxels", [] { return DigitalObject(brickCloud()); }, 2e-3, 5e-3},
        Kind{"points", [] { return DigitalObject(centerPoints(brickCloud())); }, 2e-3, 5e-3},
        Kind{"spheres", [] { return DigitalObject(inscribedSpheres(brickCloud())); }, 0.15, 0.1},
        Kind{"columns", [] { return DigitalObject(toColumns(brickCloud())); }, 2e-3, 5e-3},
        Kind{"octree", [] { return DigitalObject(Octree(brickCloud())); }, 2e-3, 5e-3},
        Kind{"sphereTree", [] { return DigitalObject(SphereTree(brickCloud())); }, 2e-3, 5e-3}),
    [](const auto& kind) { return std::string(kind.param.name); });

TEST_F(DigitalScene, PointFilesMove) {
  std::ofstream rows(folder_ / "brick.xyz");
  for (const Vec3& p : centerPoints(brickCloud()).positions)
    rows << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  rows.close();
  SceneBody body =
      bodyWith("brick", SceneMesh{folder_ / "brick.xyz", Vec3::Ones(), nullptr}, Vec3::Zero(), 1);
  body.mass.reset();
  SceneShapes shapes(settings_.common, kVoxelSize);
  EXPECT_NEAR(shapes.make(body).mass, 1000 * kEdges.prod(), 0.01 * 1000 * kEdges.prod());
}

TEST_F(DigitalScene, BulletsOwnMethodsAndScalesAreRefused) {
  SceneBody body = brick(brickCloud(), Vec3::Zero());
  CommonOptions hull = settings_.common;
  hull.method = Method::Gjk;
  EXPECT_THROW(SceneShapes(hull, kVoxelSize).make(body), BadInput);
  std::get<SceneMesh>(body.collisions[0].geometry).scale = Vec3(2, 2, 2);
  EXPECT_THROW(SceneShapes(settings_.common, kVoxelSize).make(body), BadInput);
}

TEST_F(DigitalScene, PenetrationLeavesThemOut) {
  SceneDescription scene;
  scene.bodies = {bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0),
                  brick(brickCloud(), Vec3(0, 0, 0.01)),
                  bodyWith("box", SceneBox{kEdges}, Vec3(1, 0, 0.01), 1)};
  for (int i = 0; i < 3; ++i) scene.bodies[i].model = i;
  World world(scene, settings_);
  EXPECT_FALSE(world.isMeasured(1));
  EXPECT_TRUE(world.isMeasured(2));
  EXPECT_NEAR(world.penetration(), 0.01, 1e-9);  // of the box: 0.02 - 0.01
  SimulationReport report;
  report.steps = 1;
  report.maxPenetration = 0.01;
  EXPECT_EQ(factsOf(world, report)[0].second, "10 mm, without '" + world.name(1) + "'");
  scene.bodies.pop_back();
  EXPECT_EQ(factsOf(World(scene, settings_), report)[0].second, "not measured");
}

// Two halves of different tissues: the center of mass lies in the denser one.
TEST_F(DigitalScene, PartsKeepTheirTissues) {
  const Vec3 half(kEdges.x() / 2, kEdges.y(), kEdges.z());
  const Vec3 shift(kEdges.x() / 4, 0, 0);
  std::ofstream(folder_ / "tooth.obj") << program_test::objText(
      {{"crown", brickMesh(half, shift)}, {"root", brickMesh(half, -shift)}});
  SceneBody body =
      bodyWith("tooth", SceneMesh{folder_ / "tooth.obj", Vec3::Ones(), nullptr}, Vec3::Zero(), 1);
  body.mass.reset();
  SceneCollision& collision = body.collisions[0];
  collision.tissues = {{"crown", "enamel"}, {"", "pulp"}};
  const TissueTable dental = dentalTissues();
  const double crown = dental[0].density, root = dental[2].density;
  ASSERT_EQ(dental[2].name, "pulp");
  SceneShapes shapes(settings_.common, kVoxelSize);
  const BodyParts parts = shapes.make(body);
  const double mass = kEdges.prod() / 2 * (crown + root);
  EXPECT_NEAR(parts.mass, mass, 2e-3 * mass);
  EXPECT_NEAR(parts.frame.position.x(), shift.x() * (crown - root) / (crown + root), 1e-4);

  const auto says = [&](std::vector<SceneTissue> tissues) {
    collision.where = "s.sdf: collision 'c'";
    collision.tissues = std::move(tissues);
    try {
      SceneShapes(settings_.common, kVoxelSize).make(body);
    } catch (const BadInput& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string noPart = says({{"cusp", "enamel"}, {"", "pulp"}});
  EXPECT_NE(noPart.find("s.sdf: collision 'c' <cloudcontact:tissue>"), std::string::npos) << noPart;
  EXPECT_NE(noPart.find("crown, root"), std::string::npos) << noPart;
  const std::string noTissue = says({{"", "wax"}});
  EXPECT_NE(noTissue.find("enamel, dentin"), std::string::npos) << noTissue;
  EXPECT_NE(noTissue.find("--tissues"), std::string::npos) << noTissue;
}

TEST_F(DigitalScene, BaseVectorsBelongToTheirCollision) {
  SceneBody body = bodyWith("b", SceneBox{kEdges}, Vec3::Zero(), 1);
  body.collisions[0].pose.position = Vec3(0.5, 0, 0);
  body.collisions[0].paper.area = Sphere{0.01};
  SceneShapes shapes(settings_.common, kVoxelSize);
  const BodyParts parts = shapes.make(body);
  const auto& shape = dynamic_cast<const CloudShape&>(*parts.shape.shape);
  ASSERT_TRUE(shape.usesPaper());
  const auto paper = shape.paper();
  ASSERT_TRUE(paper->area);
  // D lies in the frame of its collision: at the center of mass.
  EXPECT_NEAR(depthOf(*paper->area, Vec3::Zero()), 0.01, 1e-5);
  EXPECT_FALSE(dynamic_cast<const CloudShape&>(
                   *shapes.make(bodyWith("c", SceneBox{kEdges}, Vec3::Zero(), 1)).shape.shape)
                   .usesPaper());
}

}  // namespace
}  // namespace cloudcontact::program::sim_digital_test
