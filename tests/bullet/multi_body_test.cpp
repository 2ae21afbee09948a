// Clouds on btMultiBody: their links move as Bullet says, and an impact is that of a rigid body.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"
#include "bullet/convert.h"
#include "bullet/object_motion.h"

namespace cloudcontact::testing::multi_body_test {
namespace {

constexpr double kVoxel = 0.0025, kRadius = 0.05, kHalf = 0.02;  // [m]
const btVector3 kDown(0, 0, -1), kAlongX(1, 0, 0);

class MultiWorld {
 public:
  MultiWorld() {
    clouds_.attach(dispatcher_);
    recommendedSettings(world);
    world.setGravity({0, 0, 0});
  }
  ~MultiWorld() {
    for (auto& collider : colliders_) world.removeCollisionObject(collider.get());
    for (auto& body : multiBodies_) world.removeMultiBody(body.get());
    for (auto& body : rigidBodies_) world.removeRigidBody(body.get());
  }
  MultiWorld(const MultiWorld&) = delete;
  MultiWorld& operator=(const MultiWorld&) = delete;

  btRigidBody& addRigid(btCollisionShape& shape, double mass, const btVector3& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
    rigidBodies_.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia));
    rigidBodies_.back()->setWorldTransform(at(place));
    rigidBodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    rigidBodies_.back()->setRestitution(1);
    world.addRigidBody(rigidBodies_.back().get());
    return *rigidBodies_.back();
  }
  // No link yet: setup...(), finish(), then collide().
  btMultiBody& addMulti(int links, double mass, const btVector3& inertia, bool isFixed) {
    multiBodies_.push_back(
        std::make_unique<btMultiBody>(links, btScalar(mass), inertia, isFixed, false));
    multiBodies_.back()->setLinearDamping(0);
    multiBodies_.back()->setAngularDamping(0);
    return *multiBodies_.back();
  }
  void finish(btMultiBody& body) {
    body.finalizeMultiDof();
    world.addMultiBody(&body);
  }
  btMultiBodyLinkCollider& collide(btMultiBody& body, int link, btCollisionShape& shape) {
    colliders_.push_back(std::make_unique<btMultiBodyLinkCollider>(&body, link));
    btMultiBodyLinkCollider& collider = *colliders_.back();
    collider.setCollisionShape(&shape);
    if (link < 0)
      body.setBaseCollider(&collider);
    else
      body.getLink(link).m_collider = &collider;
    world.addCollisionObject(&collider, 1, -1);
    refresh(body);
    return collider;
  }
  void refresh(btMultiBody& body) {
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> places;
    body.forwardKinematics(rotations, places);
    body.updateCollisionObjectWorldTransforms(rotations, places);
  }
  void step(double seconds) { world.stepSimulation(btScalar(seconds), 0); }

 private:
  CloudContact clouds_;  // first: it must outlive the dispatcher
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;

 public:
  btMultiBodyDynamicsWorld world{&dispatcher_, &broadphase_, &solver_, &configuration_};

 private:
  std::vector<std::unique_ptr<btRigidBody>> rigidBodies_;
  std::vector<std::unique_ptr<btMultiBody>> multiBodies_;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
};

CloudShape& ball() {
  static CloudShape shape(fieldOf(sphereMesh(kRadius, 1e-5), kVoxel));
  return shape;
}
CloudShape& plate() {
  static CloudShape shape(fieldOf(boxMesh({0.1, 0.1, 2 * kHalf}), 0.003));
  return shape;
}
btVector3 inertiaOf(const btCollisionShape& shape) {
  btVector3 inertia;
  shape.calculateLocalInertia(1, inertia);
  return inertia;
}

