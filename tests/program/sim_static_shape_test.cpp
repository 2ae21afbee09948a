// Static primitives of a scene meet clouds as the shapes that they are, without voxels.
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "program/scene_bodies.h"
#include "scene/bullet_vectors.h"
#include "scene/primitive_mesh.h"
#include "scene/simulation.h"

namespace cloudcontact::program::sim_static_shape_test {
namespace {

constexpr double kVoxel = 0.005;
constexpr double kEdge = 0.1;    // of the block
constexpr double kShort = 1e-3;  // [s]

// Names of the bodies of which a world made voxels.
class Digitized {
 public:
  WorldSettings settings(double voxel) {
    WorldSettings out = voxels(voxel);
    out.common.progress = [this](const std::string& label) {
      const std::string start = "digitizing ";
      if (label.starts_with(start)) names_.push_back(label.substr(start.size()));
      return std::function<void(double)>();
    };
    return out;
  }
  std::vector<std::string> names() const { return names_; }
  bool has(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  }

 private:
  std::vector<std::string> names_;
};

// A cube whose faces have a corner in their middle: 24 triangles.
SceneMesh blockMesh() {
  auto mesh = std::make_shared<Mesh>();
  const double half = kEdge / 2;
  for (int k = 0; k < 8; ++k)
    mesh->vertices.push_back({k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half});
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& face : faces) {
    Vec3 middle = Vec3::Zero();
    for (const int corner : face) middle += mesh->vertices[static_cast<std::size_t>(corner)] / 4;
    mesh->vertices.push_back(middle);
    const int center = static_cast<int>(mesh->vertices.size()) - 1;
    for (int k = 0; k < 4; ++k) mesh->triangles.push_back({face[k], face[(k + 1) % 4], center});
  }
  return {"block", Vec3::Ones(), mesh};
}

// Stated springs: automatic ones sag by 0.1 voxel.
SceneBody sprung(SceneBody body) {
  body.stiffness = 1e6;
  body.damping = 2000;
  return body;
}
SceneBody block(const Vec3& place = Vec3(0, 0, kEdge / 2)) {
  return sprung(bodyWith("block", blockMesh(), place, 1));
}
SceneBody boxFloor() {
  return bodyWith("floor", SceneBox{Vec3(2, 2, 0.2)}, Vec3(0, 0, -0.1), 0);
}
SceneBody planeFloor() {
  return bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0);
}

BodyState after(double seconds, const SceneDescription& scene) {
  World world(scene, voxels(kVoxel));
  for (int n = 0; n < std::lround(seconds / kShort); ++n) world.step(kShort);
  return world.state(0);
}

TEST(StaticShape, AFloorOfABoxHasNoVoxelsAndBearsABlock) {
  Digitized digitized;
  World world(sceneOf({block(Vec3(0.3, -0.2, kEdge / 2 + 0.02)), boxFloor()}),
              digitized.settings(kVoxel));
  EXPECT_EQ(digitized.names(), std::vector<std::string>{"block"});
  EXPECT_TRUE(world.drawn(1).clouds.empty());
  EXPECT_EQ(world.drawn(1).parts.size(), 1u);
  for (int n = 0; n < 600; ++n) world.step(kShort);
  EXPECT_NEAR(world.pose(0).position.z(), kEdge / 2, 0.02 * kVoxel);
  EXPECT_LT(world.penetration(), 0.02 * kVoxel);
  EXPECT_TRUE(world.isMeasured(1));
  EXPECT_EQ(world.moment().pairs, 1);
  EXPECT_EQ(digitized.names().size(), 1u);
}

// A square of 20 x 20 m without an inside, of 2 x 9 x 9 triangles, tilted by `slope` along x.
SceneBody terrain(double slope) {
  auto mesh = std::make_shared<Mesh>();
  constexpr int kSide = 9;
  const auto corner = [](int i) { return -10 + 20. * i / kSide; };
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i)
      mesh->vertices.push_back({corner(i), corner(j), -slope * corner(i)});
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const int at = j * (kSide + 1) + i, above = at + kSide + 1;
      mesh->triangles.push_back({at, at + 1, above + 1});
      mesh->triangles.push_back({at, above + 1, above});
    }
  return bodyWith("terrain", SceneMesh{"terrain", Vec3::Ones(), mesh}, Vec3::Zero(), 0);
}

