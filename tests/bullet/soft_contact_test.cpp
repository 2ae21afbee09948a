// Soft bodies on clouds: rest and slip against closed forms, momentum, energy, loads in both
// directions; calls between steps change nothing.
// First: Bullet's soft bodies declare a global named seed.
#include "bullet/bullet_world.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <cloudcontact/bullet/soft_contact_point.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace cloudcontact::testing::soft_contact_test {
namespace {

constexpr double kVoxel = 0.01, kGravity = 9.81;

std::shared_ptr<const SurfaceField> boxField(double scale = 1) {
  static const auto one = fieldOf(boxMesh({0.3, 0.3, 0.1}), kVoxel);
  if (scale == 1) return one;
  return fieldOf(boxMesh(Vec3(scale * Vec3(0.3, 0.3, 0.1))), scale * kVoxel);
}
std::shared_ptr<const SurfaceField> ballField() {
  static const auto field = fieldOf(sphereMesh(0.1, 1e-5), kVoxel);
  return field;
}

class SoftWorld {
 public:
  explicit SoftWorld(const CloudContactSettings& settings = {}, double gravity = kGravity)
      : clouds(settings) {
    clouds.attach(dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-gravity)});
    world.getWorldInfo().m_gravity.setValue(0, 0, btScalar(-gravity));
  }
  ~SoftWorld() {
    for (auto& soft : softs_) world.removeSoftBody(soft.get());
    for (auto& body : bodies_) world.removeRigidBody(body.get());
  }

  btRigidBody& add(std::unique_ptr<btCollisionShape> shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    info.m_friction = 1;  // a soft body's kDF is then the pair's
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    if (mass > 0) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies_.back().get());
    return *bodies_.back();
  }
  btRigidBody& addCloud(const std::shared_ptr<const SurfaceField>& field, double mass,
                        const btTransform& place = at({0, 0, 0})) {
    return add(std::make_unique<CloudShape>(field), mass, place);
  }

  btSoftBody& keep(btSoftBody* made, double mass, double friction, bool byFaces, double margin) {
    softs_.emplace_back(made);
    made->setTotalMass(btScalar(mass), byFaces);
    made->m_cfg.kDF = btScalar(friction);
    made->m_cfg.piterations = 10;
    made->getCollisionShape()->setMargin(btScalar(margin));
    world.addSoftBody(made);
    return *made;
  }
  // A square sheet of `edge`, `count` nodes along it, its middle and plane at `place`.
  btSoftBody& addSheet(double edge, int count, double mass, const btTransform& place,
                       double friction = 0, int pinned = 0) {
    const btScalar h = btScalar(edge / 2);
    btSoftBody* const made = btSoftBodyHelpers::CreatePatch(
        world.getWorldInfo(), place * btVector3(-h, -h, 0), place * btVector3(h, -h, 0),
        place * btVector3(-h, h, 0), place * btVector3(h, h, 0), count, count, pinned, true);
    return keep(made, mass, friction, true, 0.05 * edge);
  }
  btSoftBody& addRope(const btVector3& from, const btVector3& to, int count, double mass,
                      double friction) {
    return keep(btSoftBodyHelpers::CreateRope(world.getWorldInfo(), from, to, count - 2, 0), mass,
                friction, false, 0.01);
  }

  void step(double seconds) { world.stepSimulation(btScalar(seconds), 0); }
  double pushOn(const btSoftBody& soft) const {  // upward, of the last step [N s]
    std::vector<SoftContactPoint> points;
    clouds.softContacts(soft, points);
    double sum = 0;
    for (const SoftContactPoint& p : points) sum += p.impulse.z();
    return sum;
  }

  CloudContact clouds;
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};

 private:
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btSoftBody>> softs_;
};

CloudContactSettings pairOf(double stiffness, double damping) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, damping};
  return settings;
}

