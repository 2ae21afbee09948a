// The energy audit against mechanics: fall, slide, rest, a lift, a balance of everything at once;
// and rows that are made wrong on purpose.
#include "lab/energy_audit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::energy_audit_test {
namespace {

using program::lab::EnergyAudit;
using program::lab::EnergyParts;
using program::lab::EnergyRow;
using program::lab::RowKind;

constexpr double kVoxel = 0.01, kGravity = 9.81, kStep = 1. / 240;
constexpr bool kDouble = sizeof(btScalar) == 8;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.2}), kVoxel);
  return field;
}

void run(BulletWorld& scene, EnergyAudit& audit, int steps) {
  for (int i = 0; i < steps; ++i) {
    audit.begin(kStep);
    scene.step(kStep);
  }
}

double madeBy(const EnergyAudit& audit) {
  double sum = 0;
  for (const RowKind kind : {RowKind::Normal, RowKind::Friction1, RowKind::Friction2})
    sum += audit.made(kind).energy;
  return sum;
}

// A cube of 2 kg, a cloud or Bullet's, that has come to rest on a plane. It does not turn, so that
// its weight stays spread evenly while it slides.
struct Slide {
  static constexpr double kMass = 2, kFriction = 0.3;
  BulletWorld scene;
  btRigidBody& ground = scene.addGround();
  btRigidBody& cube;

  explicit Slide(bool cloud = true)
      : cube(cloud ? scene.addCloud(cubeField(), kMass, at({0, 0, btScalar(0.1)}))
                   : scene.add(std::make_unique<btBoxShape>(
                                   btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1))),
                               kMass, at({0, 0, btScalar(0.1)}))) {
    cube.setMassProps(btScalar(kMass), {0, 0, 0});
    cube.updateInertiaTensor();
    cube.setAngularFactor(0);
    cube.setFriction(btScalar(kFriction));
    ground.setFriction(1);
    for (int i = 0; i < 240; ++i) scene.step(kStep);
  }
  void push(double speed) { cube.setLinearVelocity({btScalar(speed), 0, 0}); }
};

// Bullet's steps fall by h v1, so that a body has lost m (g h)^2 / 2 after each.
TEST(EnergyAudit, AFallLosesWhatTheStepTakes) {
  BulletWorld scene;
  const double mass = 3;
  scene.add(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), mass, at({0, 0, 5}));
  EnergyAudit audit(scene.world);
  run(scene, audit, 120);
  const double taken = -120 * mass * std::pow(kGravity * kStep, 2) / 2;
  const double rounding = kRounding * mass * kGravity * 5;
  EXPECT_EQ(audit.steps(), 120);
  EXPECT_NEAR(audit.sum().bodies, taken, rounding);
  EXPECT_NEAR(audit.sum().solver, taken, rounding);
  EXPECT_NEAR(audit.sum().rest, 0, rounding);
  EXPECT_EQ(audit.sum().friction, 0);
  EXPECT_EQ(audit.sum().normals, 0);
  EXPECT_EQ(audit.worst().energy, 0);
}

// Without a load all that changes is how the body turns: by the step, and with its inertia.
TEST(EnergyAudit, ATumblingBodysChangeIsThatOfTurning) {
  BulletWorld scene;
  scene.world.setGravity({0, 0, 0});
  btRigidBody& body =
      scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), 1, 2)), 3, at({0, 0, 0}));
  body.setAngularVelocity({5, 10, 2});
  EnergyAudit audit(scene.world);
  run(scene, audit, 240);
  EXPECT_GT(std::abs(audit.sum().turning), 0.05);
  EXPECT_NEAR(audit.sum().rest, 0, 100 * kRounding);
  EXPECT_NEAR(audit.sum().bodies, audit.sum().turning + audit.sum().solver, 100 * kRounding);
}