// As voxels of the block's size it would take gigabytes, and a shell of some thickness.
TEST(StaticShape, ATerrainHasNoVoxelsAndBearsABlock) {
  Digitized digitized;
  World world(sceneOf({block(Vec3(3.3, -4.2, kEdge / 2 + 0.02)), terrain(0)}),
              digitized.settings(kVoxel));
  EXPECT_EQ(digitized.names(), std::vector<std::string>{"block"});
  EXPECT_TRUE(world.drawn(1).clouds.empty());
  EXPECT_FALSE(world.isMeasured(1));
  for (int n = 0; n < 600; ++n) world.step(kShort);
  EXPECT_NEAR(world.pose(0).position.z(), kEdge / 2, 0.02 * kVoxel);
  EXPECT_LT(world.state(0).angularVelocity.norm(), 1e-3);
}

// A body slides down it as down a plane, across its triangles' edges.
TEST(StaticShape, ATerrainLetsSlideAsAPlane) {
  const double slope = 0.6, angle = std::atan(slope);
  SceneBody on = block();
  on.pose.orientation = Eigen::AngleAxisd(angle, Vec3::UnitY());
  on.pose.position = on.pose.orientation * Vec3(0, 0, kEdge / 2);
  const BodyState slid = after(0.5, sceneOf({on, terrain(slope)}));
  const double speed = 0.5 * kGravity * (std::sin(angle) - 0.5 * std::cos(angle));
  EXPECT_NEAR(slid.linearVelocity.norm(), speed, 0.02 * speed);
  EXPECT_NEAR((on.pose.orientation.conjugate() * slid.pose.position).z(), kEdge / 2, 0.02 * kVoxel);
}

// A stated thickness asks for the shell.
TEST(StaticShape, ATerrainOfAStatedThicknessHasVoxels) {
  Digitized digitized;
  SceneBody small = terrain(0);
  std::get<SceneMesh>(small.collisions[0].geometry).scale = Vec3(0.03, 0.03, 1);
  WorldSettings settings = digitized.settings(kVoxel);
  settings.common.shell = 0.03;
  const World world(sceneOf({block(), small}), settings);
  EXPECT_TRUE(digitized.has("terrain"));
  EXPECT_EQ(world.drawn(1).clouds.size(), 1u);
}

// mu is 0.5.
SceneDescription onSlope(const SceneBody& floor, double slope) {
  SceneDescription scene = sceneOf({block(), floor});
  const double angle = std::atan(slope);
  scene.gravity = kGravity * Vec3(std::sin(angle), 0, -std::cos(angle));
  return scene;
}

// Of 12 triangles, its upper face at z = 0.
SceneBody slab(double edge) {
  const auto mesh =
      std::make_shared<const Mesh>(primitiveMesh(Box{Vec3(edge / 2, edge / 2, 0.1)}, 1e-4));
  return bodyWith("slab", SceneMesh{"slab", Vec3::Ones(), mesh}, Vec3(0, 0, -0.1), 0);
}

// Far larger than the block, it would take a minute to digitize.
TEST(StaticShape, ALargeMeshWithAnInsideHasNoVoxelsAndBearsABlock) {
  Digitized digitized;
  World world(sceneOf({block(Vec3(0.3, -0.2, kEdge / 2 + 0.02)), slab(2)}),
              digitized.settings(kVoxel));
  EXPECT_EQ(digitized.names(), std::vector<std::string>{"block"});
  EXPECT_TRUE(world.drawn(1).clouds.empty());
  EXPECT_TRUE(world.isMeasured(1));
  for (int n = 0; n < 600; ++n) world.step(kShort);
  EXPECT_NEAR(world.pose(0).position.z(), kEdge / 2, 0.02 * kVoxel);
  EXPECT_LT(world.penetration(), 0.02 * kVoxel);
  EXPECT_LT(world.state(0).angularVelocity.norm(), 1e-3);
}

