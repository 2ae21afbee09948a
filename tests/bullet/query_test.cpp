// contactTest, contactPairTest, compounds, rays and drawing.
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <cloudcontact/bullet/query.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::query_test {
namespace {

constexpr double kVoxel = 0.01;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}

std::shared_ptr<const SurfaceField> ballField() {
  static const auto field = fieldOf(sphereMesh(0.2, 1e-5), kVoxel);
  return field;
}

struct Collected : btCollisionWorld::ContactResultCallback {
  std::vector<btManifoldPoint> points;
  std::vector<const btCollisionObject*> first;
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    points.push_back(point);
    first.push_back(a->getCollisionObject());
    return 0;
  }
};

double deepest(const std::vector<btManifoldPoint>& points) {
  double distance = 1e9;
  for (const btManifoldPoint& p : points) distance = std::min<double>(distance, p.m_distance1);
  return distance;
}

TEST(ContactTest, SeesThePointsAndLeavesTheWorldAlone) {
  BulletWorld scene;
  btRigidBody& ground = scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.097)}));
  scene.detect();
  const auto written = scene.points();
  ASSERT_FALSE(written.empty());

  Collected all, pair, swapped;
  scene.world.contactTest(&cube, all);
  scene.world.contactPairTest(&cube, &ground, pair);
  scene.world.contactPairTest(&ground, &cube, swapped);
  for (const Collected* c : {&all, &pair, &swapped}) {
    ASSERT_EQ(c->points.size(), written.size());
    EXPECT_NEAR(deepest(c->points), -0.003, 0.1 * kVoxel);
    for (std::size_t i = 0; i < c->points.size(); ++i) {
      const bool cubeIsFirst = c->first[i] == &cube;
      const btManifoldPoint& p = c->points[i];
      EXPECT_NEAR(p.m_normalWorldOnB.z(), cubeIsFirst ? 1 : -1, 1e-4);
      // The point on A is A's: the cube's lowest face is 3 mm under the ground.
      EXPECT_NEAR(p.m_positionWorldOnA.z(), cubeIsFirst ? -0.003 : 0, 0.1 * kVoxel);
    }
  }
  EXPECT_NE(pair.first[0], swapped.first[0]);
  const auto after = scene.points();
  ASSERT_EQ(after.size(), written.size()) << "a query changed the manifolds";
  EXPECT_EQ(after[0].m_lifeTime, written[0].m_lifeTime);
}

TEST(ContactTest, ReportsNothingApartAndTheGapWithinAThreshold) {
  BulletWorld scene;
  btRigidBody& ground = scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.105)}));
  Collected none, near;
  scene.world.contactPairTest(&cube, &ground, none);
  EXPECT_TRUE(none.points.empty());
  near.m_closestDistanceThreshold = btScalar(0.01);
  scene.world.contactPairTest(&cube, &ground, near);
  ASSERT_FALSE(near.points.empty());
  EXPECT_NEAR(deepest(near.points), 0.005, 0.1 * kVoxel);
}

TEST(ContactTest, ReportsTheGapOfCloudsFarApart) {
  CloudShape box(cubeField());
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(at({0, 0, 0}), &box);
  BulletWorld scene;
  const btQuaternion turn(btVector3(1, 2, 3).normalized(), btScalar(0.8));
  btRigidBody& ball = scene.addCloud(ballField(), 1, at({0, 0, 0}, turn));
  btRigidBody& cube = scene.add(std::move(compound), 1, at({0, 0, 0}));
  for (const double gap : {0.02, 0.1, 0.5, 3.}) {
    const double center = 0.3 + gap;  // the ball's radius and half the cube
    cube.setWorldTransform(at({0, btScalar(0.03), btScalar(center)}));
    Collected near, far, swapped;
    near.m_closestDistanceThreshold = btScalar(gap - 0.01);
    far.m_closestDistanceThreshold = swapped.m_closestDistanceThreshold = btScalar(gap + 0.01);
    scene.world.contactPairTest(&ball, &cube, near);
    scene.world.contactPairTest(&ball, &cube, far);
    scene.world.contactPairTest(&cube, &ball, swapped);
    EXPECT_TRUE(near.points.empty()) << gap;
    for (const Collected* c : {&far, &swapped}) {
      ASSERT_EQ(c->points.size(), 1u) << gap;
      EXPECT_NEAR(deepest(c->points), gap, 0.1 * kVoxel);
      const bool ballFirst = c->first[0] == &ball;
      EXPECT_NEAR(c->points[0].m_normalWorldOnB.z(), ballFirst ? -1 : 1, 1e-3);
      EXPECT_NEAR(
          (ballFirst ? c->points[0].m_positionWorldOnA : c->points[0].m_positionWorldOnB).z(), 0.2,
          0.1 * kVoxel);
    }
  }
}

