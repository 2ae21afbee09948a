// A blade cuts soft tissue: where it is able to, into pieces that part, with mass, momentum and
// energy kept.
#include "bullet/soft_world.h"

#include <cloudcontact/bullet/world_cutter.h>
#include <cloudcontact/workpiece/cloud_solid.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloudcontact::testing::soft_cut_test {
namespace {

constexpr double kVoxel = 0.0025, kCell = 0.01;

Detection bladeOf(const Vec3& size) {
  Detection tool;
  tool.area.solid = Box{0.5 * size};
  return tool;
}

// 0.06 long along x, 0.02 wide and 0.04 high: 7 x 3 x 5 nodes.
std::unique_ptr<SoftTissue> bar(TissueWorld& world, double upper = 1e5) {
  SoftTissueSettings settings;
  settings.spacing = kCell;
  return std::make_unique<SoftTissue>(
      layeredCloud({0.06, 0.02, 0.04}, kVoxel, 0.02),
      TissueTable{soft("lower", 5e4, 1000, 1e5), soft("upper", 5e4, 1000, upper)}, at({0, 0, 0}),
      world.world.getWorldInfo(), settings);
}

int piecesOf(const SoftTissue& tissue) {
  return 1 + *std::max_element(tissue.pieces().begin(), tissue.pieces().end());
}

Pose placed(double x, double z) {
  return {Eigen::Quaterniond::Identity(), Vec3(x, 0.01, z)};
}

double energyOf(const SoftTissue& tissue) {
  double sum = tissue.elasticEnergy();
  for (int i = 0; i < tissue.nodes(); ++i)
    sum += 0.5 * tissue.matter(i).mass * velocityOf(tissue, i).squaredNorm();
  return sum;
}

TEST(SoftCut, ABladePartsWhatItCanCut) {
  TissueWorld world(0);
  const auto tissue = bar(world);
  const Detection blade = bladeOf({0.001, 0.1, 0.1});
  EXPECT_EQ(tissue->cut(blade, placed(0.025, 0), 0.99e5), 0u);  // the tissue is as hard
  EXPECT_EQ(piecesOf(*tissue), 1);
  // Between two layers of 15 nodes: 15 links straight across, and of the 2 x 5 and 3 x 4 faces
  // there both diagonals.
  EXPECT_EQ(tissue->cut(blade, placed(0.025, 0.02), 1.01e5), 15u + 2 * (10 + 12));
  EXPECT_EQ(piecesOf(*tissue), 2);
  for (int i = 0; i < tissue->nodes(); ++i)
    EXPECT_EQ(tissue->pieces()[static_cast<std::size_t>(i)], placeOf(*tissue, i).x() > 0.025);
  EXPECT_EQ(tissue->cut(blade, placed(0.025, 0.02), 1.01e5), 0u);
}

// The upper layer is too hard: nodes at 0.02 have both tissues, and belong to the first.
TEST(SoftCut, HardTissueStays) {
  TissueWorld world(0);
  const auto tissue = bar(world, 1e7);
  const Detection blade = bladeOf({0.001, 0.1, 0.1});
  EXPECT_GT(tissue->cut(blade, placed(0.025, 0.02), 1e6), 0u);
  EXPECT_EQ(piecesOf(*tissue), 1);
  // Twenty times as able where it is low, it cuts all the rest from a part of its own.
  Detection able = blade;
  able.parts.push_back({{Box{Vec3(0.1, 0.1, 0.1)}, {}}, 20});
  EXPECT_GT(tissue->cut(able, placed(0.025, 0.02), 1e6), 0u);
  EXPECT_EQ(piecesOf(*tissue), 2);
}

// A cut halfway down adds twice its area to the surface, and takes no matter away.
TEST(SoftCut, TheSurfaceOpens) {
  TissueWorld world(0);
  const auto tissue = bar(world);
  const auto sums = [&] {
    double area = 0, volume = 0;
    const Mesh mesh = tissue->surface();
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Vec3 &a = mesh.vertices[static_cast<std::size_t>(t[0])],
                 &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                 &c = mesh.vertices[static_cast<std::size_t>(t[2])];
      area += 0.5 * (b - a).cross(c - a).norm();
      volume += a.dot(b.cross(c)) / 6;
    }
    return std::pair(area, volume);
  };
  const auto before = sums();
  EXPECT_NEAR(before.first, 2 * (0.06 * 0.02 + 0.06 * 0.04 + 0.02 * 0.04), 1e-8);
  // From above down to z = 0.015: it meets the links of the nodes at 0.02 and above.
  tissue->cut(bladeOf({0.001, 0.1, 0.05}), placed(0.025, 0.04), 1e9);
  EXPECT_EQ(piecesOf(*tissue), 1);
  const auto after = sums();
  EXPECT_NEAR(after.first - before.first, 2 * 0.02 * 0.025, 1e-8);
  EXPECT_NEAR(after.second, before.second, 1e-6 * before.second);
}