void expectLosesFrictionTimesWay(Slide& slide, int steps) {
  slide.push(2);
  EnergyAudit audit(slide.scene.world);
  const double from = slide.cube.getWorldTransform().getOrigin().x();
  run(slide.scene, audit, steps);
  const double way = slide.cube.getWorldTransform().getOrigin().x() - from;
  const double push = Slide::kFriction * Slide::kMass * kGravity;
  const double rounding = kDouble ? 1e-7 : 1e-4;
  EXPECT_GT(way, 1.5 * kStep * steps);
  EXPECT_NEAR(audit.sum().friction, -push * way, rounding);
  EXPECT_NEAR(audit.sum().solver, -steps * std::pow(push * kStep, 2) / 2 / Slide::kMass, rounding);
  EXPECT_NEAR(audit.sum().normals, 0, rounding);
  EXPECT_NEAR(audit.sum().springs, 0, rounding);
  EXPECT_NEAR(audit.sum().found, 0, rounding);
  EXPECT_NEAR(audit.sum().rest, 0, rounding);
  EXPECT_LT(madeBy(audit), rounding);
}

TEST(EnergyAudit, ASlideLosesItsFrictionTimesItsWay) {
  Slide own(false);
  expectLosesFrictionTimesWay(own, 60);
  // Later the crosswise friction of a cloud that cannot turn sways.
  Slide cloud;
  expectLosesFrictionTimesWay(cloud, 5);
}

TEST(EnergyAudit, NoRowOfABoxAtRestMakesEnergy) {
  BulletWorld scene;
  scene.addGround();
  scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
  for (int i = 0; i < 480; ++i) scene.step(kStep);
  EnergyAudit audit(scene.world);
  run(scene, audit, 240);
  EXPECT_LT(madeBy(audit), 1e-9 * kGravity * kVoxel);
  EXPECT_NEAR(audit.sum().bodies, 0, (kDouble ? 1e-7 : 1e-4) * kGravity * kVoxel);
}

// A floor rises at a constant speed under a cube that has come to rest on it.
TEST(EnergyAudit, ALiftGivesWeightTimesHeight) {
  BulletWorld scene;
  const double speed = 0.5;
  btRigidBody& floor =
      scene.add(std::make_unique<btBoxShape>(btVector3(1, 1, btScalar(0.5))), 0, at({0, 0, 0}));
  floor.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  floor.setActivationState(DISABLE_DEACTIVATION);
  scene.addCloud(cubeField(), 2, at({0, 0, btScalar(0.6)}));
  const auto lift = [&](int steps, EnergyAudit& audit) {
    for (int i = 0; i < steps; ++i) {
      btTransform place = floor.getWorldTransform();
      place.getOrigin().setZ(place.getOrigin().z() + btScalar(speed * kStep));
      floor.setWorldTransform(place);
      run(scene, audit, 1);
    }
  };
  {
    EnergyAudit starting(scene.world);
    lift(480, starting);
  }
  EnergyAudit audit(scene.world);
  lift(240, audit);
  const double rounding = kDouble ? 1e-7 : 2e-3;
  EXPECT_NEAR(audit.sum().drivers, 2 * kGravity * speed, rounding);
  EXPECT_NEAR(audit.sum().bodies, 2 * kGravity * speed, rounding);
  EXPECT_NEAR(audit.sum().normals, 0, rounding);
  EXPECT_NEAR(audit.sum().solver, 0, rounding);
}

