// What nodes of soft tissue touch: k and c by (1), (2) and in series, directions by (5'), against
// sums worked by hand. Momentum between tissue and rigid clouds.
#include "bullet/soft_world.h"

#include <cloudcontact/bullet/soft_contact_point.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cloudcontact::testing::soft_matter_test {
namespace {

constexpr double kVoxel = 0.0025, kEdge = 0.02, kGravity = 9.81;
// Of the floor's two tissues.
constexpr double kLeft = 3000, kRight = 600, cLeft = 20, cRight = 5;
// Of the flesh (soft_world.h).
constexpr double kOwn = 1000, cOwn = 10;

TissueTable floorTissues() {
  return {{"lower", kLeft, cLeft, 1e6, 1000}, {"upper", kRight, cRight, 3e6, 1000}};
}

double seriesStiffness(double other) {
  return kOwn * other / (kOwn + other);
}
double seriesDamping(double k, double c) {
  return (c * kOwn * kOwn + cOwn * k * k) / ((k + kOwn) * (k + kOwn));
}

// A floor whose top is z = 0, of one tissue where x < 0 and of another where x > 0.
class Floor {
 public:
  Floor(TissueWorld& world, bool vectors) : world_(world.world) {
    const Cloud cloud = layeredCloud({0.04, 0.1, 0.1}, kVoxel, 0.05).translated({0, 0, -0.05});
    shape_ = std::make_unique<CloudShape>(SurfaceField::build(cloud));
    shape_->setTissues(floorTissues());
    if (vectors) shape_->usePaper();
    // The cloud's z is the world's x, and its low x side is up.
    const btTransform place(btMatrix3x3(0, 0, 1, 0, 1, 0, -1, 0, 0), {0, -0.05f, 0});
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape_.get());
    info.m_startWorldTransform = place;
    info.m_friction = 1;
    body_ = std::make_unique<btRigidBody>(info);
    world_.addRigidBody(body_.get());
  }
  ~Floor() { world_.removeRigidBody(body_.get()); }
  const CloudShape& shape() const { return *shape_; }
  Vec3 toLocal(const Vec3& world) const { return {-world.z(), world.y() + 0.05, world.x()}; }
  Vec3 toWorld(const Vec3& local) const { return {local.z(), local.y(), -local.x()}; }  // turn only

 private:
  btSoftRigidDynamicsWorld& world_;
  std::unique_ptr<CloudShape> shape_;
  std::unique_ptr<btRigidBody> body_;
};

// A cube of one cell, so of eight nodes, each with an eighth of its surface.
std::unique_ptr<SoftTissue> cube(TissueWorld& world, const Vec3& low) {
  SoftTissueSettings settings;
  settings.spacing = kEdge;
  settings.friction = 1;
  return std::make_unique<SoftTissue>(boxCloud({kEdge, kEdge, kEdge}, kVoxel),
                                      TissueTable{soft("flesh", 1e5)},
                                      at({btScalar(low.x()), btScalar(low.y()), btScalar(low.z())}),
                                      world.world.getWorldInfo(), settings);
}

std::vector<SoftContactPoint> pointsOf(const TissueWorld& world, const SoftTissue& tissue) {
  std::vector<SoftContactPoint> points;
  world.clouds.softContacts(tissue.body(), points);
  return points;
}

// At rest each lower node sinks in by its force over an eighth of its own k. The left ones meet the
// left tissue by 3/4 of a voxel and the right one by 1/4, the others the right one alone.
TEST(SoftMatter, NodesSinkByTheTissuesTheyTouch) {
  TissueWorld world(kGravity);
  const Floor floor(world, false);
  const auto tissue = cube(world, {-0.25 * kVoxel, 0, 0});
  tissue->addTo(world.world);
  for (int i = 0; i < 3000; ++i) world.step(0.001);
  const auto points = pointsOf(world, *tissue);
  ASSERT_EQ(points.size(), 4u);
  double all = 0;
  for (const SoftContactPoint& p : points) {
    const double left = p.position.x() < 0.01 ? 0.5 - p.position.x() / kVoxel : 0;
    EXPECT_NEAR(left, p.position.x() < 0.01 ? 0.75 : 0, 0.05);
    const double floors = left * kLeft + (1 - left) * kRight;
    const double force = p.impulse.dot(p.normal) / 0.001;
    EXPECT_NEAR(p.depth * seriesStiffness(floors) / 8 / force, 1, 5e-3) << p.position.x();
    EXPECT_GT(p.normal.z(), 0.9999);
    all += p.impulse.z() / 0.001;
  }
  const double weight = 1000 * kEdge * kEdge * kEdge * kGravity;
  EXPECT_NEAR(all, weight, 1e-3 * weight);
}

