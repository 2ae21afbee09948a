// What the algorithm writes into Bullet's manifolds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::manifold_test {
namespace {

constexpr double kVoxel = 0.01;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}

// Four legs of a table without its top.
std::shared_ptr<const SurfaceField> legsField() {
  Mesh mesh;
  for (const double x : {-0.2, 0.2})
    for (const double y : {-0.2, 0.2}) {
      const Mesh leg =
          transformed(boxMesh({0.08, 0.08, 0.2}), {Eigen::Quaterniond::Identity(), {x, y, 0}});
      const int first = static_cast<int>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(), leg.vertices.begin(), leg.vertices.end());
      for (const auto& t : leg.triangles) mesh.triangles.push_back(t.array() + first);
    }
  return fieldOf(mesh, kVoxel);
}

// A cube 0.3 voxel in the ground, tilted so little that the whole face touches.
btTransform pressed() {
  return at({btScalar(0.01), btScalar(0.02), btScalar(0.097)});
}

void expectConsistent(const btManifoldPoint& point, const btRigidBody& a, const btRigidBody& b) {
  const btVector3 onA = point.m_positionWorldOnB + point.m_normalWorldOnB * point.m_distance1;
  EXPECT_NEAR((onA - point.m_positionWorldOnA).length(), 0, kRounding);
  EXPECT_NEAR(point.m_normalWorldOnB.length(), 1, kRounding);
  EXPECT_NEAR((a.getWorldTransform() * point.m_localPointA - point.m_positionWorldOnA).length(), 0,
              kRounding);
  EXPECT_NEAR((b.getWorldTransform() * point.m_localPointB - point.m_positionWorldOnB).length(), 0,
              kRounding);
}

TEST(Manifold, PointsLieOnBothBodiesAndTheNormalPointsFromBody1ToBody0) {
  for (const bool groundFirst : {true, false}) {
    BulletWorld scene;
    if (groundFirst) scene.addGround();
    btRigidBody& cube = scene.addCloud(cubeField(), 1, pressed());
    if (!groundFirst) scene.addGround();
    scene.detect();
    ASSERT_EQ(scene.dispatcher.getNumManifolds(), 1);
    const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(0);
    const auto* const a = static_cast<const btRigidBody*>(manifold.getBody0());
    const auto* const b = static_cast<const btRigidBody*>(manifold.getBody1());
    EXPECT_EQ(a == &cube, !groundFirst) << "the test meant to swap the bodies";
    ASSERT_GE(manifold.getNumContacts(), 3);
    for (const btManifoldPoint& point : scene.points()) {
      expectConsistent(point, *a, *b);
      EXPECT_NEAR(point.m_normalWorldOnB.z(), a == &cube ? 1 : -1, 1e-4);
      EXPECT_NEAR(point.m_distance1, -0.003, 0.1 * kVoxel);
      EXPECT_NEAR(point.m_positionWorldOnB.z(), a == &cube ? 0 : -0.003, 0.1 * kVoxel);
    }
  }
}

TEST(Manifold, BulletsRefreshAgreesWithTheDepthWritten) {
  // Bullet recomputes a point's distance from the local points, and must get the same.
  BulletWorld scene;
  scene.addGround();
  scene.addCloud(cubeField(), 1, pressed());
  scene.detect();
  const auto before = scene.points();
  btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(0);
  manifold.refreshContactPoints(manifold.getBody0()->getWorldTransform(),
                                manifold.getBody1()->getWorldTransform());
  const auto after = scene.points();
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_NEAR(before[i].m_distance1, after[i].m_distance1, kRounding);
}

TEST(Manifold, SwappedBodiesGiveTheMirroredPoints) {
  BulletWorld one, other;
  one.addGround();
  one.addCloud(cubeField(), 1, pressed());
  other.addCloud(cubeField(), 1, pressed());
  other.addGround();
  one.detect();
  other.detect();
  auto a = one.points();
  const auto b = other.points();
  ASSERT_EQ(a.size(), b.size());
  for (const btManifoldPoint& mirrored : b) {
    const auto same = std::min_element(
        a.begin(), a.end(), [&](const btManifoldPoint& p, const btManifoldPoint& q) {
          return p.m_positionWorldOnA.distance2(mirrored.m_positionWorldOnB) <
                 q.m_positionWorldOnA.distance2(mirrored.m_positionWorldOnB);
        });
    EXPECT_NEAR((same->m_positionWorldOnA - mirrored.m_positionWorldOnB).length(), 0, 1e-6);
    EXPECT_NEAR((same->m_normalWorldOnB + mirrored.m_normalWorldOnB).length(), 0, 1e-6);
    EXPECT_NEAR(same->m_combinedContactStiffness1, mirrored.m_combinedContactStiffness1,
                1e-4 * mirrored.m_combinedContactStiffness1);
  }
}

