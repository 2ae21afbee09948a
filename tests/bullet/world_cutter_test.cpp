// Milling in a world: a driven cutter takes a groove out of a block that a spring holds. The volume
// is that of the groove, the force stays bounded, and no momentum is lost.
#include <cloudcontact/bullet/world_cutter.h>
#include <gtest/gtest.h>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::world_cutter_test {
namespace {

constexpr double kVoxel = 1e-3, kStep = 1e-3;
const Vec3 kBlock(0.040, 0.024, 0.016);           // edges [m]
constexpr double kRadius = 4e-3, kDeep = 5e-3;    // of the mill, and below the block's top [m]
constexpr double kFeed = 0.06, kSpin = 300;       // [m/s, rad/s]
constexpr double kHardness = 5e6, kSpring = 2e4;  // [Pa, N/m]
constexpr double kDensity = 2000;                 // [kg/m^3]

btVector3 v(double x, double y, double z) {
  return {btScalar(x), btScalar(y), btScalar(z)};
}

// A mill along z that moves along x and spins, on rails.
struct Mill {
  btCylinderShapeZ shape{v(kRadius, kRadius, 0.02)};
  btRigidBody body{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape)};
  double x = -0.5 * kBlock.x() - 1.2 * kRadius, y = 0, angle = 0;
  double deep;

  explicit Mill(double below) : deep(below) {
    body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body.setActivationState(DISABLE_DEACTIVATION);
    place();
    body.setInterpolationWorldTransform(body.getWorldTransform());
  }
  void place() {
    body.setWorldTransform(
        at(v(x, y, 0.5 * kBlock.z() - deep + 0.02), btQuaternion(v(0, 0, 1), btScalar(angle))));
  }
  void advance(const Vec3& along = Vec3::UnitX()) {
    x += along.x() * kFeed * kStep;
    y += along.y() * kFeed * kStep;
    angle += kSpin * kStep;
    place();
  }
};

struct Milling {
  BulletWorld world;
  CuttableBody block;
  Mill mill;
  WorldCutter cutter;
  double volume = 0, mostForce = 0;
  Vec3 given = Vec3::Zero(), lost = Vec3::Zero();  // to the block; with the matter cut away
  double exchanged = 0;                            // sum of the sizes of impulses

  static CuttableBodySettings settings() {
    CuttableBodySettings s;
    s.densities = {kDensity};
    s.threads = 1;
    s.law = KelvinVoigt{4e4, 40};
    s.leastPiece = 20 * kDensity * kVoxel * kVoxel * kVoxel;  // crumbs are cut away
    return s;
  }
  static TissueTable tissues(double hardness = kHardness) {
    return {{"wax", 4e4, 40, hardness, kDensity}};
  }
  explicit Milling(double deep = kDeep, double hardness = kHardness)
      : block(fieldOf(boxMesh(kBlock), kVoxel)->cloud(), at(v(0, 0, 0)), settings()), mill(deep) {
    world.world.setGravity(v(0, 0, 0));
    world.world.addRigidBody(&mill.body);
    block.addTo(world.world);
    block.body().setActivationState(DISABLE_DEACTIVATION);
    block.body().setLinearFactor(v(1, 0, 0));
    block.body().setAngularFactor(v(0, 0, 0));
    Cutter edges;
    edges.efficiency = 0.5;
    Detection tool;
    tool.area = {Cylinder{kRadius, 0.02}, {}};
    cutter.addTool(mill.body, tool, edges);
    cutter.addBody(block, tissues(hardness));
  }
  ~Milling() {
    block.leaveWorld();
    world.world.removeRigidBody(&mill.body);
  }