Vec3 vec(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
Vec3 momentumOf(const btSoftBody& soft) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < soft.m_nodes.size(); ++i)
    if (soft.m_nodes[i].m_im > 0) sum += vec(soft.m_nodes[i].m_v) / double(soft.m_nodes[i].m_im);
  return sum;
}
double energyOf(const btSoftBody& soft, double gravity) {
  double sum = 0;
  for (int i = 0; i < soft.m_nodes.size(); ++i) {
    const btSoftBody::Node& n = soft.m_nodes[i];
    if (n.m_im > 0) sum += (0.5 * vec(n.m_v).squaredNorm() + gravity * n.m_x.z()) / double(n.m_im);
  }
  return sum;
}
double energyOf(const btRigidBody& body, double gravity) {
  const double mass = 1 / body.getInvMass();
  const btVector3 w = body.getAngularVelocity() * body.getWorldTransform().getBasis();
  double sum = mass * (0.5 * body.getLinearVelocity().length2() +
                       gravity * body.getWorldTransform().getOrigin().z());
  for (int i = 0; i < 3; ++i) sum += 0.5 * w[i] * w[i] / body.getInvInertiaDiagLocal()[i];
  return sum;
}
// About the world's origin.
Vec3 spinOf(const btSoftBody& soft) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < soft.m_nodes.size(); ++i) {
    const btSoftBody::Node& n = soft.m_nodes[i];
    if (n.m_im > 0) sum += vec(n.m_x).cross(vec(n.m_v)) / double(n.m_im);
  }
  return sum;
}
Vec3 spinOf(const btRigidBody& body) {
  const btMatrix3x3& turn = body.getWorldTransform().getBasis();
  const btVector3 w = body.getAngularVelocity() * turn, inverse = body.getInvInertiaDiagLocal();
  const btVector3 own =
      turn * btVector3(w.x() / inverse.x(), w.y() / inverse.y(), w.z() / inverse.z());
  return vec(body.getWorldTransform().getOrigin()).cross(vec(body.getLinearVelocity())) /
             double(body.getInvMass()) +
         vec(own);
}
Vec3 middleOf(const btSoftBody& soft) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < soft.m_nodes.size(); ++i) sum += vec(soft.m_nodes[i].m_x);
  return sum / soft.m_nodes.size();
}

// Each node's weight is its share of the spring, so all sink by weight / k.
void expectSag(SoftWorld& scene, const btSoftBody& sheet, double top, double sag, double voxel) {
  double worst = 0;
  for (int i = 0; i < sheet.m_nodes.size(); ++i)
    worst = std::max(worst, std::abs(top - sheet.m_nodes[i].m_x.z() - sag));
  EXPECT_LT(worst, std::max(0.01 * sag, 0.02 * voxel)) << "of " << sag;
  EXPECT_EQ(scene.clouds.statistics().failures, 0u) << scene.clouds.statistics().lastFailure;
}

TEST(SoftContact, ASheetRestsAtWeightOverStiffness) {
  const double mass = 0.1;
  for (const double step : {1. / 240, 1e-3})
    for (const double stiffness : {50.0, 500.0, 1e6})
      for (const int count : {5, 12}) {
        SoftWorld scene(pairOf(stiffness, 2 * std::sqrt(stiffness * mass)));
        scene.addCloud(boxField(), 0);
        btSoftBody& sheet = scene.addSheet(0.15, count, mass, at({0, 0, btScalar(0.055)}));
        for (int i = 0; i < 2 / step; ++i) scene.step(step);
        expectSag(scene, sheet, 0.05, mass * kGravity / stiffness, kVoxel);
      }
}

TEST(SoftContact, ATinySheetRestsAlike) {
  const double s = 1e-3, mass = 0.1 * s * s * s, stiffness = 50 * s * s;
  SoftWorld scene(pairOf(stiffness, 2 * std::sqrt(stiffness * mass)));
  scene.addCloud(boxField(s), 0);
  btSoftBody& sheet = scene.addSheet(0.15 * s, 8, mass, at({0, 0, btScalar(0.055 * s)}));
  for (int i = 0; i < 2000; ++i) scene.step(1e-4);
  expectSag(scene, sheet, 0.05 * s, mass * kGravity / stiffness, kVoxel * s);
}