TEST(Compound, AChildIsTheBareShape) {
  BulletWorld bare, child;
  const btTransform place = at({btScalar(0.3), 0, btScalar(0.197)}, btQuaternion({1, 2, 3}, 1));
  const btTransform inner =
      at({btScalar(0.1), btScalar(-0.2), btScalar(0.05)}, btQuaternion({0, 1, 1}, btScalar(0.7)));
  bare.addGround();
  bare.addCloud(ballField(), 1, place);
  const std::unique_ptr<CloudShape> shape = exactCloud(ballField());
  for (const bool tree : {true, false}) {
    BulletWorld scene;
    scene.addGround();
    auto compound = std::make_unique<btCompoundShape>(tree);
    compound->addChildShape(at({5, 5, 5}), shape.get());  // a second child, far away
    compound->addChildShape(inner, shape.get());
    scene.add(std::move(compound), 1, place * inner.inverse());
    for (int i = 0; i < 3; ++i) {
      scene.detect();
      bare.detect();
    }
    // Bullet passes a compound's children as the first body, which swaps A and B.
    const auto a = bare.points(), b = scene.points();
    ASSERT_EQ(a.size(), b.size()) << "tree " << tree;
    ASSERT_FALSE(a.empty());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_NEAR(a[i].m_positionWorldOnA.distance(b[i].m_positionWorldOnB), 0, 1e-5);
      EXPECT_NEAR((a[i].m_normalWorldOnB + b[i].m_normalWorldOnB).length(), 0, 1e-4);
      EXPECT_NEAR(a[i].m_distance1, b[i].m_distance1, 1e-6);
      EXPECT_EQ(b[i].m_index0, 1) << "which child, for the user";
    }
  }
}

TEST(Compound, ContactTestReachesChildrenOnEitherSide) {
  CloudShape shape(cubeField());
  BulletWorld scene;
  const auto boxed = [&] {
    auto compound = std::make_unique<btCompoundShape>();
    compound->addChildShape(at({0, 0, 0}), &shape);
    return compound;
  };
  btRigidBody& low = scene.add(boxed(), 1, at({0, 0, 0}));
  btRigidBody& high = scene.add(boxed(), 1, at({0, 0, btScalar(0.197)}));
  Collected both, swapped;
  scene.world.contactPairTest(&low, &high, both);
  scene.world.contactPairTest(&high, &low, swapped);
  ASSERT_FALSE(both.points.empty());
  EXPECT_EQ(both.points.size(), swapped.points.size());
  EXPECT_NEAR(deepest(both.points), -0.003, 0.1 * kVoxel);
}

TEST(Robustness, ABadPoseHasNoContactsAndIsCounted) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    BulletWorld scene;
    btRigidBody& ground = scene.addGround();
    btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.097)}));
    scene.detect();
    btTransform place = cube.getWorldTransform();
    place.setOrigin({0, 0, btScalar(bad)});
    cube.setWorldTransform(place);
    Collected found;
    scene.world.contactPairTest(&cube, &ground, found);
    EXPECT_TRUE(found.points.empty());
    EXPECT_EQ(scene.clouds.statistics().failures, 1u);
    EXPECT_NE(scene.clouds.statistics().lastFailure.find("pose"), std::string::npos);
    cube.setWorldTransform(at({0, 0, btScalar(0.097)}));
  }
}