TEST(StaticShape, ALargeMeshHoldsAndLetsSlideAsAPlane) {
  const BodyState held = after(1, onSlope(slab(2), 0.45));
  EXPECT_LT(held.linearVelocity.norm(), 1e-3);
  const double slope = 0.6, angle = std::atan(slope);
  const BodyState slid = after(0.5, onSlope(slab(4), slope));
  const double speed = 0.5 * kGravity * (std::sin(angle) - 0.5 * std::cos(angle));
  EXPECT_NEAR(slid.linearVelocity.norm(), speed, 0.02 * speed);
}

// What is not far larger than what moves on it keeps its voxels, and so does what is exact.
TEST(StaticShape, AMeshOfModestSizeHasVoxels) {
  Digitized digitized;
  const World world(sceneOf({block(), slab(0.5)}), digitized.settings(kVoxel));
  EXPECT_TRUE(digitized.has("slab"));
  Digitized exact;
  SceneBody large = slab(2);
  large.collisions[0].tolerance = 0.0;
  const World asked(sceneOf({block(), large}), exact.settings(0.02));
  EXPECT_TRUE(exact.has("slab"));
}

TEST(StaticShape, ABoxHoldsAndLetsSlideAsAPlane) {
  const BodyState held = after(1, onSlope(boxFloor(), 0.45));
  EXPECT_LT(held.pose.position.head<2>().norm(), 0.02 * kVoxel);
  EXPECT_LT(held.linearVelocity.norm(), 1e-4);
  const BodyState slid = after(0.5, onSlope(boxFloor(), 0.6));
  const BodyState onPlane = after(0.5, onSlope(planeFloor(), 0.6));
  const double angle = std::atan(0.6);
  const double speed = 0.5 * kGravity * (std::sin(angle) - 0.5 * std::cos(angle));
  EXPECT_NEAR(slid.linearVelocity.x(), speed, 0.02 * speed);
  EXPECT_NEAR(slid.linearVelocity.x(), onPlane.linearVelocity.x(), 0.002 * speed);
  EXPECT_NEAR(slid.pose.position.z(), onPlane.pose.position.z(), 0.002 * kVoxel);
}

// It lies as long as its center is above the box.
TEST(StaticShape, ABlockOverTheEdgeOfABoxLiesOrTips) {
  const BodyState lies =
      after(1, sceneOf({block(Vec3(1 - 0.1 * kEdge, 0, kEdge / 2)), boxFloor()}));
  EXPECT_NEAR(lies.pose.position.z(), kEdge / 2, 0.02 * kVoxel);
  EXPECT_LT(lies.angularVelocity.norm(), 1e-3);
  const BodyState falls =
      after(1, sceneOf({block(Vec3(1 + 0.1 * kEdge, 0, kEdge / 2)), boxFloor()}));
  EXPECT_LT(falls.pose.position.z(), 0);
}

// A place on a primitive's surface, and the way out of it there.
struct Spot {
  const char* name;
  SceneGeometry geometry;
  std::shared_ptr<btCollisionShape> own;
  Vec3 place, out;
};

constexpr double kBallVoxel = 0.002, kBall = 0.02, kPressed = 0.001;

