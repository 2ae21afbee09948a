// What gContactAddedCallback changes of a point holds, as it does for Bullet's own shapes.
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::contact_callback_test {
namespace {

btScalar wanted = 0;  // by the callback

class ContactCallback : public ::testing::Test {
 protected:
  ~ContactCallback() override {
    gContactAddedCallback = nullptr;
    gContactProcessedCallback = nullptr;
  }
  static void listen(btRigidBody& body) {
    body.setCollisionFlags(body.getCollisionFlags() |
                           btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
  }
};

// The speed after the first impact over that before it.
double rebound(btRigidBody& ball, BulletWorld& scene) {
  double highest = 0;
  bool rises = false;
  for (int i = 0; i < 240; ++i) {
    scene.step(1.0 / 240);
    rises = rises || ball.getLinearVelocity().z() > 0.2;
    if (rises) highest = std::max(highest, double(ball.getWorldTransform().getOrigin().z()) - 0.1);
  }
  return std::sqrt(highest / 0.5);
}

TEST_F(ContactCallback, ItsRestitutionBounces) {
  const auto field = fieldOf(sphereMesh(0.1, 1e-4), 0.01);
  for (const double bodys : {0.0, 0.9})
    for (const double callbacks : {0.0, 0.5, 0.7}) {
      BulletWorld scene;
      scene.addGround().setRestitution(1);
      btRigidBody& ball = scene.addCloud(field, 1, at({0, 0, btScalar(0.6)}));
      ball.setRestitution(btScalar(bodys));
      listen(ball);
      wanted = btScalar(callbacks);
      gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                                 const btCollisionObjectWrapper*, int, int) {
        point.m_combinedRestitution = wanted;
        return true;
      };
      const double found = rebound(ball, scene);
      if (callbacks > 0)
        EXPECT_NEAR(found, callbacks, 0.02) << bodys;
      else
        EXPECT_LT(found, 0.05) << bodys;
    }
}

TEST_F(ContactCallback, SeesThePairsRestitution) {
  BulletWorld scene;
  scene.addGround().setRestitution(btScalar(0.5));
  btRigidBody& ball =
      scene.addCloud(fieldOf(sphereMesh(0.1, 1e-4), 0.01), 1, at({0, 0, btScalar(0.099)}));
  ball.setRestitution(btScalar(0.8));
  listen(ball);
  wanted = -1;
  gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) {
    wanted = point.m_combinedRestitution;
    return true;
  };
  scene.step(1.0 / 240);
  EXPECT_NEAR(wanted, 0.4, 1e-6);
}

// On a slope of 0.4: whether it slides is the callback's.
TEST_F(ContactCallback, ItsFrictionHolds) {
  const auto field = fieldOf(boxMesh({0.2, 0.2, 0.1}), 0.01);
  for (const double callbacks : {0.3, 0.5}) {
    BulletWorld scene;
    scene.world.setGravity({btScalar(0.4 * 9.81), 0, btScalar(-9.81)});
    scene.addGround().setFriction(1);
    btRigidBody& box = scene.addCloud(field, 1, at({0, 0, btScalar(0.05)}));
    box.setFriction(btScalar(0.8 - callbacks));
    listen(box);
    wanted = btScalar(callbacks);
    gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                               const btCollisionObjectWrapper*, int, int) {
      point.m_combinedFriction = wanted;
      return true;
    };
    for (int i = 0; i < 240; ++i) scene.step(1.0 / 240);
    const double slid = (0.4 - callbacks) * 9.81 / 2;  // in a second
    EXPECT_NEAR(box.getWorldTransform().getOrigin().x(), std::max(0.0, slid), 0.015) << callbacks;
  }
}

// Of points that were there in the last step, whatever the bodies' flags.
TEST_F(ContactCallback, WhatTheOneForKnownPointsChangesHoldsToo) {
  const auto field = fieldOf(boxMesh({0.2, 0.2, 0.1}), 0.01);
  for (const double callbacks : {0.3, 0.5}) {
    BulletWorld scene;
    scene.world.setGravity({btScalar(0.4 * 9.81), 0, btScalar(-9.81)});
    scene.addGround().setFriction(1);
    btRigidBody& box = scene.addCloud(field, 1, at({0, 0, btScalar(0.05)}));
    box.setFriction(btScalar(0.8 - callbacks));
    wanted = btScalar(callbacks);
    gContactProcessedCallback = [](btManifoldPoint& point, void*, void*) {
      point.m_combinedFriction = wanted;
      return true;
    };
    for (int i = 0; i < 240; ++i) scene.step(1.0 / 240);
    const double slid = (0.4 - callbacks) * 9.81 / 2;
    EXPECT_NEAR(box.getWorldTransform().getOrigin().x(), std::max(0.0, slid), 0.015) << callbacks;
  }
}

TEST_F(ContactCallback, BodiesThatDoNotAskForItAreNotAnnounced) {
  static int calls;
  calls = 0;
  BulletWorld scene;
  scene.addGround();
  btRigidBody& box =
      scene.addCloud(fieldOf(boxMesh({0.2, 0.2, 0.1}), 0.01), 1, at({0, 0, btScalar(0.049)}));
  gContactAddedCallback = [](btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) { return ++calls > 0; };
  scene.step(1.0 / 240);
  EXPECT_EQ(calls, 0);
  listen(box);
  scene.step(1.0 / 240);
  EXPECT_GT(calls, 0);
}

// A spring of the callback's: twice as soft, twice as deep.
TEST_F(ContactCallback, ItsStiffnessHolds) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{1e4, 100};
  BulletWorld scene(settings);
  scene.addGround();
  btRigidBody& box =
      scene.addCloud(fieldOf(boxMesh({0.2, 0.2, 0.1}), 0.01), 1, at({0, 0, btScalar(0.05)}));
  listen(box);
  gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) {
    point.m_combinedContactStiffness1 /= 2;
    return true;
  };
  for (int i = 0; i < 480; ++i) scene.step(1.0 / 240);
  EXPECT_NEAR(0.05 - box.getWorldTransform().getOrigin().z(), 2 * 9.81e-4, 2e-5);
}

}  // namespace
}  // namespace cloudcontact::testing::contact_callback_test
