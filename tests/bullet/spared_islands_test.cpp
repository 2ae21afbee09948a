// NewtonSolver::cloudsOnly: Bullet's own shapes move as in a world without clouds and
// settings of ours, to the bit, and clouds as with recommendedSettings().
#include <cloudcontact/bullet/diagnosis.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>

namespace cloudcontact::testing::spared_islands_test {
namespace {

constexpr double kVoxel = 0.1;
constexpr int kSteps = 240;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({1, 1, 1}), kVoxel);
  return field;
}

enum class Solved { ByBullet, BySettings, CloudsOnly };

// Bullet's own bodies on a slab, and clouds on the same slab and on a cloud of their own.
class MixedWorld {
 public:
  MixedWorld(Solved how, bool clouds) {
    contact_.attach(dispatcher_);
    sweeps_.cloudsOnly = true;
    if (how == Solved::CloudsOnly) world_.setConstraintSolver(&sweeps_);
    if (how != Solved::ByBullet) recommendedSettings(world_);
    world_.setGravity({0, 0, btScalar(-9.81)});
    // Else the order of contacts in one island depends on those in others.
    world_.getDispatchInfo().m_deterministicOverlappingPairs = true;
    addBulletsOwn();
    own_ = bodies_.size();
    if (clouds) addClouds();
  }
  ~MixedWorld() {
    for (auto& joint : joints_) world_.removeConstraint(joint.get());
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void step() { world_.stepSimulation(btScalar(1.0 / 60), 0); }
  // Of Bullet's own bodies, or of clouds and what lies on them.
  std::uint64_t hash(bool ofClouds) const {
    Hash hash;
    const std::size_t from = ofClouds ? own_ : 0, to = ofClouds ? bodies_.size() : own_;
    for (std::size_t i = from; i < to; ++i) {
      hash.add(bodies_[i]->getWorldTransform().getOrigin());
      hash.add(bodies_[i]->getWorldTransform().getRotation());
      hash.add(bodies_[i]->getLinearVelocity());
      hash.add(bodies_[i]->getAngularVelocity());
    }
    return hash.value();
  }
  btDiscreteDynamicsWorld& world() { return world_; }
  NewtonSolver& sweeps() { return sweeps_; }

 private:
  btRigidBody& add(std::unique_ptr<btCollisionShape> shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
    return *bodies_.back();
  }
  btRigidBody& addBox(const btVector3& half, double mass, const btTransform& place) {
    return add(std::make_unique<btBoxShape>(half), mass, place);
  }

  // A slab, a leaning stack that slides, two boxes deep in each other, a ball, and a hinge.
  void addBulletsOwn() {
    const btVector3 half(0.5, 0.5, 0.5);
    addBox({50, 50, 1}, 0, at({0, 0, -1}));
    for (int i = 0; i < 3; ++i)
      addBox(half, 1 + 4 * i, at({btScalar(0.2 * i), 0, btScalar(0.5 + i)}))
          .setLinearVelocity({2, 1, 0});
    addBox(half, 1, at({10, 0, btScalar(0.45)}));
    addBox(half, 2, at({btScalar(10.3), 0, btScalar(1.2)}));
    add(std::make_unique<btSphereShape>(btScalar(0.5)), 1, at({20, 0, 2})).setRestitution(1);
    btRigidBody& low = addBox(half, 1, at({30, 0, btScalar(0.5)}));
    btRigidBody& high = addBox(half, 1, at({30, 0, btScalar(1.7)}));
    joints_.push_back(std::make_unique<btHingeConstraint>(
        low, high, btVector3(btScalar(0.5), 0, btScalar(0.6)),
        btVector3(btScalar(0.5), 0, btScalar(-0.6)), btVector3(0, 1, 0), btVector3(0, 1, 0)));
    world_.addConstraint(joints_.back().get(), true);
  }
  void addClouds() {
    add(exactCloud(cubeField()), 1, at({0, 10, btScalar(0.5)})).setLinearVelocity({2, 1, 0});
    add(exactCloud(cubeField()), 0, at({10, 10, btScalar(0.5)}));
    add(exactCloud(cubeField()), 5, at({10, 10, btScalar(1.5)}));
    addBox({btScalar(0.5), btScalar(0.5), btScalar(0.5)}, 1, at({10, 10, btScalar(2.5)}));
  }

  CloudContact contact_;  // first: it must outlive the dispatcher
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver bullets_;
  NewtonSolver sweeps_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &bullets_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::size_t own_ = 0;
};

std::vector<std::uint64_t> hashes(Solved how, bool clouds, bool ofClouds) {
  MixedWorld mixed(how, clouds);
  mixed.sweeps().newton = !ofClouds;  // recommendedSettings() alone does not
  std::vector<std::uint64_t> all;
  for (int i = 0; i < kSteps; ++i) {
    mixed.step();
    all.push_back(mixed.hash(ofClouds));
  }
  return all;
}

TEST(SparedIslands, BulletsOwnShapesMoveAsWithoutOurSettings) {
  const auto wanted = hashes(Solved::ByBullet, true, false);
  EXPECT_EQ(hashes(Solved::CloudsOnly, true, false), wanted);
  EXPECT_EQ(hashes(Solved::ByBullet, false, false), wanted) << "clouds far away change a body";
  EXPECT_NE(hashes(Solved::BySettings, true, false), wanted) << "nothing here feels the settings";
}

TEST(SparedIslands, CloudsMoveAsWithOurSettings) {
  const auto wanted = hashes(Solved::BySettings, true, true);
  EXPECT_EQ(hashes(Solved::CloudsOnly, true, true), wanted);
  EXPECT_NE(hashes(Solved::ByBullet, true, true), wanted) << "nothing here feels the settings";
}

TEST(SparedIslands, TheWorldsSettingsStayAndNothingIsAdvised) {
  MixedWorld mixed(Solved::CloudsOnly, true);
  const btContactSolverInfo plain;
  EXPECT_EQ(mixed.world().getSolverInfo().m_solverMode, plain.m_solverMode);
  EXPECT_EQ(mixed.world().getSolverInfo().m_splitImpulse, plain.m_splitImpulse);
  EXPECT_EQ(mixed.world().getSolverInfo().m_warmstartingFactor, plain.m_warmstartingFactor);
  EXPECT_TRUE(diagnose(mixed.world()).empty());
  mixed.sweeps().cloudsOnly = false;
  EXPECT_FALSE(diagnose(mixed.world()).empty());
}

}  // namespace
}  // namespace cloudcontact::testing::spared_islands_test