TEST(Manifold, IdsLastAndImpulsesFollowThem) {
  BulletWorld scene;
  scene.addGround();
  scene.addCloud(cubeField(), 1, pressed());
  for (int i = 0; i < 120; ++i) scene.step(1. / 240);
  std::map<int, btManifoldPoint> solved;
  for (const btManifoldPoint& point : scene.points()) solved[point.m_partId0] = point;
  ASSERT_EQ(solved.size(), scene.points().size()) << "two points with one id";
  double impulse = 0;
  for (const auto& [id, point] : solved) impulse += point.m_appliedImpulse;
  EXPECT_NEAR(impulse, 9.81 / 240, 1e-3 * impulse);  // carries the cube for a step

  // Detection alone rewrites all points but keeps the solver's data.
  scene.detect();
  const auto again = scene.points();
  ASSERT_EQ(again.size(), solved.size());
  for (const btManifoldPoint& point : again) {
    ASSERT_TRUE(solved.count(point.m_partId0)) << "a standing cube's point changed its id";
    const btManifoldPoint& before = solved[point.m_partId0];
    EXPECT_EQ(point.m_appliedImpulse, before.m_appliedImpulse);
    EXPECT_EQ(point.m_appliedImpulseLateral1, before.m_appliedImpulseLateral1);
    EXPECT_EQ(point.m_appliedImpulseLateral2, before.m_appliedImpulseLateral2);
    EXPECT_EQ(point.m_lifeTime, before.m_lifeTime + 1);
  }
}

TEST(Manifold, EachPatchHasItsOwnAndTheyAreKeptWhenEmpty) {
  BulletWorld scene;
  // A box as ground, because a plane's pairs never end: its bounds are infinite.
  scene.add(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), 0, at({0, 0, -1}));
  btRigidBody& legs = scene.addCloud(legsField(), 1, pressed());
  scene.detect();
  EXPECT_EQ(scene.dispatcher.getNumManifolds(), 4);
  std::set<std::pair<bool, bool>> corners;
  for (const btManifoldPoint& point : scene.points()) {
    EXPECT_NEAR(point.m_distance1, -0.003, 0.1 * kVoxel);
    corners.insert({point.m_positionWorldOnA.x() > 0, point.m_positionWorldOnA.y() > 0});
  }
  EXPECT_EQ(corners.size(), 4u) << "a leg without contact";

  // Lifted by less than a voxel, it has points of negative depth.
  legs.setWorldTransform(at({0, 0, btScalar(0.101)}));
  scene.detect();
  EXPECT_EQ(scene.points().size(), 16u);
  for (const btManifoldPoint& point : scene.points())
    EXPECT_NEAR(point.m_distance1, 0.001, 0.1 * kVoxel);

  // Lifted by more, but less than the broad phase's margin, the pair exists without points.
  legs.setWorldTransform(at({0, 0, btScalar(0.1 + 1.5 * kVoxel)}));
  scene.detect();
  EXPECT_EQ(scene.points().size(), 0u);
  EXPECT_EQ(scene.dispatcher.getNumManifolds(), 4);
  legs.setWorldTransform(at({0, 0, 9}));
  legs.setInterpolationWorldTransform(at({0, 0, 9}));  // Bullet's bounds include it
  scene.detect();
  EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0) << "manifolds leaked";
}