std::vector<Spot> spots() {
  const auto box = std::make_shared<btBoxShape>(btVector3(0.05, 0.04, 0.03));
  const auto ball = std::make_shared<btSphereShape>(0.05);
  const auto cylinder = std::make_shared<btCylinderShapeZ>(btVector3(0.05, 0.05, 0.04));
  const auto capsule = std::make_shared<btCapsuleShapeZ>(0.03, 0.06);
  const auto cone = std::make_shared<btConeShapeZ>(0.06, 0.08);
  cone->setMargin(0);
  const SceneBox sceneBox{Vec3(0.1, 0.08, 0.06)};
  const SceneCylinder sceneCylinder{0.05, 0.08};
  const SceneCapsule sceneCapsule{0.03, 0.06};
  const SceneCone sceneCone{0.06, 0.08};
  const Vec3 skew = Vec3(2, -3, 6) / 7;
  return {{"box's face", sceneBox, box, Vec3(0.05, 0.013, -0.004), Vec3::UnitX()},
          {"box's edge", sceneBox, box, Vec3(0.05, 0.04, 0.003), Vec3(0.6, 0.8, 0)},
          {"ball", SceneSphere{0.05}, ball, 0.05 * skew, skew},
          {"cylinder's side", sceneCylinder, cylinder, Vec3(0.03, 0.04, 0.01), Vec3(0.6, 0.8, 0)},
          {"cylinder's end", sceneCylinder, cylinder, Vec3(0.01, -0.02, -0.04), -Vec3::UnitZ()},
          {"capsule's cap", sceneCapsule, capsule, Vec3(0, 0, 0.03) + 0.03 * skew, skew},
          {"capsule's side", sceneCapsule, capsule, Vec3(0.018, -0.024, 0.007), Vec3(0.6, -0.8, 0)},
          {"cone's side", sceneCone, cone, Vec3(0.03, 0, 0), Vec3(0.8, 0, 0.6)},
          {"cone's base", sceneCone, cone, Vec3(0.02, 0.01, -0.04), -Vec3::UnitZ()}};
}

const Pose kInWorld{Eigen::Quaterniond(0.5, -0.1, 0.7, 0.5).normalized(), Vec3(0.3, 0.2, -0.4)};
const Pose kInBody{Eigen::Quaterniond(0.9, 0.2, -0.3, 0.1).normalized(), Vec3(-0.1, 0.2, 0.3)};

// A ball of triangles that is pressed into the spot.
SceneDescription pressed(const Spot& spot) {
  const auto mesh = std::make_shared<const Mesh>(primitiveMesh(Sphere{kBall}, 1e-5));
  SceneBody solid = bodyWith("solid", spot.geometry, Vec3::Zero(), 0);
  solid.pose = kInWorld;
  solid.collisions[0].pose = kInBody;
  const Vec3 center =
      (kInWorld * kInBody).toWorld(spot.place + (kBall - kPressed) * spot.out.normalized());
  return sceneOf({bodyWith("ball", SceneMesh{"ball", Vec3::Ones(), mesh}, center, 1), solid});
}

// Along one axis, with normals out of the solid.
std::vector<ContactNow> sorted(const World& world) {
  ContactsNow now;
  world.contacts(now);
  for (const PatchNow& patch : now.patches)
    for (std::size_t i = patch.first; i < patch.first + patch.points; ++i)
      if (patch.a == 0) now.points[i].normal *= -1;
  std::sort(now.points.begin(), now.points.end(), [](const ContactNow& a, const ContactNow& b) {
    return a.position.x() < b.position.x();
  });
  return now.points;
}

TEST(StaticShape, MeetsACloudAsBulletsOwnShapeDoes) {
  for (const Spot& spot : spots()) {
    SCOPED_TRACE(spot.name);
    Digitized digitized;
    WorldSettings settings = digitized.settings(kBallVoxel), same = voxels(kBallVoxel);
    settings.common.exact = same.common.exact = true;  // not as a ball
    World world(pressed(spot), settings);
    EXPECT_EQ(digitized.names(), std::vector<std::string>{"ball"});
    world.findContacts();
    World other(pressed(spot), same);
    btCollisionObject& solid = *other.bullet().getCollisionObjectArray()[1];
    ASSERT_TRUE(solid.isStaticObject());
    solid.setCollisionShape(spot.own.get());
    solid.setWorldTransform(toBullet(kInWorld * kInBody));
    other.findContacts();
    const std::vector<ContactNow> found = sorted(world), own = sorted(other);
    ASSERT_EQ(found.size(), own.size());
    ASSERT_FALSE(found.empty());
    const Vec3 out = (kInWorld * kInBody).orientation * spot.out;
    double deepest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_LT((found[i].position - own[i].position).norm(), 2e-3 * kBallVoxel);
      EXPECT_LT((found[i].normal - own[i].normal).norm(), 1e-3);
      EXPECT_NEAR(found[i].depth, own[i].depth, 1e-3 * kBallVoxel);
      EXPECT_GT(found[i].normal.dot(out), std::cos(std::numbers::pi / 90));
      deepest = std::max(deepest, found[i].depth);
    }
    EXPECT_NEAR(deepest, kPressed, 0.05 * kBallVoxel);
  }
}