// A branched body of every kind of joint, somewhere on its way.
btMultiBody& addTree(MultiWorld& world) {
  const btVector3 inertia(0.1f, 0.2f, 0.3f), out(0.1f, 0.2f, 0.3f), in(0.3f, -0.1f, 0.2f);
  const btQuaternion turned(btVector3(1, 2, 3).normalized(), btScalar(0.7));
  btMultiBody& tree = world.addMulti(6, 1, inertia, false);
  tree.setupRevolute(0, 1, inertia, -1, turned, btVector3(0, 0.6f, 0.8f), out, in, true);
  tree.setupPrismatic(1, 1, inertia, 0, turned, btVector3(0.6f, 0, 0.8f), out, in, true);
  tree.setupSpherical(2, 1, inertia, 1, turned, out, in, true);
  tree.setupFixed(3, 1, inertia, 2, turned, out, in);
  tree.setupPlanar(4, 1, inertia, 0, turned, btVector3(0, 0, 1), out, true);
  tree.setupRevolute(5, 1, inertia, 4, turned, btVector3(0.8f, 0.6f, 0), out, in, true);
  world.finish(tree);
  tree.setBasePos({1, 2, 3});
  tree.setWorldToBaseRot(turned * turned);
  tree.setBaseVel({1, -2, 0.5f});
  tree.setBaseOmega({-0.3f, 0.7f, 1.1f});
  Random random(5);
  for (int link = 0; link < tree.getNumLinks(); ++link) {
    btScalar speeds[6];
    for (btScalar& speed : speeds) speed = btScalar(random.inCube().x() - 0.5);
    if (tree.getLink(link).m_dofCount > 0) tree.setJointVelMultiDof(link, speeds);
    if (tree.getLink(link).m_dofCount == 1) tree.setJointPos(link, btScalar(0.4 * (link + 1)));
  }
  return tree;
}

TEST(MultiBody, LinksMoveAsBulletTells) {
  MultiWorld world;
  btMultiBody& tree = addTree(world);
  btVector3 angular[7], linear[7];
  tree.compTreeLinkVelocities(angular, linear);
  for (int link = -1; link < tree.getNumLinks(); ++link) {
    const btMultiBodyLinkCollider& collider = world.collide(tree, link, ball());
    const btMatrix3x3& toWorld = collider.getWorldTransform().getBasis();
    const Motion found = motionOf(collider);
    const double bound = 10 * kRounding;
    EXPECT_LT((found.linear - toVec3(toWorld * linear[link + 1])).norm(), bound) << link;
    EXPECT_LT((found.angular - toVec3(toWorld * angular[link + 1])).norm(), bound) << link;
  }
}

// Where it is a moment later, by Bullet's own step.
TEST(MultiBody, LinksMoveAsTheyStepOn) {
  MultiWorld world;
  btMultiBody& tree = addTree(world);
  std::vector<const btMultiBodyLinkCollider*> colliders;
  for (int link = -1; link < tree.getNumLinks(); ++link)
    colliders.push_back(&world.collide(tree, link, ball()));
  std::vector<Motion> motions;
  for (const auto* collider : colliders) motions.push_back(motionOf(*collider));
  const double time = 1e-3;
  tree.stepPositionsMultiDof(btScalar(time));
  world.refresh(tree);
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const Vec3 now = toVec3(colliders[i]->getWorldTransform().getOrigin());
    EXPECT_LT(((now - motions[i].center) / time - motions[i].linear).norm(), 0.01) << i;
  }
}

struct Strike {
  double leaves = 0, deepest = 0;  // [m/s], [m]
};

// What falls on a plane without gravity, as a rigid body or as the base of a multi-body.
Strike strike(bool isMulti, btCollisionShape& shape, double half, double speed, double restitution,
              double step, double gap) {
  MultiWorld world;
  btStaticPlaneShape plane(btVector3(0, 0, 1), 0);
  world.addRigid(plane, 0, {0, 0, 0});
  const btVector3 place(0, 0, btScalar(half + gap));
  btMultiBody* multi = nullptr;
  btRigidBody* rigid = nullptr;
  if (isMulti) {
    multi = &world.addMulti(0, 1, inertiaOf(shape), false);
    world.finish(*multi);
    multi->setBasePos(place);
    multi->setBaseVel(btScalar(speed) * kDown);
    world.collide(*multi, -1, shape).setRestitution(btScalar(restitution));
  } else {
    rigid = &world.addRigid(shape, 1, place);
    rigid->setLinearVelocity(btScalar(speed) * kDown);
    rigid->setRestitution(btScalar(restitution));
  }
  Strike found;
  for (int i = 0; i < 0.3 / step; ++i) {
    world.step(step);
    const double z = multi ? multi->getBasePos().z() : rigid->getWorldTransform().getOrigin().z();
    const double up = multi ? multi->getBaseVel().z() : rigid->getLinearVelocity().z();
    found.leaves = std::max(found.leaves, up);
    found.deepest = std::max(found.deepest, half - z);
  }
  return found;
}