// Cubes that tumble onto a slab and a turning plate; two of them hang together.
TEST(EnergyAudit, AllPartsAddUpToTheChange) {
  BulletWorld scene;
  scene.addCloud(fieldOf(boxMesh({0.8, 0.8, 0.1}), kVoxel), 0, at({0, 0, btScalar(-0.05)}));
  btRigidBody& plate = scene.add(
      std::make_unique<btBoxShape>(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.02))), 0,
      at({btScalar(0.25), 0, btScalar(0.02)}));
  plate.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  plate.setActivationState(DISABLE_DEACTIVATION);
  std::vector<btRigidBody*> cubes;
  for (int i = 0; i < 4; ++i) {
    cubes.push_back(
        &scene.addCloud(cubeField(), 1 + i,
                        at({btScalar(0.08 * i), 0, btScalar(0.2 + 0.3 * i)},
                           btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(0.4 * i)))));
    cubes.back()->setAngularVelocity({1, btScalar(-2), btScalar(i)});
  }
  btPoint2PointConstraint joint(*cubes[0], *cubes[1], {0, 0, btScalar(0.15)},
                                {0, 0, btScalar(-0.15)});
  scene.world.addConstraint(&joint);
  {
    EnergyAudit audit(scene.world);
    double fell = 0, worked = 0;
    for (int i = 0; i < 360; ++i) {
      btTransform place = plate.getWorldTransform();
      place.setRotation(btQuaternion({0, 0, 1}, btScalar(0.005 * i)));
      plate.setWorldTransform(place);
      run(scene, audit, 1);
      EXPECT_NEAR(audit.step().rest, 0, kDouble ? 1e-11 : 1e-3) << "step " << i;
      fell += audit.step().bodies;
      worked += std::abs(audit.step().joints);
    }
    EXPECT_LT(fell, -5);
    EXPECT_GT(worked, 0.1);
    EXPECT_LT(audit.sum().friction, -0.1);
    EXPECT_LT(audit.sum().normals, -0.1);
    EXPECT_GT(std::abs(audit.sum().drivers), 0.01);
    EXPECT_NEAR(audit.sum().rest, 0, kDouble ? 1e-10 : 1e-2);
  }
  EXPECT_EQ(joint.getJointFeedback(), nullptr);
  scene.world.removeConstraint(&joint);
}

// Changes the contacts of a step after it was solved, and before the audit reads them.
struct Spoiler : btActionInterface {
  std::function<void(btManifoldPoint&)> spoil;
  void updateAction(btCollisionWorld* world, btScalar) override {
    if (spoil && world->getDispatcher()->getNumManifolds() > 0)
      spoil(world->getDispatcher()->getManifoldByIndexInternal(0)->getContactPoint(1));
  }
  void debugDraw(btIDebugDraw*) override {}
};

struct SpoiltSlide : Slide {
  Spoiler spoiler;
  SpoiltSlide() {
    push(2);
    scene.world.addAction(&spoiler);
  }
  ~SpoiltSlide() { scene.world.removeAction(&spoiler); }
};

TEST(EnergyAudit, AFrictionRowThatPushesAlongIsNamed) {
  SpoiltSlide slide;
  EnergyAudit audit(slide.scene.world);
  run(slide.scene, audit, 10);
  const double before = audit.sum().friction;
  int point = -1;
  double impulse = 0;
  slide.spoiler.spoil = [&](btManifoldPoint& p) {
    point = p.m_partId0;
    impulse = std::abs(double(p.m_appliedImpulseLateral1));
    p.m_appliedImpulseLateral1 = -p.m_appliedImpulseLateral1;
  };
  run(slide.scene, audit, 1);
  const double speed = slide.cube.getLinearVelocity().x();
  const EnergyRow& worst = audit.worst();
  const bool first = worst.a == &slide.cube;
  EXPECT_EQ(first ? worst.b : worst.a, &slide.ground);
  EXPECT_EQ(first ? worst.a : worst.b, &slide.cube);
  EXPECT_EQ(worst.kind, RowKind::Friction1);
  EXPECT_EQ(worst.point, point);
  EXPECT_EQ(worst.step, 11);
  EXPECT_NEAR(impulse, Slide::kFriction * Slide::kMass * kGravity * kStep / 4, 1e-5);
  EXPECT_NEAR(worst.energy, impulse * speed, 1e-6);
  EXPECT_FALSE(worst.isNew || worst.patchNew || worst.renamed);
  EXPECT_EQ(audit.made(RowKind::Friction1).rows, 1);
  // Its work counts with the wrong sign, too, and the balance shows what it did not do.
  EXPECT_GT(audit.sum().friction, before - 3 * impulse * speed);
  EXPECT_NEAR(audit.step().rest, -2 * impulse * speed, 1e-4 * impulse * speed);
}

