// Clouds on Bullet's shapes made of triangles: the same force as on a plane, no bump at inner
// edges, both sides of a sheet.
#include <gtest/gtest.h>

#include <cloudcontact/bullet/diagnosis.h>

#include "bullet/triangle_grounds.h"

namespace cloudcontact::testing::triangle_shapes_test {
namespace {

// A world with one ground and one cloud.
struct GroundWorld : BulletWorld {
  explicit GroundWorld(Kept ground, const CloudContactSettings& settings = {},
                       const btTransform& place = at({0, 0, 0}))
      : BulletWorld(settings), kept(std::move(ground.data)) {
    add(std::move(ground.shape), 0, place).setFriction(0);
  }
  // Force and torque [N, N m] of the springs on the cloud.
  Wrench wrench() const {
    Wrench sum;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
      const bool onGround = manifold.getBody1()->isStaticObject();
      for (int j = 0; j < manifold.getNumContacts(); ++j) {
        const btManifoldPoint& p = manifold.getContactPoint(j);
        const double size = std::max(0.0, -double(p.getDistance()) * p.m_combinedContactStiffness1);
        const Vec3 force = (onGround ? size : -size) * toVec(p.m_normalWorldOnB);
        sum.force += force;
        sum.torque += toVec(p.getPositionWorldOnA()).cross(force);
      }
    }
    return sum;
  }
  static Vec3 toVec(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

  std::vector<std::shared_ptr<void>> kept;
};

CloudContactSettings spring(double stiffness) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, 0};
  return settings;
}

Kept plane() {
  return {std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0)};
}

double energyOf(const btRigidBody& body) {
  const btVector3 w = body.getAngularVelocity();
  const btMatrix3x3 inertia = body.getInvInertiaTensorWorld().inverse();
  return 0.5 * body.getMass() * body.getLinearVelocity().length2() + 0.5 * w.dot(inertia * w) +
         9.81 * body.getMass() * body.getWorldTransform().getOrigin().z();
}

double speedAfterStep(GroundWorld& world, btRigidBody& body) {
  world.step(1.0 / 240);
  return body.getLinearVelocity().z();
}

TEST(TriangleShapes, PushAsAPlaneDoes) {
  for (const TestCloud& cloud : testClouds())
    for (const double tilt : {0.0, 0.1}) {
      // Turned out of the ground's grid; tilted, an edge is one voxel deep.
      const btTransform place = at({btScalar(0.0123), btScalar(-0.0345),
                                    btScalar(cloud.below - (tilt > 0 ? 0 : 0.3) * kVoxel)},
                                   btQuaternion(btVector3(1, btScalar(0.3), 0), btScalar(tilt)) *
                                       btQuaternion(btVector3(0, 0, 1), btScalar(0.4)));
      GroundWorld truth(plane(), spring(1e4));
      truth.addCloud(cloud.field, 1, place);
      truth.detect();
      const Wrench wanted = truth.wrench();
      ASSERT_GT(wanted.force.z(), 1) << cloud.name;
      for (const Ground& ground : grounds()) {
        GroundWorld world(ground.make(), spring(1e4));
        world.addCloud(cloud.field, 1, place);
        world.detect();
        const Wrench found = world.wrench();
        EXPECT_LT((found.force - wanted.force).norm(), 1e-3 * wanted.force.norm())
            << cloud.name << " on " << ground.name << ", tilt " << tilt << ": "
            << found.force.transpose() << ", not " << wanted.force.transpose();
        EXPECT_LT((found.torque - wanted.torque).norm(), 1e-3 * 0.04 * wanted.force.norm())
            << cloud.name << " on " << ground.name << ", tilt " << tilt;
        EXPECT_EQ(world.clouds.statistics().failures, 0u) << world.clouds.statistics().lastFailure;
      }
    }
}

