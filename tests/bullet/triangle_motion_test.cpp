// Clouds and shapes made of triangles in motion: meshes that move, terrains, rooms, ridges, and any
// number of threads.
#include <gtest/gtest.h>

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include "bullet/triangle_grounds.h"

#include <random>

namespace cloudcontact::testing::triangle_motion_test {
namespace {

double bumps(double x, double y) {
  return 0.01 * std::sin(9 * x) * std::cos(7 * y);
}

Mesh bumpyMesh(int n) {
  Mesh mesh = groundMesh(n);
  for (auto& v : mesh.vertices) v.z() = bumps(v.x(), v.y());
  return mesh;
}

double force(const BulletWorld& world) {
  double sum = 0;
  for (const btManifoldPoint& p : world.points())
    sum += std::max(0.0, -double(p.getDistance()) * p.m_combinedContactStiffness1);
  return sum;
}

CloudContactSettings spring(double stiffness) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, 0};
  return settings;
}

double energyOf(const btRigidBody& body) {
  const btVector3 w = body.getAngularVelocity();
  const btMatrix3x3 inertia = body.getInvInertiaTensorWorld().inverse();
  return 0.5 * body.getMass() * body.getLinearVelocity().length2() + 0.5 * w.dot(inertia * w) +
         9.81 * body.getMass() * body.getWorldTransform().getOrigin().z();
}

TEST(TriangleMotion, TheSameForAnyNumberOfThreads) {
  std::vector<std::uint64_t> serial;
  for (const int threads : {0, 1, 2, 3}) {
    std::vector<std::shared_ptr<void>> data;
    Stage stage(threads);
    const auto add = [&](Kept kept, double mass, const btTransform& place) {
      data.insert(data.end(), kept.data.begin(), kept.data.end());
      stage.add(std::move(kept.shape), mass, place);
    };
    add(bvhShape(bumpyMesh(90)), 0, at({0, 0, 0}));
    const Mesh cube = test::boxMesh({-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04});
    for (int i = 0; i < 9; ++i) {
      const TestCloud& cloud = testClouds()[std::size_t(i % 3)];
      const btScalar x = btScalar(0.2 * (i / 3) - 0.2), y = btScalar(0.2 * (i % 3) - 0.2);
      stage.add(exactCloud(cloud.field), 0.4,
                at({x, y, btScalar(0.05)}, btQuaternion(btVector3(1, 0, 0), btScalar(0.1 * i))));
      if (i % 3 == 0) add(gimpactShape(cube), 0.4, at({x, y + btScalar(0.01), btScalar(0.15)}));
    }
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 60; ++i) {
      stage.step();
      hashes.push_back(stage.hash());
    }
    if (threads == 0) serial = hashes;
    EXPECT_EQ(hashes, serial) << threads << " threads";
    EXPECT_GT(stage.clouds.statistics().contacts, 1000u);
    EXPECT_EQ(stage.clouds.statistics().failures, 0u) << stage.clouds.statistics().lastFailure;
    if (threads > 1) {
      EXPECT_GT(stage.hitRate(), 0.95) << threads << " threads";
    }
    while (!stage.bodies.empty()) stage.removeLast();
  }
}

TEST(TriangleMotion, AMovingGImpactMeshRestsOnACloud) {
  const auto slab = fieldOf(boxMesh({0.4, 0.4, 0.04}), kVoxel);
  const std::pair<const char*, Mesh> falling[] = {
      {"box", test::boxMesh({-0.04, -0.03, -0.025}, {0.04, 0.03, 0.025})},
      {"ball", test::sphereMesh(0.04, 3)},
      {"cylinder", test::cylinderMesh(0.04, 0.06, 48)}};
  for (const bool fixed : {true, false})
    for (const auto& [name, mesh] : falling) {
      BulletWorld world;
      world.addGround();
      btRigidBody& table = world.addCloud(slab, fixed ? 0 : 2, at({0, 0, btScalar(0.02)}));
      Kept body = gimpactShape(mesh);
      btRigidBody& fallen = world.add(std::move(body.shape), 0.5, at({0, 0, btScalar(0.1)}));
      const double start = energyOf(fallen) + (fixed ? 0 : energyOf(table));
      double most = start;
      for (int i = 0; i < 240; ++i) {
        world.step(1.0 / 240);
        most = std::max(most, energyOf(fallen) + (fixed ? 0 : energyOf(table)));
      }
      const double half = name[0] == 'b' && name[1] == 'o' ? 0.025 : name[0] == 'b' ? 0.04 : 0.03;
      EXPECT_NEAR(fallen.getWorldTransform().getOrigin().z(), 0.04 + half, 0.5 * kVoxel)
          << name << (fixed ? "" : " on a table that moves");
      EXPECT_LT(most, start + 1e-3) << name;
      EXPECT_LT(fallen.getLinearVelocity().length(), 0.05) << name;  // a ball of facets rolls
      EXPECT_EQ(world.clouds.statistics().failures, 0u);
    }
}