TEST(Robustness, EmptyShapesAndFlatHullsAreNoContactAndNoCrash) {
  BulletWorld scene;
  scene.addCloud(cubeField(), 1, at({0, 0, 0}));
  btTriangleMesh none;
  none.addTriangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0});
  scene.add(std::make_unique<btBvhTriangleMeshShape>(&none, true), 0, at({0, 0, 0}));
  scene.add(std::make_unique<btEmptyShape>(), 0, at({0, 0, 0}));
  scene.step(1. / 60);
  EXPECT_EQ(scene.clouds.statistics().failures, 0u);
  auto flat = std::make_unique<btConvexHullShape>();
  for (const btVector3& corner : {btVector3(-1, -1, 0), btVector3(1, -1, 0), btVector3(0, 1, 0)})
    flat->addPoint(corner);
  scene.add(std::move(flat), 0, at({0, 0, 0}));
  for (int i = 0; i < 3; ++i) scene.step(1. / 60);
  EXPECT_TRUE(scene.points().empty());
  EXPECT_EQ(scene.clouds.statistics().failures, 3u) << "the flat hull is no failure";
}

TEST(Ray, EntersTheCubeAndTheBallByTheirFormulas) {
  BulletWorld scene;
  const btQuaternion turn(btVector3(1, 2, 3).normalized(), btScalar(0.8));
  btRigidBody& ball = scene.addCloud(ballField(), 1, at({1, 2, 3}, turn));
  Random random(3);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 center(1, 2, 3), from = center + 0.6 * (random.rotation() * Vec3::UnitX());
    const Vec3 to = center + 0.7 * (random.inCube() - Vec3(0.5, 0.5, 0.5));
    const Vec3 along = to - from, offset = from - center;
    // |from + t along - center| = 0.2
    const double a = along.squaredNorm(), b = offset.dot(along), c = offset.squaredNorm() - 0.04;
    const double root = b * b - a * c, t = (-b - std::sqrt(root)) / a;
    const double miss = (offset - b / a * along).norm();
    if (std::abs(miss - 0.2) < 0.02 || std::abs(t - 1) < 0.05)
      continue;  // grazes, or ends at the surface
    const btVector3 start(btScalar(from.x()), btScalar(from.y()), btScalar(from.z()));
    const btVector3 end(btScalar(to.x()), btScalar(to.y()), btScalar(to.z()));
    btCollisionWorld::ClosestRayResultCallback hit(start, end);
    rayTest(scene.world, start, end, hit);
    ASSERT_EQ(hit.hasHit(), root > 0 && t > 0 && t < 1) << "ray " << i << " t " << t;
    if (!hit.hasHit()) continue;
    ++hits;
    EXPECT_EQ(hit.m_collisionObject, &ball);
    EXPECT_NEAR(hit.m_closestHitFraction * along.norm(), t * along.norm(), 0.1 * kVoxel);
    const Vec3 normal = (from + t * along - center).normalized();
    // One plane a voxel: half a voxel's diagonal turns the normal by 0.87 / 20 of a radius.
    EXPECT_GT(hit.m_hitNormalWorld.dot(
                  {btScalar(normal.x()), btScalar(normal.y()), btScalar(normal.z())}),
              std::cos(0.87 / 20));
  }
  EXPECT_GT(hits, 50);
}