// Stretched and let go, then cut through: no velocity jumps, and the energy falls by what the
// links held.
TEST(SoftCut, EnergyDoesNotGrow) {
  TissueWorld world(0);
  const auto tissue = bar(world);
  tissue->addTo(world.world);
  for (int i = 0; i < tissue->nodes(); ++i) {
    btSoftBody::Node& node = tissue->body().m_nodes[i];
    node.m_v.setValue(btScalar(20 * (node.m_x.x() - 0.03)), 0, 0);
  }
  world.step(0.0005, 3);
  const double energy = energyOf(*tissue), held = tissue->elasticEnergy();
  ASSERT_GT(held, 0.05 * energy);
  tissue->cut(bladeOf({0.001, 0.1, 0.1}), placed(placeOf(*tissue, 2).x() + 0.005, 0.02), 1e9);
  ASSERT_EQ(piecesOf(*tissue), 2);
  EXPECT_LT(tissue->elasticEnergy(), held);
  double last = energyOf(*tissue);
  EXPECT_LT(last, energy);
  for (int k = 0; k < 200; ++k) {
    world.step(0.0005);
    EXPECT_LE(energyOf(*tissue), last * (1 + 10 * kRounding));
    last = energyOf(*tissue);
  }
  double gap = 1, end = 0;  // the halves fly apart
  for (int i = 0; i < tissue->nodes(); ++i)
    (tissue->pieces()[static_cast<std::size_t>(i)] ? gap : end) =
        tissue->pieces()[static_cast<std::size_t>(i)] ? std::min(gap, placeOf(*tissue, i).x())
                                                      : std::max(end, placeOf(*tissue, i).x());
  EXPECT_GT(gap - end, 2 * kCell);
  tissue->leaveWorld();
}

// A driven blade of voxels goes through a block that is held, in a world with a WorldCutter.
TEST(SoftCut, ADrivenBladeCutsInAWorld) {
  TissueWorld world(0);
  const Cloud steel = boxCloud({0.002, 0.06, 0.03}, 0.001).translated({-0.001, -0.03, -0.015});
  CloudShape shape(SurfaceField::build(steel));
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, &shape);
  info.m_startWorldTransform = at({btScalar(0.025), btScalar(0.01), btScalar(0.06)});
  btRigidBody blade(info);
  blade.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  blade.setActivationState(DISABLE_DEACTIVATION);
  world.world.addRigidBody(&blade);
  const auto tissue = bar(world);
  tissue->addTo(world.world);
  for (int i = 0; i < tissue->nodes(); ++i)
    if (placeOf(*tissue, i).z() < 0.001) tissue->body().setMass(i, 0);
  WorldCutter cutter;
  Detection edge;
  edge.area = cloudSolid(steel);
  cutter.addTool(blade, edge, {});
  cutter.addTissue(*tissue);
  double mass = 0;
  for (int i = 0; i < tissue->nodes(); ++i) mass += tissue->matter(i).mass;
  std::size_t links = 0;
  for (int k = 0; k < 400 && piecesOf(*tissue) == 1; ++k) {
    btTransform place = blade.getWorldTransform();
    place.getOrigin().setZ(place.getOrigin().z() - btScalar(0.0002));
    blade.setWorldTransform(place);
    blade.setLinearVelocity({0, 0, btScalar(-0.2)});
    world.step(0.001);
    cutter.after(0.001);
    for (const SoftCut& cut : cutter.softCuts()) links += cut.links;
  }
  EXPECT_EQ(piecesOf(*tissue), 2);
  EXPECT_EQ(links, 15u + 2 * (10 + 12));
  EXPECT_NEAR(mass, 1000 * 0.06 * 0.02 * 0.04, 1e-9);
  world.world.removeRigidBody(&blade);
  tissue->leaveWorld();
}

}  // namespace
}  // namespace cloudcontact::testing::soft_cut_test