TEST(Manifold, StiffnessIsSharedAndRestitutionIsZero) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{5000, 7};
  BulletWorld scene(settings);
  scene.addGround().setRestitution(1);
  btRigidBody& cube = scene.addCloud(cubeField(), 1, pressed());
  cube.setRestitution(1);
  cube.setFriction(0.5);
  scene.detect();
  double stiffness = 0, damping = 0;
  for (const btManifoldPoint& point : scene.points()) {
    EXPECT_TRUE(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
    EXPECT_EQ(point.m_combinedRestitution, 0);
    EXPECT_NEAR(point.m_combinedFriction, 0.25, 1e-6);  // Bullet: the product, the ground's is 0.5
    stiffness += point.m_combinedContactStiffness1;
    damping += point.m_combinedContactDamping1;
  }
  EXPECT_NEAR(stiffness, 5000, 5000 * 1e-5);
  EXPECT_NEAR(damping, 7, 7 * 1e-5);
}

// Of a cube that is pressed in on one side, points state depths that differ less than their forces.
// Yet all rows grow alike, by a quarter of the spring, as the pressed area does, and by what
// turning asks of them: its area is 0.015 deep at one edge and 0.012 in the mean, so b is a
// quarter.
TEST(Manifold, RowsGrowByTheSpringWhateverDepthTheyState) {
  const double step = 1.0 / 240;
  for (const double damping : {0.0, 7.0}) {
    CloudContactSettings settings;
    settings.law = KelvinVoigt{5000, damping};
    BulletWorld scene(settings);
    scene.addGround();
    const btQuaternion tilt(btVector3(0, 1, 0), btScalar(0.03));
    scene.addCloud(cubeField(), 1, at({btScalar(0.01), btScalar(0.02), btScalar(0.088)}, tilt));
    scene.step(step);
    ASSERT_EQ(scene.points().size(), 4u);
    double least = 1e30, most = 0, force = 0, deepest = 0;
    const double slope = step * 5000 / 4, pair = step * step * 5000;  // of 1 kg
    const double turning = 0.5 * 0.25 * pair / (pair + 4);
    for (const btManifoldPoint& point : scene.points()) {
      const double k = point.m_combinedContactStiffness1, c = point.m_combinedContactDamping1;
      EXPECT_GT(step * k + c, (1 - 4e-4) * slope + damping / 4);
      EXPECT_LT(step * k + c, (1 + turning + 4e-4) * slope + damping / 4);
      least = std::min(least, k);
      most = std::max(most, k);
      deepest = std::max(deepest, double(-point.m_distance1));
      force += -k * point.m_distance1;
    }
    EXPECT_GT(most, 1.02 * least);
    // The lower edge is 0.012 + 0.1 sin(0.03) deep. FR = k d, and no point states much more than d.
    EXPECT_NEAR(deepest, 0.015, 0.1 * 0.015);
    EXPECT_LT(deepest, 1.051 * force / 5000);
  }
}

TEST(Manifold, RigidRowsAreBulletsOwn) {
  CloudContactSettings settings;
  settings.law = Rigid{};
  BulletWorld scene(settings);
  scene.addGround().setRestitution(1);
  scene.addCloud(cubeField(), 1, pressed()).setRestitution(btScalar(0.5));
  scene.detect();
  ASSERT_FALSE(scene.points().empty());
  for (const btManifoldPoint& point : scene.points()) {
    EXPECT_FALSE(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
    EXPECT_NEAR(point.m_combinedRestitution, 0.5, 1e-6);
  }
}

TEST(Manifold, FrictionDirectionsFollowTheSlidingAndLastWithoutIt) {
  BulletWorld scene;
  scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, pressed());
  const btVector3 slide = btVector3(3, -1, 0).normalized();
  cube.setLinearVelocity(slide);
  scene.step(1. / 240);
  cube.setLinearVelocity(slide);
  scene.detect();
  auto directions = [&] {
    std::map<int, btVector3> all;
    for (const btManifoldPoint& p : scene.points()) {
      EXPECT_TRUE(p.m_contactPointFlags & BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED);
      EXPECT_NEAR(p.m_lateralFrictionDir1.length(), 1, kRounding);
      EXPECT_NEAR(p.m_lateralFrictionDir1.dot(p.m_normalWorldOnB), 0, kRounding);
      EXPECT_NEAR(p.m_lateralFrictionDir1.dot(p.m_lateralFrictionDir2), 0, kRounding);
      EXPECT_NEAR(p.m_lateralFrictionDir2.dot(p.m_normalWorldOnB), 0, kRounding);
      all[p.m_partId0] = p.m_lateralFrictionDir1;
    }
    return all;
  };
  for (const auto& [id, direction] : directions())
    EXPECT_GT(btFabs(direction.dot(slide)), std::cos(3 / 57.3)) << "not along the sliding";
  // At rest without a load sideways, the rows do not turn.
  for (int i = 0; i < 480; ++i) scene.step(1. / 240);
  const auto resting = directions();
  for (int i = 0; i < 10; ++i) scene.step(1. / 240);
  const auto later = directions();
  ASSERT_EQ(later.size(), resting.size());
  for (const auto& [id, direction] : later) {
    ASSERT_TRUE(resting.count(id));
    EXPECT_NEAR(direction.dot(resting.at(id)), 1, 1e-5);
  }
}