  double shift() const { return double(block.cloudPlace().getOrigin().x()); }
  void step() {
    mill.advance();
    const double pull = -kSpring * shift();
    block.body().applyCentralForce(v(pull, 0, 0));
    world.step(kStep);
    Vec3 pushed = Vec3::Zero();
    for (const btManifoldPoint& p : world.points()) {
      const btVector3 on = p.m_normalWorldOnB * p.m_appliedImpulse +
                           p.m_lateralFrictionDir1 * p.m_appliedImpulseLateral1 +
                           p.m_lateralFrictionDir2 * p.m_appliedImpulseLateral2;
      pushed += sign() * Vec3(on.x(), on.y(), on.z());
    }
    given += pushed + Vec3(pull * kStep, 0, 0);
    exchanged += std::abs(pushed.x()) + std::abs(pull * kStep);
    mostForce = std::max(mostForce, pushed.norm() / kStep);
    for (const WorldCut& cut : cutter.after(kStep)) {
      volume += cut.volume;
      lost += cut.outcome.cutAway.momentum;
      EXPECT_TRUE(cut.outcome.fallen.empty());
    }
  }
  // 1 if the block is the manifolds' first body.
  double sign() const {
    const btDispatcher& dispatcher = world.dispatcher;
    const auto& manifold = *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(0);
    return manifold.getBody0() == &block.body() ? 1 : -1;
  }
};

TEST(WorldCutter, MillsAGroove) {
  Milling m;
  const double before = m.block.matter().mass;
  while (m.mill.x < 0) m.step();
  // The groove to the mill's axis, and the half circle before it.
  const double length = m.mill.x - m.shift() + 0.5 * kBlock.x();
  const double swept = kDeep * (2 * kRadius * length + M_PI / 2 * kRadius * kRadius);
  EXPECT_NEAR(before - m.block.matter().mass, kDensity * swept, 0.02 * kDensity * swept);
  EXPECT_NEAR(m.volume, swept, 0.02 * swept);
  EXPECT_LT(m.mostForce, 60);
  EXPECT_GT(m.mostForce, 1);
  const Vec3 momentum = m.block.matter().momentum + m.lost;
  EXPECT_NEAR(momentum.x(), m.given.x(), 0.01 * m.exchanged);
}

// A mill that passes through the whole block parts it in two, and turns into one of the pieces. In
// matter so soft that nothing of the last bridge is left standing.
TEST(WorldCutter, PartsABlockAndCutsBothPieces) {
  constexpr double kSoft = 1e-3 * kHardness;
  Milling m(1.2 * kBlock.z(), kSoft);
  const double before = m.block.volume();
  std::vector<std::unique_ptr<CuttableBody>> pieces;
  double volume = 0, ofPieces = 0;
  const auto hold = [](CuttableBody& body) {
    body.body().setLinearFactor(v(1, 1, 0));
    body.body().setAngularFactor(v(0, 0, 0));
    body.body().applyCentralForce(btScalar(-kSpring) * body.cloudPlace().getOrigin() -
                                  btScalar(2) * body.body().getLinearVelocity());
  };
  const auto go = [&](const Vec3& along) {
    m.mill.advance(along);
    hold(m.block);
    for (auto& piece : pieces) hold(*piece);
    m.world.step(kStep);
    for (WorldCut& cut : m.cutter.after(kStep)) {
      volume += cut.volume;
      if (cut.body != &m.block) ofPieces += cut.volume;
      for (auto& piece : cut.outcome.fallen) {
        m.cutter.addBody(*piece, Milling::tissues(kSoft));
        pieces.push_back(std::move(piece));
      }
    }
  };
  for (int k = 0; k < 1000 && pieces.empty(); ++k) go(Vec3::UnitX());
  ASSERT_EQ(pieces.size(), 1u);
  CuttableBody& piece = *pieces[0];
  EXPECT_NEAR(piece.volume(), m.block.volume(), 0.1 * m.block.volume());
  const double side = piece.matter().center.y() > 0 ? 1 : -1;
  for (int k = 0; k < 90; ++k) go(side * Vec3::UnitY());
  EXPECT_GT(ofPieces, 0.02 * before);
  EXPECT_NEAR(before - m.block.volume() - piece.volume(), volume, 0.01 * volume) << ofPieces;
}

TEST(WorldCutter, CutsNothingWithoutATool) {
  Milling m;
  const double before = m.block.matter().mass;
  EXPECT_GT(before, 0);
  EXPECT_THROW(m.cutter.after(0), std::invalid_argument);
  Detection nothing;
  EXPECT_THROW(m.cutter.addTool(m.mill.body, nothing, Cutter{}), std::invalid_argument);
  m.cutter.removeTool(m.mill.body);
  while (m.mill.x < -0.4 * kBlock.x()) m.step();
  EXPECT_EQ(m.volume, 0);
}

}  // namespace
}  // namespace cloudcontact::testing::world_cutter_test