TEST(TriangleShapes, LawsTissuesAndBaseVectorsAreThoseOfAPlane) {
  CloudContactSettings automatic, foundation, fixed = spring(1e4);
  foundation.law = Foundation{1e7, 0};
  struct Case {
    const char* name;
    const CloudContactSettings& settings;
    TissueTable tissues = {};
    bool window = false;
  };
  const Case cases[] = {{"automatic", automatic},
                        {"foundation", foundation},
                        {"base vectors", fixed, {}, true},
                        {"tissue", automatic, {{"wood", 3e4, 0, 1, 500}}}};
  for (const Case& c : cases)
    for (const TestCloud& cloud : testClouds()) {
      Wrench found[2];
      for (int k = 0; k < 2; ++k) {
        GroundWorld world(k ? bvhShape(groundMesh(90)) : plane(), c.settings);
        auto shape = exactCloud(cloud.field);
        shape->setTissues(c.tissues);
        PaperSettings paper;
        paper.window = sphereWindow(shape->cloud().voxelSize());
        if (c.window) shape->usePaper(paper);
        world.add(std::move(shape), 1,
                  at({btScalar(0.0123), 0, btScalar(cloud.below - 0.4 * kVoxel)},
                     btQuaternion(btVector3(0, 0, 1), btScalar(0.4))));
        world.detect();
        found[k] = world.wrench();
      }
      EXPECT_GT(found[0].force.z(), 1) << c.name;
      EXPECT_LT((found[1].force - found[0].force).norm(), 1e-3 * found[0].force.norm())
          << c.name << ", " << cloud.name;
      EXPECT_LT((found[1].torque - found[0].torque).norm(), 1e-4 * found[0].force.norm())
          << c.name << ", " << cloud.name;
    }
}

// Of a fall of 1 cm.
struct Fall {
  double gained = 0, lowest = 1;  // energy [J], height [m]
  btTransform end;
};

Fall fallOn(Kept ground, const TestCloud& cloud) {
  GroundWorld world(std::move(ground));
  btRigidBody& body =
      world.addCloud(cloud.field, 0.5,
                     at({btScalar(0.01), btScalar(0.02), btScalar(cloud.below + 0.01)},
                        btQuaternion(btVector3(1, btScalar(0.5), 0), btScalar(0.05))));
  const double start = energyOf(body);
  Fall fall;
  for (int i = 0; i < 240; ++i) {
    world.step(1.0 / 240);
    fall.gained = std::max(fall.gained, energyOf(body) - start);
    fall.lowest = std::min(fall.lowest, double(body.getWorldTransform().getOrigin().z()));
  }
  fall.end = body.getWorldTransform();
  return fall;
}

TEST(TriangleShapes, HoldWhatFallsOnThem) {
  for (const TestCloud& cloud : testClouds()) {
    const Fall wanted = fallOn(plane(), cloud);
    for (const Ground& ground : grounds()) {
      const Fall fall = fallOn(ground.make(), cloud);
      EXPECT_LT(fall.gained, 1e-4 * 0.5 * 9.81 * 0.01) << cloud.name << " on " << ground.name;
      EXPECT_GT(fall.lowest, cloud.below - kVoxel) << cloud.name << " on " << ground.name;
      EXPECT_LT((fall.end.getOrigin() - wanted.end.getOrigin()).length(), 0.01 * kVoxel)
          << cloud.name << " on " << ground.name;
    }
  }
}

TEST(TriangleShapes, InnerEdgesMakeNoBump) {
  // 0.2 s at 1 m/s over triangles of 22 mm, without friction.
  for (const TestCloud& cloud : testClouds())
    for (const Ground& ground : grounds()) {
      GroundWorld world(ground.make());
      btRigidBody& body = world.addCloud(
          cloud.field, 0.5, at({btScalar(-0.1), btScalar(0.011), btScalar(cloud.below)}));
      for (int i = 0; i < 60; ++i) world.step(1.0 / 240);
      body.setLinearVelocity({1, btScalar(0.37), 0});
      double fastest = 0;
      for (int i = 0; i < 48; ++i)
        fastest = std::max(fastest, std::abs(speedAfterStep(world, body)));
      EXPECT_LT(fastest, 1e-3) << cloud.name << " on " << ground.name;
      EXPECT_NEAR(body.getLinearVelocity().x(), 1, 1e-3) << cloud.name << " on " << ground.name;
      EXPECT_LT(body.getAngularVelocity().length(), 0.05) << cloud.name << " on " << ground.name;
    }
}

TEST(TriangleShapes, ASheetPushesToTheSideOnWhichTheCloudIs) {
  for (const TestCloud& cloud : testClouds())
    for (const Ground& ground : grounds())
      for (const double side : {1.0, -1.0}) {
        GroundWorld world(ground.make(), spring(1e4));
        world.addCloud(cloud.field, 1,
                       at({0, 0, btScalar(side * (cloud.below - 0.3 * kVoxel))},
                          btQuaternion(btVector3(1, 0, 0), btScalar(side < 0 ? SIMD_PI : 0))));
        world.detect();
        EXPECT_NEAR(side * world.wrench().force.z(), 0.3 * kVoxel * 1e4, 0.05 * 0.3 * kVoxel * 1e4)
            << cloud.name << " on " << ground.name << ", side " << side;
      }
}

}  // namespace
}  // namespace cloudcontact::testing::triangle_shapes_test