TEST(Ray, TakesTheNearestOfCloudsBoxesAndCompoundChildren) {
  BulletWorld scene;
  CloudShape shape(cubeField());
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(at({9, 9, 9}), &shape);
  compound->addChildShape(at({0, 0, btScalar(0.5)}), &shape);
  btRigidBody& child = scene.add(std::move(compound), 1, at({0, 0, 0}));
  btRigidBody& box = scene.add(std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.1)), 1,
                               at({0, 0, btScalar(-0.5)}));
  btRigidBody& cloud = scene.addCloud(cubeField(), 1, at({0, 0, 0}));

  const btVector3 up(0, 0, 2), down(0, 0, -2);
  struct {
    btVector3 from, to;
    const btRigidBody* hit;
    double z;
  } const cases[] = {
      {up, down, &child, 0.6}, {down, up, &box, -0.6}, {{0, 0, btScalar(0.3)}, down, &cloud, 0.1}};
  for (const auto& c : cases) {
    btCollisionWorld::ClosestRayResultCallback hit(c.from, c.to);
    rayTest(scene.world, c.from, c.to, hit);
    ASSERT_EQ(hit.m_collisionObject, c.hit);
    EXPECT_NEAR(hit.m_hitPointWorld.z(), c.z, 0.05 * kVoxel);
    EXPECT_NEAR(hit.m_hitNormalWorld.z(), c.from.z() > c.to.z() ? 1 : -1, 1e-3);
  }
  btCollisionWorld::AllHitsRayResultCallback all(up, down);
  rayTest(scene.world, up, down, all);
  EXPECT_EQ(all.m_collisionObjects.size(), 5) << "each cloud twice, as a mesh";
  btCollisionWorld::ClosestRayResultCallback masked(up, down);
  masked.m_collisionFilterMask = 0;
  rayTest(scene.world, up, down, masked);
  EXPECT_FALSE(masked.hasHit());
  btCollisionWorld::ClosestRayResultCallback point(up, up);
  rayTest(scene.world, up, up, point);
  EXPECT_FALSE(point.hasHit());
}

// Counts lines, and how far their ends are from the cube's surface.
struct Pen : btIDebugDraw {
  int mode = 0, lines = 0;
  double furthest = 0;
  void drawLine(const btVector3& a, const btVector3& b, const btVector3&) override {
    ++lines;
    for (const btVector3& end : {a, b}) {
      const Vec3 local(end.x(), end.y(), end.z());
      furthest = std::max(furthest, std::abs(solidAt(Box{{0.1, 0.1, 0.1}}, local).depth));
    }
  }
  void drawContactPoint(const btVector3&, const btVector3&, btScalar, int,
                        const btVector3&) override {}
  void reportErrorWarning(const char*) override {}
  void draw3dText(const btVector3&, const char*) override {}
  void setDebugMode(int wanted) override { mode = wanted; }
  int getDebugMode() const override { return mode; }
};

TEST(DebugDraw, DrawsSurfaceAndPatchesInTheirModesOnly) {
  BulletWorld scene;
  scene.addCloud(cubeField(), 1, at({0, 0, 0}));
  scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(-0.097)), 0,
            at({0, 0, 0}));
  scene.detect();
  scene.world.getCollisionObjectArray()[1]->setCollisionFlags(
      btCollisionObject::CF_STATIC_OBJECT | btCollisionObject::CF_DISABLE_VISUALIZE_OBJECT);
  Pen none, surface, contact, bullets;
  bullets.setDebugMode(btIDebugDraw::DBG_DrawWireframe);
  scene.world.setDebugDrawer(&bullets);
  scene.world.debugDrawWorld();
  scene.world.setDebugDrawer(nullptr);
  EXPECT_GT(bullets.lines, 6 * 20 * 20 * 2 * 3 / 2);
  EXPECT_LT(bullets.lines, 6 * 20 * 20 * 2 * 3 * 2) << "two triangles a surface voxel";
  EXPECT_LT(bullets.furthest, 0.5 * kVoxel);
  debugDraw(scene.world, none);
  EXPECT_EQ(none.lines, 0);
  surface.setDebugMode(btIDebugDraw::DBG_DrawWireframe);
  debugDraw(scene.world, surface);
  EXPECT_GT(surface.lines, 6 * 20 * 20 / 2);
  EXPECT_LT(surface.furthest, kVoxel);
  contact.setDebugMode(btIDebugDraw::DBG_DrawContactPoints);
  debugDraw(scene.world, contact);
  EXPECT_EQ(contact.lines, static_cast<int>(scene.points().size()) + 1);
}

}  // namespace
}  // namespace cloudcontact::testing::query_test