TEST(MultiBody, BouncesAsStated) {
  for (const double rate : {240.0, 1000.0})
    for (const double restitution : {0.5, 0.8, 1.0}) {
      const double leaves = strike(true, ball(), kRadius, 1, restitution, 1 / rate, 0.0113).leaves;
      EXPECT_NEAR(leaves, restitution, 0.01) << rate << " Hz";
    }
}

// At any place within its way of a step.
TEST(MultiBody, SinksAndReturnsAsARigidBody) {
  for (const double rate : {60.0, 240.0})
    for (const double speed : {0.5, 1.0, 2.0})
      for (int part = 0; part < 5; ++part) {
        const double gap = 0.01 + 0.2 * part * speed / rate;
        const Strike multi = strike(true, plate(), kHalf, speed, 0, 1 / rate, gap);
        const Strike rigid = strike(false, plate(), kHalf, speed, 0, 1 / rate, gap);
        EXPECT_NEAR(multi.deepest, rigid.deepest, 0.03 * 0.003) << rate << " Hz, " << speed;
        EXPECT_NEAR(multi.leaves, rigid.leaves, 0.01 * speed) << rate << " Hz, " << speed;
        EXPECT_LT(multi.deepest, 0.7 * 0.003) << rate << " Hz, " << speed;
      }
}

// A slider on a fixed base strikes a ball of its own mass, and gives it all of its speed.
TEST(MultiBody, ALinkGivesItsSpeedToABallOfItsMass) {
  for (const double rate : {240.0, 1000.0}) {
    MultiWorld world;
    btMultiBody& rail = world.addMulti(1, 1, btVector3(1, 1, 1), true);
    rail.setupPrismatic(0, 1, inertiaOf(ball()), -1, btQuaternion::getIdentity(), kAlongX,
                        {0, 0, 0}, {0, 0, 0}, true);
    world.finish(rail);
    rail.setBasePos({btScalar(-0.12), 0, 0});
    rail.setJointVel(0, 1);
    world.collide(rail, 0, ball()).setRestitution(1);
    btRigidBody& struck = world.addRigid(ball(), 1, {0, 0, 0});
    for (int i = 0; i < 0.2 * rate; ++i) world.step(1 / rate);
    EXPECT_NEAR(rail.getJointVel(0), 0, 0.01) << rate << " Hz";
    EXPECT_NEAR(struck.getLinearVelocity().x(), 1, 0.01) << rate << " Hz";
  }
}

// A jointed pair of plates falls on a plane, and nothing lifts it above where it came from.
TEST(MultiBody, AJointedBodyThatFallsGainsNoEnergy) {
  MultiWorld world;
  world.world.setGravity({0, 0, btScalar(-9.81)});
  btStaticPlaneShape plane(btVector3(0, 0, 1), 0);
  world.addRigid(plane, 0, {0, 0, 0}).setRestitution(0);
  btMultiBody& pair = world.addMulti(1, 1, inertiaOf(plate()), false);
  pair.setupRevolute(0, 1, inertiaOf(plate()), -1, btQuaternion::getIdentity(), {0, 1, 0},
                     {btScalar(0.06), 0, 0}, {btScalar(0.06), 0, 0}, true);
  world.finish(pair);
  pair.setBasePos({0, 0, btScalar(0.2)});
  pair.setWorldToBaseRot(btQuaternion(btVector3(0, 1, 0), btScalar(0.4)));
  world.collide(pair, -1, plate());
  world.collide(pair, 0, plate());
  const btVector3 inertia = inertiaOf(plate());
  const auto energyOf = [&](const btMultiBodyLinkCollider& collider) {
    const btTransform& place = collider.getWorldTransform();
    const Motion motion = motionOf(collider);
    const btVector3 spin = place.getBasis().transpose() * toBullet(motion.angular);
    return 0.5 * (motion.linear.squaredNorm() + double(spin.dot(inertia * spin))) +
           9.81 * double(place.getOrigin().z());
  };
  const auto energy = [&] {
    return energyOf(*pair.getBaseCollider()) + energyOf(*pair.getLink(0).m_collider);
  };
  const double first = energy();
  for (int i = 0; i < 480; ++i) {
    world.step(1 / 240.0);
    EXPECT_LT(energy(), first + 1e-3) << i;
  }
  EXPECT_NEAR(pair.getBasePos().z(), kHalf, 0.2 * 0.003);
  EXPECT_NEAR(pair.getLink(0).m_collider->getWorldTransform().getOrigin().z(), kHalf, 0.2 * 0.003);
}

}  // namespace
}  // namespace cloudcontact::testing::multi_body_test