TEST(TriangleMotion, ARidgePushesAsABoxesEdgeDoes) {
  // A cloud's flat face on a sharp edge.
  const double edge = 0.2, lift = edge / std::sqrt(2.0);
  const Mesh roof = test::moved(
      test::boxMesh({-edge / 2, -edge, -edge / 2}, {edge / 2, edge, edge / 2}),
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 4, Vec3::UnitY())), Vec3::Zero());
  const TestCloud& box = testClouds()[0];
  for (const double depth : {0.3, 0.5, 1.0, 2.0})
    for (const double aside : {0.0, 0.3, 0.7}) {
      const btTransform place =
          at({btScalar(aside * kVoxel), 0, btScalar(lift + box.below - depth * kVoxel)});
      BulletWorld truth(spring(1e4)), world(spring(1e4));
      truth.add(std::make_unique<btBoxShape>(bullet({edge / 2, edge, edge / 2})), 0,
                at({0, 0, 0}, btQuaternion(btVector3(0, 1, 0), btScalar(std::numbers::pi / 4))));
      Kept mesh = bvhShape(roof);
      world.add(std::move(mesh.shape), 0, at({0, 0, 0}));
      for (BulletWorld* w : {&truth, &world}) {
        w->addCloud(box.field, 1, place);
        w->detect();
      }
      EXPECT_NEAR(force(truth), depth * kVoxel * 1e4, 0.1 * depth * kVoxel * 1e4);
      EXPECT_NEAR(force(world), force(truth), 0.01 * force(truth))
          << "depth " << depth << ", aside " << aside;
    }
}

TEST(TriangleMotion, VerticesMayMoveUnderARestingCloud) {
  const TestCloud& box = testClouds()[0];
  BulletWorld world(spring(1e4));
  auto made = std::make_unique<btTriangleShape>(btVector3(-1, -1, 0), btVector3(1, -1, 0),
                                                btVector3(0, 1, 0));
  btTriangleShape& triangle = *made;
  world.add(std::move(made), 0, at({0, 0, 0}));
  world.addCloud(box.field, 1, at({0, 0, btScalar(box.below)}));
  for (const double height : {0.001, 0.002, 0.0005}) {
    for (btVector3& corner : triangle.m_vertices1) corner.setZ(btScalar(height));
    world.detect();
    EXPECT_NEAR(force(world), height * 1e4, 0.02 * height * 1e4);
  }
}

TEST(TriangleMotion, ARoomHoldsACloudInItsCorner) {
  // The same closed mesh is a room from inside; gravity points into a corner.
  const Mesh room = test::boxMesh({0, 0, 0}, {1, 1, 1});
  for (const Mesh& mesh : {room, test::turnedInsideOut(room)}) {
    const TestCloud& box = testClouds()[0];
    BulletWorld world;
    Kept walls = bvhShape(mesh);
    world.add(std::move(walls.shape), 0, at({0, 0, 0}));
    btRigidBody& body =
        world.addCloud(box.field, 0.5, at({btScalar(0.05), btScalar(0.04), btScalar(0.035)}));
    body.setGravity({-5, -4, -6});
    for (int i = 0; i < 240; ++i) world.step(1.0 / 240);
    const btVector3 end = body.getWorldTransform().getOrigin();
    EXPECT_NEAR(end.x(), 0.04, 0.3 * kVoxel);
    EXPECT_NEAR(end.y(), 0.03, 0.3 * kVoxel);
    EXPECT_NEAR(end.z(), 0.025, 0.3 * kVoxel);
    EXPECT_LT(body.getLinearVelocity().length(), 0.01);
  }
}

// How far the deepest of the cloud's samples is below the bumps [m].
double depthInBumps(const btRigidBody& body, const SurfaceField& field) {
  const Cloud& cloud = field.cloud();
  double deepest = -1;
  for (std::size_t k = 0; k < field.sampleCount(); ++k) {
    const SurfaceSample s = field.sample(k);
    const Vec3 local =
        cloud.origin() + cloud.voxelSize() * Vec3(s.position[0], s.position[1], s.position[2]);
    const btVector3 x = body.getWorldTransform() * bullet(local);
    deepest = std::max(deepest, bumps(x.x(), x.y()) - x.z());
  }
  return deepest;
}