TEST(SoftContact, AFreeBoxUnderASheetTakesNothingFromItsSag) {
  const double mass = 0.1, stiffness = 50;
  SoftWorld scene;
  // Bullet's own plane would push soft bodies up to 6 cm above it.
  scene.addCloud(boxField(), 0, at({0, 0, btScalar(-0.1)}))
      .setContactStiffnessAndDamping(btScalar(1e5), 500);
  btRigidBody& box = scene.addCloud(boxField(), 0.2);
  btSoftBody& sheet = scene.addSheet(0.15, 8, mass, at({0, 0, btScalar(0.055)}));
  sheet.setContactStiffnessAndDamping(btScalar(stiffness),
                                      btScalar(2 * std::sqrt(stiffness * mass)));
  for (int i = 0; i < 3000; ++i) scene.step(1e-3);
  expectSag(scene, sheet, 0.05 + box.getWorldTransform().getOrigin().z(),
            mass * kGravity / stiffness, kVoxel);
}

TEST(SoftContact, WhereNobodyStatesAStiffnessASheetSagsByATenthOfAVoxel) {
  SoftWorld scene;
  scene.addCloud(boxField(), 0);
  btSoftBody& sheet = scene.addSheet(0.15, 8, 0.1, at({0, 0, btScalar(0.052)}));
  for (int i = 0; i < 2000; ++i) scene.step(1e-3);
  expectSag(scene, sheet, 0.05, 0.1 * kVoxel, kVoxel);
}

TEST(SoftContact, FoundationIsStiffnessTimesTheFacesArea) {
  CloudContactSettings settings;
  settings.law = Foundation{2000, 200};  // [N/m^3, N s/m^3]
  SoftWorld scene(settings);
  scene.addCloud(boxField(), 0);
  btSoftBody& sheet = scene.addSheet(0.15, 8, 0.1, at({0, 0, btScalar(0.052)}));
  for (int i = 0; i < 3000; ++i) scene.step(1e-3);
  expectSag(scene, sheet, 0.05, 0.1 * kGravity / (2000 * 0.15 * 0.15), kVoxel);
  btSoftBody& rope = scene.addRope({btScalar(-0.1), 0, btScalar(0.06)},
                                   {btScalar(0.1), 0, btScalar(0.06)}, 9, 1, 0);
  scene.step(1e-3);
  EXPECT_NE(scene.clouds.statistics().lastFailure.find("no area"), std::string::npos);
  EXPECT_TRUE(std::isfinite(middleOf(rope).norm()));
}

// All nodes sink as one mass on a standard linear solid: by backward Euler, written out here, and
// in the end by weight / k.
TEST(SoftContact, ASheetCreepsAsTheSolid) {
  const double mass = 0.02, load = mass * kGravity, step = 1e-3;
  const double k = 10, k1 = 20, c1 = 2, keep = c1 / (c1 + step * k1);  // creep time 0.3 s
  CloudContactSettings settings;
  settings.law = StandardLinearSolid{k, k1, c1};
  SoftWorld scene(settings);
  scene.addCloud(boxField(), 0);
  btSoftBody& sheet = scene.addSheet(0.15, 6, mass, at({0, 0, btScalar(0.05)}));
  double depth = 0, rate = 0, branch = 0;
  for (int i = 1; i <= 2000; ++i) {
    scene.step(step);
    rate = (mass * rate + step * (load - k * depth - keep * branch)) /
           (mass + step * step * (k + keep * k1));
    branch = keep * (branch + k1 * step * rate);
    depth += step * rate;
    if (i % 50) continue;
    EXPECT_NEAR(0.05 - middleOf(sheet).z(), depth, std::max(0.01 * depth, 0.01 * kVoxel)) << i;
  }
  EXPECT_NEAR(depth, load / k, 0.01 * load / k);
}