TEST(Manifold, OnASlopeTheFirstFrictionRowFacesDownhill) {
  // Nothing slides and each point carries its own share, but all rows are parallel.
  BulletWorld scene;
  const btVector3 normal = btVector3(btScalar(-0.3), btScalar(-0.2), 1).normalized();
  scene.add(std::make_unique<btStaticPlaneShape>(normal, 0), 0, at({0, 0, 0})).setFriction(1);
  btRigidBody& cube = scene.addCloud(
      cubeField(), 1, at(normal * btScalar(0.1), shortestArcQuat({0, 0, 1}, normal)));
  cube.setFriction(btScalar(0.4));  // 0.36 is needed
  for (int i = 0; i < 240; ++i) scene.step(1. / 240);
  const btVector3 down = (btVector3(0, 0, -1) + normal * normal.z()).normalized();
  ASSERT_FALSE(scene.points().empty());
  for (const btManifoldPoint& point : scene.points())
    EXPECT_GT(btFabs(point.m_lateralFrictionDir1.dot(down)), std::cos(10 / 57.3));
}

// Restores Bullet's contact callbacks, which are global pointers.
struct CallbackGuard {
  ~CallbackGuard() {
    gContactAddedCallback = nullptr;
    gContactStartedCallback = nullptr;
    gContactEndedCallback = nullptr;
    gContactProcessedCallback = nullptr;
    gContactDestroyedCallback = nullptr;
  }
};

TEST(Manifold, BulletsCallbacksAreCalledAsForItsOwnShapes) {
  static int added, started, ended, processed, destroyed;
  added = started = ended = processed = destroyed = 0;
  const CallbackGuard guard;
  gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) {
    ++added;
    point.m_combinedFriction = btScalar(0.125);
    return true;
  };
  gContactStartedCallback = [](btPersistentManifold* const&) { ++started; };
  gContactEndedCallback = [](btPersistentManifold* const&) { ++ended; };
  gContactProcessedCallback = [](btManifoldPoint&, void*, void*) { return ++processed > 0; };
  gContactDestroyedCallback = [](void*) { return ++destroyed > 0; };
  int user = 0;
  {
    BulletWorld scene;
    scene.addGround();
    btRigidBody& cube = scene.addCloud(cubeField(), 1, pressed());
    cube.setCollisionFlags(cube.getCollisionFlags() |
                           btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    scene.detect();
    const int points = static_cast<int>(scene.points().size());
    EXPECT_EQ(added, points);
    EXPECT_EQ(started, 1);
    EXPECT_EQ(processed, 0);
    for (const btManifoldPoint& p : scene.points()) EXPECT_EQ(p.m_combinedFriction, 0.125);
    scene.dispatcher.getManifoldByIndexInternal(0)->getContactPoint(0).m_userPersistentData = &user;
    scene.detect();
    EXPECT_EQ(processed, points);
    EXPECT_EQ(started, 1);
    EXPECT_EQ(
        scene.dispatcher.getManifoldByIndexInternal(0)->getContactPoint(0).m_userPersistentData,
        &user);
    cube.setWorldTransform(at({0, 0, btScalar(0.1 + 1.5 * kVoxel)}));
    scene.detect();
    EXPECT_EQ(ended, 1);
    EXPECT_EQ(destroyed, 1) << "the user's data was not handed back once";
  }
  EXPECT_EQ(destroyed, 1);
}

}  // namespace
}  // namespace cloudcontact::testing::manifold_test