// The impulse of one step, by backward Euler: J = h (k (d + h v) + c v) / 8, v = v0 - J / m.
TEST(SoftMatter, NodesAreDampedByTheTissuesTheyTouch) {
  TissueWorld world(0);
  const Floor floor(world, false);
  const double sunk = 2e-4, speed = 0.05, h = 0.001;
  const auto tissue = cube(world, {-0.25 * kVoxel, 0, -sunk});
  tissue->addTo(world.world);
  tissue->body().setVelocity({0, 0, btScalar(-speed)});
  world.step(h);
  const auto points = pointsOf(world, *tissue);
  ASSERT_EQ(points.size(), 4u);
  const double mass = 1000 * kEdge * kEdge * kEdge / 8;
  for (const SoftContactPoint& p : points) {
    const bool left = p.position.x() < 0.01;
    const double kFloor = left ? 0.75 * kLeft + 0.25 * kRight : kRight;
    const double cFloor = left ? 0.75 * cLeft + 0.25 * cRight : cRight;
    const double k = seriesStiffness(kFloor) / 8, c = seriesDamping(kFloor, cFloor) / 8;
    const double grip = h * (h * k + c);
    const double wanted = (h * k * p.depth + grip * speed) / (1 + grip / mass);
    EXPECT_NEAR(p.depth, sunk, 1e-2 * sunk);
    EXPECT_NEAR(p.impulse.z() / wanted, 1, 5e-3);
  }
}

// F is the mean over the voxels in a cube of a voxel's edge, by share and hardness.
TEST(SoftMatter, NodesArePushedAlongBaseVectors) {
  TissueWorld world(0);
  const Floor floor(world, true);
  // One corner near the seam, one over the floor's edge at y = -0.05.
  const auto tissue = cube(world, {-0.3 * kVoxel, -0.05 + 0.4 * kVoxel, -0.7 * kVoxel});
  tissue->addTo(world.world);
  world.step(0.001);
  const auto points = pointsOf(world, *tissue);
  ASSERT_EQ(points.size(), 4u);
  const BaseVectorField& field = *floor.shape().paper()->vectors;
  double leastUp = 1;
  for (const SoftContactPoint& p : points) {
    const Vec3 low = (floor.toLocal(p.position) - field.origin()) / kVoxel - Vec3::Constant(0.5);
    Vec3 sum = Vec3::Zero();
    double bounds = 2;
    const VoxelIndex first = low.array().floor().cast<int>();
    for (int z = 0; z < bounds; ++z)
      for (int y = 0; y < bounds; ++y)
        for (int x = 0; x < bounds; ++x) {
          const VoxelIndex v = first + VoxelIndex(x, y, z);
          double share = field.coverage(v) / 255.0;
          for (int e = 0; e < 3; ++e)
            share *=
                std::max(0.0, std::min(low[e], double(v[e])) + 1 - std::max(low[e], double(v[e])));
          sum += share * (field.tissue(v) == 0 ? 1 : 3) * field.at(v).toRepresentative;
        }
    const Vec3 wanted = floor.toWorld(sum.normalized());
    EXPECT_LT((p.normal - wanted).norm(), 1e-3);
    leastUp = std::min(leastUp, p.normal.z());
  }
  EXPECT_LT(leastUp, 0.95);  // the edge bends it
}

// A block of tissue and a rigid ball of two tissues meet off center.
TEST(SoftMatter, MomentumIsKept) {
  for (const bool vectors : {false, true}) {
    TissueWorld world(0);
    CloudShape ball(fieldOf(sphereMesh(0.02, 1e-5), kVoxel));
    ball.setTissues({{"bone", 4000, 5, 1e6, 1500}});
    PaperSettings paper;
    paper.window = sphereWindow(kVoxel);
    if (vectors) ball.usePaper(paper);
    btVector3 inertia;
    ball.calculateLocalInertia(btScalar(0.05), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(0.05), nullptr, &ball, inertia);
    info.m_startWorldTransform = at({btScalar(0.014), btScalar(0.02), btScalar(0.065)});
    info.m_linearDamping = info.m_angularDamping = 0;
    info.m_friction = 1;
    btRigidBody rigid(info);
    rigid.setActivationState(DISABLE_DEACTIVATION);
    rigid.setLinearVelocity({0, 0, -1});
    world.world.addRigidBody(&rigid);
    SoftTissueSettings settings;
    settings.spacing = 0.01;
    settings.friction = 0.5;
    SoftTissue block(boxCloud({0.04, 0.04, 0.04}, kVoxel), {soft("flesh", 3e4)}, at({0, 0, 0}),
                     world.world.getWorldInfo(), settings);
    block.addTo(world.world);
    std::size_t touching = 0;
    for (int k = 0; k < 200; ++k) {
      world.step(0.0005);
      touching = std::max(touching, pointsOf(world, block).size());
      Vec3 sum = 0.05 * Vec3(rigid.getLinearVelocity().x(), rigid.getLinearVelocity().y(),
                             rigid.getLinearVelocity().z());
      for (int i = 0; i < block.nodes(); ++i) sum += block.matter(i).mass * velocityOf(block, i);
      EXPECT_LT((sum - Vec3(0, 0, -0.05)).norm(), 50 * kRounding * 0.05) << k;
    }
    EXPECT_GE(touching, 4u);
    EXPECT_GT(rigid.getLinearVelocity().z(), -0.8);  // it was slowed
    world.world.removeRigidBody(&rigid);
    block.leaveWorld();
  }
}

}  // namespace
}  // namespace cloudcontact::testing::soft_matter_test