// It is pushed up by more than its spring has.
TEST(EnergyAudit, ANormalRowThatGivesMoreThanItsSpringIsNamed) {
  SpoiltSlide slide;
  slide.push(0);
  EnergyAudit audit(slide.scene.world);
  slide.cube.setLinearVelocity({0, 0, btScalar(0.01)});
  slide.spoiler.spoil = [](btManifoldPoint& p) { p.m_appliedImpulse += btScalar(0.1); };
  run(slide.scene, audit, 1);
  EXPECT_EQ(audit.worst().kind, RowKind::Normal);
  const double parting = slide.cube.getLinearVelocity().z();
  EXPECT_GT(parting, 1e-3);
  EXPECT_LT(audit.worst().energy, 0.1 * parting);
  EXPECT_GT(audit.worst().energy, 0.05 * parting);
}

double storedIn(const BulletWorld& scene) {
  double sum = 0;
  for (const btManifoldPoint& p : scene.points())
    sum += 0.5 * p.m_combinedContactStiffness1 * std::pow(double(p.getDistance()), 2);
  return sum;
}

// Somebody presses a cube into its floor between two steps: no row makes that.
TEST(EnergyAudit, SpringsThatAreFoundCompressedAreNamed) {
  BulletWorld scene;
  btRigidBody& ground = scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.1)}));
  for (btRigidBody* body : {&ground, &cube})
    body->setContactStiffnessAndDamping(btScalar(2e4), btScalar(100));
  for (int i = 0; i < 240; ++i) scene.step(kStep);
  EnergyAudit audit(scene.world);
  run(scene, audit, 1);
  const double before = storedIn(scene);
  cube.translate({0, 0, btScalar(-0.2 * kVoxel)});
  run(scene, audit, 1);
  const double found = storedIn(scene) - before;
  EXPECT_GT(found, 0.01);
  EXPECT_NEAR(audit.sum().found, found, (kDouble ? 1e-7 : 1e-4) * found);
  EXPECT_NEAR(audit.made(RowKind::Spring).energy, audit.sum().found, 1e-6 * found);
  EXPECT_EQ(audit.made(RowKind::Spring).rows, 4);
  EXPECT_EQ(audit.made(RowKind::Spring).worst.step, 2);
  EXPECT_EQ(audit.made(RowKind::Spring).byNew, 0);
  EXPECT_LT(madeBy(audit), (kDouble ? 1e-8 : 1e-5) * found);
}

TEST(EnergyAudit, ItTellsWhetherThePointIsNew) {
  SpoiltSlide slide;
  const auto backwards = [](btManifoldPoint& p) {
    p.m_appliedImpulseLateral1 = -p.m_appliedImpulseLateral1;
  };
  {
    EnergyAudit audit(slide.scene.world);
    slide.spoiler.spoil = backwards;
    run(slide.scene, audit, 1);
    EXPECT_TRUE(audit.worst().isNew && audit.worst().patchNew);
    EXPECT_FALSE(audit.worst().renamed);
    EXPECT_GT(audit.made(RowKind::Friction1).byNew, 0);
  }
  EnergyAudit audit(slide.scene.world);
  slide.spoiler.spoil = {};
  run(slide.scene, audit, 1);
  slide.spoiler.spoil = [&](btManifoldPoint& p) {
    p.m_partId0 += 1000;
    backwards(p);
  };
  run(slide.scene, audit, 1);
  EXPECT_TRUE(audit.worst().isNew && audit.worst().renamed);
  EXPECT_FALSE(audit.worst().patchNew);
}

}  // namespace
}  // namespace cloudcontact::testing::energy_audit_test