TEST(TriangleMotion, TerrainsHoldAndGiveNoEnergy) {
  const std::pair<const char*, Kept> terrains[] = {{"bvh", bvhShape(bumpyMesh(90))},
                                                   {"heightfield", heightfieldShape(90, bumps)},
                                                   {"gimpact", gimpactShape(bumpyMesh(90))}};
  for (const auto& [name, terrain] : terrains)
    for (const TestCloud& cloud : testClouds()) {
      BulletWorld world;
      btRigidBody ground(0, nullptr, terrain.shape.get());
      ground.setFriction(0);
      world.world.addRigidBody(&ground);
      btRigidBody& body =
          world.addCloud(cloud.field, 0.5, at({btScalar(-0.2), btScalar(0.05), btScalar(0.06)}));
      body.setLinearVelocity({1, btScalar(0.2), 0});
      const double start = energyOf(body);
      double most = start, deepest = -1;
      for (int i = 0; i < 120; ++i) {
        world.step(1.0 / 240);
        most = std::max(most, energyOf(body));
        deepest = std::max(deepest, depthInBumps(body, *cloud.field));
      }
      EXPECT_LT(most, start + 1e-3) << cloud.name << " on " << name;
      EXPECT_LT(deepest, kVoxel) << cloud.name << " on " << name;
      EXPECT_GT(deepest, -0.05) << cloud.name << " on " << name << " has left the ground";
      world.world.removeRigidBody(&ground);
    }
}

// About the y axis [N m].
double torque(const BulletWorld& world) {
  double sum = 0;
  for (const btManifoldPoint& p : world.points())
    sum += std::max(0.0, -double(p.getDistance()) * p.m_combinedContactStiffness1) *
           p.getPositionWorldOnA().x();
  return sum;
}

TEST(TriangleMotion, ASheetsBorderCarriesAsATablesEdgeDoes) {
  const TestCloud& box = testClouds()[0];
  const double half = kSide / 2;
  for (const double depth : {0.2, 1.0, 3.0}) {
    BulletWorld truth(spring(1e4)), world(spring(1e4));
    truth.add(std::make_unique<btBoxShape>(bullet({half, half, half})), 0,
              at({btScalar(-half), 0, btScalar(-half)}));
    Kept mesh = bvhShape(groundMesh(20));
    world.add(std::move(mesh.shape), 0, at({btScalar(-half), 0, 0}));
    for (BulletWorld* w : {&truth, &world}) {
      w->addCloud(box.field, 1,
                  at({btScalar(0.01), 0, btScalar(box.below - depth * kVoxel)},
                     btQuaternion(btVector3(0, 0, 1), btScalar(0.3))));
      w->detect();
    }
    EXPECT_NEAR(force(world), force(truth), 0.02 * force(truth)) << depth;
    EXPECT_NEAR(torque(world), torque(truth), 0.1 * 0.04 * force(truth)) << depth;
  }
}

// An upright sheet across x that ends at z = 0.
Mesh fenceMesh(double x) {
  Mesh fence = groundMesh(20);
  for (auto& v : fence.vertices) v = Vec3(x, v.y(), v.x() - kSide / 2);
  return fence;
}

// What a fall onto a fence gains [J], and how far the body comes down and aside [m].
struct FenceFall {
  double gained = 0, lowest = 1, aside = 0;
  bool touched = false;
};

FenceFall fallOnFence(const TestCloud& cloud, double x, const btTransform& place, double hertz,
                      bool turns) {
  BulletWorld world;
  Kept kept = bvhShape(fenceMesh(x));
  world.add(std::move(kept.shape), 0, at({0, 0, 0}));
  btRigidBody& body = world.addCloud(cloud.field, 0.5, place);
  if (!turns) body.setAngularFactor(btVector3(0, 0, 0));
  const double start = energyOf(body);
  FenceFall fall;
  for (int i = 0; i < 0.5 * hertz; ++i) {
    world.step(1 / hertz);
    fall.gained = std::max(fall.gained, energyOf(body) - start);
    fall.touched |= force(world) > 0;
    const btVector3 origin = body.getWorldTransform().getOrigin();
    fall.lowest = std::min(fall.lowest, double(origin.z()));
    fall.aside = std::max(fall.aside, std::abs(double(origin.x())));
  }
  return fall;
}

TEST(TriangleMotion, TheBorderOfAFenceHoldsAndGivesNoEnergy) {
  for (const TestCloud& cloud : testClouds())
    for (const double hertz : {60.0, 240.0})
      for (const double x : {0.0, 0.0003, 0.002, 0.005, 0.009}) {
        const btTransform place = at({0, 0, btScalar(cloud.below + 0.003)});
        const FenceFall held = fallOnFence(cloud, x, place, hertz, false);
        SCOPED_TRACE(std::string(cloud.name) + " at " + std::to_string(x) + ", " +
                     std::to_string(hertz) + " Hz");
        EXPECT_LT(held.gained, 1e-4);
        // A torus and a cup are round there, and may slide.
        const bool flat = cloud.name == std::string("box");
        EXPECT_GT(held.lowest, cloud.below - (flat ? 0.3 : 1) * kVoxel);
        EXPECT_LT(held.aside, flat ? 1e-4 : 0.01);
        EXPECT_LT(fallOnFence(cloud, x, place, hertz, true).gained, 1e-4) << "turns";
      }
}

