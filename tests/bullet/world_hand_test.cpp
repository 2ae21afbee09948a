// A hand pushes a free tooth over a table: what the hand gives the tooth has, less what friction
// takes, and the hand feels the same force.
#include <cloudcontact/bullet/world_hand.h>
#include <gtest/gtest.h>

#include "bullet/bullet_world.h"
#include "bullet/convert.h"

namespace cloudcontact::testing::world_hand_test {
namespace {

constexpr double kVoxel = 5e-4, kStep = 1e-3, kMass = 0.02;
const Vec3 kEdges(0.012, 0.010, 0.008);

struct Table {
  BulletWorld world;
  std::shared_ptr<const SurfaceField> field = fieldOf(boxMesh(kEdges), kVoxel);
  BaseVectorField matter{field->cloud(), {{"dentin", 2e4, 4, 6e8, 2100}}, sphereWindow(kVoxel)};
  btRigidBody* tooth = nullptr;

  explicit Table(double friction) {
    world.addGround().setFriction(btScalar(friction));
    tooth = &world.addCloud(field, kMass, at({0, 0, btScalar(kEdges.z() / 2)}));
    tooth->setFriction(1);
    for (int i = 0; i < 200; ++i) world.step(kStep);
  }
  static HapticSettings settings() {
    HapticSettings s;
    s.tool.area = {Sphere{1e-3}, {}};
    s.step = kStep;
    s.handStiffness = 200;
    s.handDamping = 0.2;
    return s;
  }
  Vec3 momentum() const { return kMass * toVec3(tooth->getLinearVelocity()); }
  // Of the table on the tooth in the last step.
  Vec3 fromTable() const {
    Vec3 sum = Vec3::Zero();
    const btDispatcher& d = world.dispatcher;
    auto& dispatcher = const_cast<btDispatcher&>(d);
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& m = *dispatcher.getManifoldByIndexInternal(i);
      const double sign = m.getBody0() == tooth ? 1 : -1;
      for (int k = 0; k < m.getNumContacts(); ++k) {
        const btManifoldPoint& p = m.getContactPoint(k);
        sum += sign * toVec3(p.m_normalWorldOnB * p.m_appliedImpulse +
                             p.m_lateralFrictionDir1 * p.m_appliedImpulseLateral1 +
                             p.m_lateralFrictionDir2 * p.m_appliedImpulseLateral2);
      }
    }
    return sum;
  }
};

class PushedTooth : public ::testing::TestWithParam<double> {};

TEST_P(PushedTooth, KeepsMomentum) {
  Table table(GetParam());
  WorldHand hand(*table.tooth, table.matter, Pose{}, Table::settings());
  HapticInput input;
  const double speed = 0.02;
  input.velocity = Vec3(speed, 0, 0);
  const Vec3 before = table.momentum();
  Vec3 others = Vec3::Zero(), felt = Vec3::Zero();
  double most = 0, exchanged = 0, half = 0;
  for (int i = 0; i < 1000; ++i) {
    input.hand.position = Vec3(-kEdges.x() / 2 - 1.5e-3 + speed * kStep * i, 0, kEdges.z() / 2);
    const HapticOutput& out = hand.tick(input);
    felt += kStep * out.onHand.force;
    most = std::max(most, out.onHand.force.norm());
    table.world.step(kStep);
    others += table.fromTable() + Vec3(0, 0, -9.81 * kMass * kStep);
    exchanged += kStep * out.onHand.force.norm();
    if (i == 499) half = double(table.tooth->getWorldTransform().getOrigin().x());
  }
  EXPECT_GT(most, 0.5 * GetParam() * kMass * 9.81);
  EXPECT_GT(double(table.tooth->getWorldTransform().getOrigin().x()), 0.01);
  const Vec3 gained = table.momentum() - before;
  EXPECT_LT((gained - hand.given() - others).norm(), 0.01 * exchanged);
  EXPECT_LT((felt + hand.given()).norm(), 1e-9 + 1e-6 * exchanged);
  // The tooth goes with the hand.
  const double way = double(table.tooth->getWorldTransform().getOrigin().x()) - half;
  EXPECT_NEAR(way / 0.5, speed, 0.05 * speed);
}

INSTANTIATE_TEST_SUITE_P(Frictions, PushedTooth, ::testing::Values(0.05, 0.3));

}  // namespace
}  // namespace cloudcontact::testing::world_hand_test