// On a slope of 0.5 a sheet stands above friction 0.5 and below slides by g (sin - mu cos).
TEST(SoftContact, ASheetOnASlopeFollowsCoulombsLaw) {
  const double angle = std::atan(0.5);
  const btQuaternion turn(btVector3(0, 1, 0), btScalar(angle));
  for (const double friction : {0.0, 0.2, 0.4, 0.52}) {
    SoftWorld scene(pairOf(200, 10));
    scene.addCloud(boxField(), 0, at({0, 0, 0}, turn));
    const Vec3 down(std::cos(angle), 0, -std::sin(angle));
    const btTransform place = at({0, 0, 0}, turn) * at({btScalar(-0.08), 0, btScalar(0.0456)});
    btSoftBody& sheet = scene.addSheet(0.1, 6, 0.1, place, friction);
    const double step = 1e-3;
    for (int i = 0; i < 100; ++i) scene.step(step);
    const double from = middleOf(sheet).dot(down), speed = momentumOf(sheet).dot(down) / 0.1;
    const int more = friction > 0.5 ? 1000 : 100;
    for (int i = 0; i < more; ++i) scene.step(step);
    const double gained = momentumOf(sheet).dot(down) / 0.1 - speed;
    const double pull = kGravity * (std::sin(angle) - friction * std::cos(angle));
    if (friction > 0.5) {
      EXPECT_LT(std::abs(middleOf(sheet).dot(down) - from), 1e-3 * kVoxel) << friction;
    } else {
      EXPECT_NEAR(gained, pull * more * step, 0.01 * kGravity * more * step) << friction;
    }
  }
}

// The motion of the top of a rope that hangs over a ball, 0.1 m longer on one side. The ends swing
// undamped.
double ranOff(double friction) {
  SoftWorld scene(pairOf(2000, 5));
  scene.addCloud(ballField(), 0);
  btSoftBody& rope = scene.addRope({btScalar(-0.25), 0, btScalar(0.102)},
                                   {btScalar(0.35), 0, btScalar(0.102)}, 61, 0.05, friction);
  for (int i = 0; i < 500; ++i) scene.step(1e-3);
  const btVector3 before = rope.m_nodes[30].m_x;
  for (int i = 0; i < 1000; ++i) scene.step(1e-3);
  EXPECT_EQ(scene.clouds.statistics().failures, 0u);
  return (rope.m_nodes[30].m_x - before).length();
}

TEST(SoftContact, ARopeOverABallIsHeldByFriction) {
  EXPECT_LT(ranOff(0.9), 0.01 * kVoxel);
  EXPECT_GT(ranOff(0.02), 10 * kVoxel);
}

TEST(SoftContact, ASheetAndAFreeCloudKeepTheirMomentumAndGainNoEnergy) {
  for (const bool stated : {true, false}) {
    SoftWorld scene(stated ? pairOf(300, 0) : CloudContactSettings{}, 0);
    btRigidBody& ball = scene.addCloud(ballField(), 0.3);
    btSoftBody& sheet = scene.addSheet(0.15, 10, 0.1, at({btScalar(0.03), 0, btScalar(0.12)}), 0.3);
    ball.setAngularVelocity({2, 1, 0});
    sheet.setVelocity({0, 0, -1});
    const auto momentum = [&] {
      return Vec3(momentumOf(sheet) + 0.3 * vec(ball.getLinearVelocity()));
    };
    const Vec3 start = momentum(), spin = spinOf(sheet) + spinOf(ball);
    const double energy = energyOf(sheet, 0) + energyOf(ball, 0);
    double most = 0;
    for (int i = 0; i < 60; ++i) {
      scene.step(1. / 240);
      most = std::max(most, energyOf(sheet, 0) + energyOf(ball, 0));
    }
    EXPECT_LT((momentum() - start).norm(), 1e-5 * start.norm());
    // Positions change within the step in which impulses act: exact in the limit of small steps.
    EXPECT_LT((spinOf(sheet) + spinOf(ball) - spin).norm(), 0.05 * spin.norm());
    EXPECT_LT(most, energy * (1 + 1e-5));
    EXPECT_GT(ball.getLinearVelocity().length(), 0.05) << "they never met";
  }
}