TEST(TriangleMotion, FallsOntoAFenceGiveNoEnergy) {
  // From 4 cm and in any direction. At 60 Hz they come three voxels deep in a step, and one in
  // twenty gains (docs/limits.md).
  std::mt19937 random(7);
  const auto one = [&random] { return btScalar(int(random() % 2001) - 1000) / 1000; };
  for (const TestCloud& cloud : testClouds())
    for (int i = 0; i < 12; ++i) {
      const btScalar x = one(), y = one(), z = one(), w = one(), across = one(), along = one();
      const btQuaternion turn =
          i % 2 == 0 ? btQuaternion(btVector3(0, 0, 1), w) : btQuaternion(x, y, z, w).normalized();
      const btVector3 origin(btScalar(0.015) * across, btScalar(0.01) * along, btScalar(0.07));
      const FenceFall fall = fallOnFence(cloud, 0, at(origin, turn), 240, true);
      EXPECT_LT(fall.gained, 1e-4) << cloud.name << ", " << i;
      EXPECT_TRUE(fall.touched) << cloud.name << ", " << i;
    }
}

struct Nearest : btCollisionWorld::ContactResultCallback {
  explicit Nearest(double within) { m_closestDistanceThreshold = btScalar(within); }
  btScalar addSingleResult(btManifoldPoint& p, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    distance = std::min(distance, double(p.getDistance()));
    return 0;
  }
  double distance = 1;
};

TEST(TriangleMotion, QueriesMeasureGapsToTriangles) {
  for (const Ground& ground : grounds()) {
    BulletWorld world;
    Kept kept = ground.make();
    btRigidBody& floor = world.add(std::move(kept.shape), 0, at({0, 0, 0}));
    const TestCloud& box = testClouds()[0];
    btRigidBody& body = world.addCloud(box.field, 1, at({0, 0, btScalar(box.below + 0.05)}));
    Nearest wide(0.08), narrow(0.04);
    world.world.contactPairTest(&body, &floor, wide);
    world.world.contactPairTest(&floor, &body, narrow);
    if (std::string(ground.name).rfind("compound", 0) == 0) continue;  // Bullet's boxes are apart
    EXPECT_NEAR(wide.distance, 0.05, 0.05 * kVoxel) << ground.name;
    EXPECT_EQ(narrow.distance, 1) << ground.name;
  }
}

TEST(TriangleMotion, AClampAroundASheetsBorderIsPushedByTheJawThatTouches) {
  // Jaws of 8 voxels, 6 apart; the sheet ends 20 voxels inside.
  const Vec3 unit = Vec3::Constant(kVoxel);
  const auto part = [&](const Vec3& low, const Vec3& high) {
    return test::boxMesh(low.cwiseProduct(unit), high.cwiseProduct(unit));
  };
  const Mesh clamp = test::joined(
      test::joined(part({-20, -10, 3}, {12, 10, 11}), part({-20, -10, -11}, {12, 10, -3})),
      part({-20, -10, -11}, {-12, 10, 11}));
  const auto field = fieldOf(clamp, kVoxel);
  Mesh sheet = groundMesh(20);
  for (auto& v : sheet.vertices) v.x() += kSide / 2 - 8 * kVoxel;
  for (const double z : {0.0, 3.3, -3.3, 2.5, -2.5}) {
    BulletWorld world(spring(1e4));
    Kept kept = bvhShape(sheet);
    btRigidBody& floor = world.add(std::move(kept.shape), 0, at({0, 0, 0}));
    world.addCloud(field, 1, at({0, 0, btScalar(z * kVoxel)}));
    world.detect();
    double push = 0;
    for (const btManifoldPoint& p : world.points())
      push += std::max(0.0, -double(p.getDistance())) * p.m_combinedContactStiffness1 *
              p.m_normalWorldOnB.z();
    const btPersistentManifold* first = world.dispatcher.getNumManifolds()
                                            ? world.dispatcher.getManifoldByIndexInternal(0)
                                            : nullptr;
    if (first && first->getBody0() == &floor) push = -push;
    // The lower jaw's top is at z - 3 voxels, the upper jaw's underside at z + 3.
    const double wanted = z > 3 ? -(z - 3) : z < -3 ? -3 - z : 0;
    EXPECT_NEAR(push, wanted * kVoxel * 1e4, 0.05 * 0.3 * kVoxel * 1e4) << z;
  }
}

}  // namespace
}  // namespace cloudcontact::testing::triangle_motion_test
