// Bullet's own convexSweepTest on clouds, beside the meshes that they were digitized from, and
// continuous collision detection of Bullet's bodies, which sweeps.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "bullet/query_bodies.h"

namespace cloudcontact::testing::sweep_query_test {
namespace {

using ClosestSweep = btCollisionWorld::ClosestConvexResultCallback;

struct Errors {
  int hits = 0, faces = 0, differ = 0;
  double place = 0, normal = 0;  // largest [voxels], [deg]
};

// The shape's way before the hit, along the mesh's normal; the normal beside the mesh's face.
Errors compare(const QueryBody& body, int sweeps) {
  QueryWorld cloud(body, true), mesh(body, false);
  btSphereShape ball(btScalar(0.25));
  btBoxShape box(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.15)));
  btCapsuleShape capsule(btScalar(0.15), btScalar(0.4));
  const btConvexShape* const shapes[] = {&ball, &box, &capsule};
  Random random(5);
  Errors errors;
  for (int i = 0; i < sweeps; ++i) {
    const auto [start, end] = randomSegment(random, body.radius, 0.6);
    const Eigen::Quaterniond turn = random.rotation();
    const btQuaternion turned(btScalar(turn.x()), btScalar(turn.y()), btScalar(turn.z()),
                              btScalar(turn.w()));
    const btTransform from(turned, start), to(turned, end);
    ClosestSweep onCloud(start, end), onMesh(start, end);
    cloud.scene.world.convexSweepTest(shapes[i % 3], from, to, onCloud);
    mesh.scene.world.convexSweepTest(shapes[i % 3], from, to, onMesh);
    const btVector3 way = end - start;
    const bool grazes =
        onMesh.hasHit() && std::abs(way.normalized().dot(onMesh.m_hitNormalWorld)) < 0.17;
    if (onCloud.hasHit() != onMesh.hasHit()) {
      errors.differ += !grazes;
      continue;
    }
    if (!onMesh.hasHit() || grazes) continue;
    ++errors.hits;
    if (besideEdge(mesh.faces(), onMesh.m_hitPointWorld, onMesh.m_hitNormalWorld)) continue;
    ++errors.faces;
    const double off = (onCloud.m_closestHitFraction - onMesh.m_closestHitFraction) *
                       way.dot(onMesh.m_hitNormalWorld);
    errors.place = std::max(errors.place, std::abs(off) / kQueryVoxel);
    const btVector3 normal = nearestFace(mesh.faces(), onCloud.m_hitPointWorld);
    errors.normal = std::max(errors.normal, degreesBetween(onCloud.m_hitNormalWorld, normal));
  }
  return errors;
}

TEST(ConvexSweepTest, HitsWhereTheMeshIs) {
  for (const QueryBody& body : queryBodies(0.5)) {
    const Errors errors = compare(body, 200);
    EXPECT_GT(errors.faces, 40) << body.name;
    EXPECT_LE(errors.differ, 1) << body.name;
    EXPECT_LT(errors.place, 0.1) << body.name;
    EXPECT_LT(errors.normal, 1) << body.name;
  }
}

// The triangles are made by the first query, whichever thread asks.
TEST(ConvexSweepTest, ThreadsShareTheTriangles) {
  const CloudShape shape(fieldOf(boxMesh({0.4, 0.4, 0.4}), 0.01));
  struct Area : btTriangleCallback {
    void processTriangle(btVector3* corners, int, int) override {
      const btVector3 twice = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      area += twice.length() / 2;
      outward &= twice.dot(corners[0]) > 0;
    }
    double area = 0;
    bool outward = true;
  };
  std::vector<Area> found(4);
  std::vector<std::thread> threads;
  for (Area& own : found)
    threads.emplace_back([&shape, &own] {
      shape.processAllTriangles(&own, {-1, -1, -1}, {1, 1, 1});
    });
  for (std::thread& thread : threads) thread.join();
  for (const Area& own : found) {
    EXPECT_EQ(own.area, found[0].area);
    EXPECT_NEAR(own.area, 6 * 0.16, 0.02);
    EXPECT_TRUE(own.outward);
  }
  Area none;
  shape.processAllTriangles(&none, {btScalar(0.25), -1, -1}, {1, 1, 1});
  EXPECT_EQ(none.area, 0) << "in bounds only";
}

// A wall of two voxels and bodies that fly at it at 60 Hz.
TEST(Ccd, FastBodiesStopAtAWallOfTwoVoxels) {
  constexpr double kWallVoxel = 0.02;
  const auto wall = fieldOf(boxMesh({2 * kWallVoxel, 1, 1}), kWallVoxel);
  for (const double speed : {10., 100., 1000.})
    for (const bool round : {true, false}) {
      BulletWorld scene;
      scene.world.setGravity({0, 0, 0});
      scene.addCloud(wall, 0, at({0, 0, 0}));
      std::unique_ptr<btConvexShape> shape;
      if (round) shape = std::make_unique<btSphereShape>(btScalar(0.1));
      if (!round) shape = std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.1));
      btRigidBody& body = scene.add(std::move(shape), 1, at({btScalar(-0.61), 0, 0}));
      body.setCcdMotionThreshold(btScalar(0.05));
      body.setCcdSweptSphereRadius(btScalar(0.09));
      body.setLinearVelocity({btScalar(speed), 0, 0});
      double furthest = -1;
      for (int i = 0; i < 60; ++i) {
        scene.step(1. / 60);
        furthest = std::max<double>(furthest, body.getWorldTransform().getOrigin().x());
      }
      // The swept ball is a centimeter smaller than the body.
      EXPECT_LT(furthest, -kWallVoxel - 0.09 + 0.005) << speed << " m/s, round " << round;
      EXPECT_LT(body.getLinearVelocity().length(), speed) << speed << " m/s, round " << round;
    }
}

}  // namespace
}  // namespace cloudcontact::testing::sweep_query_test