TEST(SoftContact, ADroppedSheetGainsNoEnergy) {
  CloudContactSettings solid;
  solid.law = StandardLinearSolid{100, 200, 2};
  const CloudContactSettings all[] = {{}, pairOf(50, 0), pairOf(5000, 0), pairOf(300, 5), solid};
  int n = 0;
  for (const CloudContactSettings& settings : all) {
    for (const double step : {1. / 240, 1e-3}) {
      SoftWorld scene(settings);
      scene.addCloud(boxField(), 0);
      btSoftBody& sheet = scene.addSheet(
          0.2, 9, 0.1,
          at({btScalar(0.1), 0, btScalar(0.2)}, btQuaternion({1, 1, 0}, btScalar(0.5))), 0.3);
      const double start = energyOf(sheet, kGravity);
      double most = -1e9, push = 0;
      for (int i = 0; i < 1 / step; ++i) {
        scene.step(step);
        most = std::max(most, energyOf(sheet, kGravity));
        push = std::max(push, scene.pushOn(sheet));
      }
      EXPECT_LT(most, start * (1 + 1e-4)) << n << " at " << step;
      EXPECT_GT(push, 0);
    }
    ++n;
  }
}

// A ball on a sheet of equal mass that is pinned all around: the nodes bear its weight. (Bullet's
// links stretch without end under much heavier loads.)
TEST(SoftContact, ATrampolineBearsALoad) {
  for (const bool stated : {true, false}) {
    SoftWorld scene(stated ? pairOf(5000, 100) : CloudContactSettings{});
    btSoftBody& sheet = scene.addSheet(0.3, 13, 0.3, at({0, 0, 0}), 0.5);
    for (int i = 0; i < sheet.m_nodes.size(); ++i)
      if (i % 13 == 0 || i % 13 == 12 || i / 13 == 0 || i / 13 == 12) sheet.setMass(i, 0);
    sheet.m_cfg.piterations = 30;
    sheet.m_cfg.kDP = btScalar(0.02);
    btRigidBody& ball = scene.addCloud(ballField(), 0.3, at({0, 0, btScalar(0.101)}));
    for (int i = 0; i < 2000; ++i) scene.step(1e-3);
    double push = 0;
    for (int i = 0; i < 500; ++i) {
      scene.step(1e-3);
      push -= scene.pushOn(sheet) / 0.5;
    }
    EXPECT_NEAR(push, 0.3 * kGravity, 0.01 * 0.3 * kGravity);
    EXPECT_LT(ball.getLinearVelocity().length(), 0.05);
    EXPECT_GT(ball.getWorldTransform().getOrigin().z(), 0.02);
  }
}

// Neither the order of creation nor queries between steps change a bit.
std::vector<btScalar> endState(bool softFirst, bool look) {
  SoftWorld scene(pairOf(300, 2));
  btSoftBody* sheet = nullptr;
  const auto addSoft = [&] {
    sheet = &scene.addSheet(0.15, 8, 0.1, at({btScalar(0.02), 0, btScalar(0.12)}), 0.4);
  };
  if (softFirst) addSoft();
  btRigidBody& ball = scene.addCloud(ballField(), 0.5);
  ball.setGravity({0, 0, 0});
  if (!softFirst) addSoft();
  for (int i = 0; i < 300; ++i) {
    scene.step(1e-3);
    if (look) scene.world.performDiscreteCollisionDetection();
  }
  std::vector<btScalar> state;
  for (int i = 0; i < sheet->m_nodes.size(); ++i)
    for (int k = 0; k < 3; ++k) state.push_back(sheet->m_nodes[i].m_x[k]);
  for (int k = 0; k < 3; ++k) state.push_back(ball.getWorldTransform().getOrigin()[k]);
  EXPECT_GT(ball.getLinearVelocity().length(), 1e-3);
  return state;
}

TEST(SoftContact, OrderAndQueriesChangeNoBit) {
  const std::vector<btScalar> state = endState(true, false);
  EXPECT_EQ(state, endState(false, false));
  EXPECT_EQ(state, endState(true, true));
}

