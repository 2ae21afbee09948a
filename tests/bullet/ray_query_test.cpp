// Bullet's own rayTest on clouds: beside the meshes that they were digitized from.
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <cloudcontact/bullet/query.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bullet/query_bodies.h"

namespace cloudcontact::testing::ray_query_test {
namespace {

using ClosestRay = btCollisionWorld::ClosestRayResultCallback;

struct Errors {
  int hits = 0, faces = 0, differ = 0;
  double place = 0, normal = 0;  // largest [voxels], [deg]
};

// Distances from the mesh's surface, where the ray meets it at more than 10 deg.
Errors compare(const QueryBody& body, int rays) {
  QueryWorld cloud(body, true), mesh(body, false);
  Random random(5);
  Errors errors;
  for (int i = 0; i < rays; ++i) {
    const auto [from, to] = randomSegment(random, body.radius, 0.5);
    ClosestRay onCloud(from, to), onMesh(from, to);
    cloud.scene.world.rayTest(from, to, onCloud);
    mesh.scene.world.rayTest(from, to, onMesh);
    const btVector3 along = (to - from).normalized();
    const bool grazes = onMesh.hasHit() && std::abs(along.dot(onMesh.m_hitNormalWorld)) < 0.17;
    if (onCloud.hasHit() != onMesh.hasHit()) {
      const bool edge = onMesh.hasHit() &&
                        besideEdge(mesh.faces(), onMesh.m_hitPointWorld, onMesh.m_hitNormalWorld);
      errors.differ += !grazes && !edge;
      continue;
    }
    if (!onMesh.hasHit() || grazes) continue;
    ++errors.hits;
    if (besideEdge(mesh.faces(), onMesh.m_hitPointWorld, onMesh.m_hitNormalWorld)) continue;
    const double off =
        (onCloud.m_hitPointWorld - onMesh.m_hitPointWorld).dot(onMesh.m_hitNormalWorld);
    const double angle = degreesBetween(onCloud.m_hitNormalWorld, onMesh.m_hitNormalWorld);
    ++errors.faces;
    errors.place = std::max(errors.place, std::abs(off) / kQueryVoxel);
    errors.normal = std::max(errors.normal, angle);
  }
  return errors;
}

TEST(RayTest, HitsWhereTheMeshIs) {
  for (const QueryBody& body : queryBodies(0.5)) {
    const Errors errors = compare(body, 1700);
    EXPECT_GT(errors.faces, 400) << body.name;
    EXPECT_LE(errors.differ, 2) << body.name;
    EXPECT_LT(errors.place, 0.1) << body.name;
    EXPECT_LT(errors.normal, 1) << body.name;
  }
}

// Each point where a ray passes the ball's surface, by the flags of the callback.
struct Crossing {
  double fraction, facing;  // of its normal along the ray
};
std::vector<Crossing> crossings(const btCollisionWorld& world, const btVector3& from,
                                const btVector3& to, unsigned flags) {
  btCollisionWorld::AllHitsRayResultCallback hits(from, to);
  hits.m_flags = flags;
  world.rayTest(from, to, hits);
  std::vector<Crossing> all;
  for (int i = 0; i < hits.m_hitFractions.size(); ++i)
    all.push_back({hits.m_hitFractions[i], hits.m_hitNormalWorld[i].dot((to - from).normalized())});
  std::sort(all.begin(), all.end(),
            [](const Crossing& a, const Crossing& b) { return a.fraction < b.fraction; });
  return all;
}

TEST(RayTest, FindsAllCrossingsAsMeshesDo) {
  const QueryBody torus = queryBodies(1)[2];
  QueryWorld cloud(torus, true), mesh(torus, false);
  Random random(9);
  using Flags = btTriangleRaycastCallback::EFlags;
  int inner = 0;
  for (int i = 0; i < 600; ++i) {
    auto [from, to] = randomSegment(random, torus.radius, 0.5);
    if (i % 2) from = from.lerp(to, btScalar(0.5));  // some begin inside
    for (const unsigned flags : {unsigned(Flags::kF_None), unsigned(Flags::kF_FilterBackfaces),
                                 unsigned(Flags::kF_KeepUnflippedNormal)}) {
      const auto own = crossings(cloud.scene.world, from, to, flags);
      const auto others = crossings(mesh.scene.world, from, to, flags);
      const bool grazes = std::any_of(others.begin(), others.end(),
                                      [](const Crossing& c) { return std::abs(c.facing) < 0.3; });
      if (grazes || own.size() != others.size()) {
        EXPECT_TRUE(grazes ||
                    std::any_of(own.begin(), own.end(),
                                [](const Crossing& c) { return std::abs(c.facing) < 0.3; }))
            << "ray " << i << " flags " << flags;
        continue;
      }
      for (std::size_t k = 0; k < own.size(); ++k) {
        EXPECT_NEAR(own[k].fraction * from.distance(to), others[k].fraction * from.distance(to),
                    0.3 * kQueryVoxel);
        EXPECT_NEAR(own[k].facing, others[k].facing, 0.03);
      }
      inner += own.size() % 2;
    }
  }
  EXPECT_GT(inner, 50) << "rays from inside";
}

TEST(RayTest, NormalsOfACoarseBallAreItsOwn) {
  BulletWorld scene;
  scene.addCloud(fieldOf(test::sphereMesh(0.05, 5), 0.01), 0, at({0, 0, 0}));  // 5 voxels
  Random random(3);
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const btVector3 from = toBt(Vec3(0.2 * (random.rotation() * Vec3::UnitX())));
    const btVector3 to = toBt(Vec3(0.04 * (random.inCube() - Vec3(0.5, 0.5, 0.5))));
    ClosestRay hit(from, to);
    scene.world.rayTest(from, to, hit);
    ASSERT_TRUE(hit.hasHit());
    worst = std::max(worst, degreesBetween(hit.m_hitNormalWorld, hit.m_hitPointWorld));
    EXPECT_NEAR(hit.m_hitPointWorld.length(), 0.05, 0.001);
  }
  EXPECT_LT(worst, 3);
}

TEST(RayTest, NamesTheShapeByItsUserIndexAndTheChildByOurs) {
  CloudShape one(fieldOf(boxMesh({0.2, 0.2, 0.2}), 0.01)), two(one);
  two.setUserIndex(7);
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(at({9, 9, 9}), &two);
  compound->addChildShape(at({0, 0, 0}), &two);
  compound->addChildShape(at({0, 0, 1}), &one);
  BulletWorld scene;
  scene.add(std::move(compound), 0, at({0, 0, 0}));
  struct Named : ClosestRay {
    using ClosestRay::ClosestRay;
    btScalar addSingleResult(btCollisionWorld::LocalRayResult& hit, bool inWorld) override {
      part = hit.m_localShapeInfo->m_shapePart;
      index = hit.m_localShapeInfo->m_triangleIndex;
      return ClosestRay::addSingleResult(hit, inWorld);
    }
    int part = 99, index = 99;
  };
  const btVector3 left(-1, 0, 0), right(1, 0, 0), up(0, 0, 1);
  Named low(left, right), high(left + up, right + up), child(left, right);
  scene.world.rayTest(left, right, low);
  scene.world.rayTest(left + up, right + up, high);
  rayTest(scene.world, left, right, child);
  EXPECT_EQ(low.part, -1);
  EXPECT_EQ(low.index, 7);
  EXPECT_EQ(high.index, -1);
  EXPECT_EQ(child.part, -1);
  EXPECT_EQ(child.index, 1);
}

}  // namespace
}  // namespace cloudcontact::testing::ray_query_test