// A table whose link has a top, and a post and a dome on it, each in its place.
TEST(StaticShape, TheCollisionsOfALinkAreEachExact) {
  SceneBody table = boxFloor();
  table.collisions.push_back(
      {"post", {Eigen::Quaterniond::Identity(), Vec3(0.5, 0, 0.15)}, SceneCylinder{0.1, 0.1}});
  table.collisions.push_back(
      {"dome", {Eigen::Quaterniond::Identity(), Vec3(-0.5, 0.5, 0.1)}, SceneSphere{0.2}});
  SceneBody upper = block(Vec3(0.5, 0.01, 0.1 + kEdge / 2)), third = block(Vec3(0, 0.5, kEdge / 2));
  upper.name = "upper", third.name = "third";
  SceneBody ball = sprung(bodyWith("ball", SceneSphere{0.05}, Vec3(-0.5, 0.5, 0.25), 1));
  Digitized digitized;
  World world(sceneOf({upper, third, ball, table}), digitized.settings(kVoxel));
  EXPECT_FALSE(digitized.has("floor"));
  for (int n = 0; n < 300; ++n) world.step(kShort);
  EXPECT_NEAR(world.pose(0).position.z(), 0.1 + kEdge / 2, 0.02 * kVoxel);
  EXPECT_NEAR(world.pose(1).position.z(), kEdge / 2, 0.02 * kVoxel);
  EXPECT_NEAR((world.pose(2).position - Vec3(-0.5, 0.5, 0)).norm(), 0.25, 0.02 * kVoxel);
  EXPECT_EQ(world.moment().pairs, 3);
}

bool hasVoxels(const SceneBody& body, void (*change)(WorldSettings&) = nullptr) {
  Digitized digitized;
  WorldSettings settings = digitized.settings(0.02);
  if (change) change(settings);
  World world(sceneOf({block(), body}), settings);
  return digitized.has(body.name);
}

SceneBody slab() {
  return bodyWith("slab", SceneBox{Vec3(0.3, 0.3, 0.2)}, Vec3(0, 0, -0.1), 0);
}
// A slab whose collision is changed.
SceneBody slabWith(void (*change)(SceneCollision&)) {
  SceneBody body = slab();
  change(body.collisions[0]);
  return body;
}

TEST(StaticShape, WhatVoxelsAloneCanDoHasThem) {
  EXPECT_FALSE(hasVoxels(slab()));
  EXPECT_FALSE(hasVoxels(slab(), [](WorldSettings& s) { s.common.tolerance = 1e-3; }));
  EXPECT_TRUE(hasVoxels(slab(), [](WorldSettings& s) { s.common.method = Method::Paper; }));
  EXPECT_TRUE(hasVoxels(slabWith([](SceneCollision& c) { c.tolerance = 0; })));
  EXPECT_TRUE(hasVoxels(slabWith([](SceneCollision& c) { c.tissues = {{"", "caries"}}; })));
  EXPECT_TRUE(hasVoxels(slabWith([](SceneCollision& c) { c.paper.window = Sphere{0.05}; })));
  EXPECT_TRUE(hasVoxels(slabWith([](SceneCollision& c) { c.cutter = SceneCutter{}; })));
  EXPECT_TRUE(hasVoxels(slabWith([](SceneCollision& c) {
    c.isCuttable = true;
    c.tissues = {{"", "caries"}};
  })));
  SceneBody driven = slab();
  driven.isStatic = false;
  driven.drive = SceneDrive{};
  EXPECT_TRUE(hasVoxels(driven));
  EXPECT_TRUE(hasVoxels(slab(), [](WorldSettings& s) {
    s.common.tissues.table = "dental";
    s.common.tissues.ofParts = {{"all", "caries"}};
  }));
}

}  // namespace
}  // namespace cloudcontact::program::sim_static_shape_test