// A sheet that moves nine voxels a step, from outside the field of the plate on one side to beyond
// its middle, stops where it would have entered.
TEST(SoftContact, AFastSheetDoesNotPassAPlate) {
  SoftWorld scene(pairOf(1e6, 450));
  scene.addCloud(fieldOf(boxMesh({0.3, 0.3, 0.04}), kVoxel), 0);
  btSoftBody& sheet = scene.addSheet(0.15, 6, 0.05, at({0, 0, btScalar(0.33)}));
  sheet.setVelocity({0, 0, -90});
  for (int i = 0; i < 400; ++i) scene.step(1e-3);
  EXPECT_GT(middleOf(sheet).z(), 0.01);
}

// Seven voxels deep, beyond the field's five.
TEST(SoftContact, DeeperThanTheBandASheetIsStillPushedOut) {
  const double mass = 0.1, stiffness = 14;
  SoftWorld scene(pairOf(stiffness, 2 * std::sqrt(stiffness * mass)));
  scene.addCloud(fieldOf(boxMesh({0.3, 0.3, 0.2}), kVoxel), 0);
  btSoftBody& sheet = scene.addSheet(0.15, 6, mass, at({0, 0, btScalar(0.105)}));
  for (int i = 0; i < 3000; ++i) scene.step(1e-3);
  expectSag(scene, sheet, 0.1, mass * kGravity / stiffness, kVoxel);
}

TEST(SoftContact, AChildOfACompoundTouchesAlike) {
  const double mass = 0.1, stiffness = 50;
  SoftWorld scene(pairOf(stiffness, 2 * std::sqrt(stiffness * mass)));
  CloudShape left(boxField()), right(boxField());
  auto both = std::make_unique<btCompoundShape>();
  both->addChildShape(at({btScalar(-0.15), 0, 0}), &left);
  both->addChildShape(at({btScalar(0.35), 0, btScalar(0.3)}), &right);
  scene.add(std::move(both), 0, at({btScalar(0.15), 0, 0}));
  btSoftBody& sheet = scene.addSheet(0.15, 6, mass, at({0, 0, btScalar(0.055)}));
  for (int i = 0; i < 2000; ++i) scene.step(1e-3);
  expectSag(scene, sheet, 0.05, mass * kGravity / stiffness, kVoxel);
}

TEST(SoftContact, BodiesOfADeformableWorldCountAsFailures) {
  CloudContact clouds;
  CloudShape shape(boxField());
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  clouds.attach(dispatcher);
  btDbvtBroadphase broadphase;
  btDeformableBodySolver deformable;
  btDeformableMultiBodyConstraintSolver solver;
  solver.setDeformableSolver(&deformable);
  btDeformableMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration,
                                           &deformable);
  btRigidBody box(0, nullptr, &shape);
  world.addRigidBody(&box);
  btSoftBody* const sheet = btSoftBodyHelpers::CreatePatch(
      world.getWorldInfo(), {btScalar(-0.1), btScalar(-0.1), btScalar(0.04)},
      {btScalar(0.1), btScalar(-0.1), btScalar(0.04)},
      {btScalar(-0.1), btScalar(0.1), btScalar(0.04)},
      {btScalar(0.1), btScalar(0.1), btScalar(0.04)}, 5, 5, 0, true);
  world.addSoftBody(sheet);
  for (int i = 0; i < 3; ++i) world.stepSimulation(btScalar(1e-3), 0);
  EXPECT_GE(clouds.statistics().failures, 3u);
  EXPECT_NE(clouds.statistics().lastFailure.find("btSoftRigidDynamicsWorld"), std::string::npos);
  EXPECT_TRUE(std::isfinite(middleOf(*sheet).norm()));
  recommendedSettings(world);
  const std::vector<std::string> advice = diagnose(world);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_NE(advice[0].find("Object 1"), std::string::npos) << advice[0];
  EXPECT_NE(advice[0].find("btSoftRigidDynamicsWorld"), std::string::npos) << advice[0];
  world.removeSoftBody(sheet);
  world.removeRigidBody(&box);
  delete sheet;
}

}  // namespace
}  // namespace cloudcontact::testing::soft_contact_test
