// Soft tissue: stretch of bars against closed forms, mass, momentum and energy, a surface that
// encloses the matter, and input that does not fit.
#include "bullet/soft_world.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cloudcontact::testing::soft_tissue_test {
namespace {

constexpr double kGravity = 9.81, kStep = 0.002;

SoftTissueSettings every(double spacing) {
  SoftTissueSettings settings;
  settings.spacing = spacing;
  return settings;
}

// Nodes at this height at rest.
std::vector<int> layer(const SoftTissue& tissue, double height) {
  std::vector<int> found;
  for (int i = 0; i < tissue.nodes(); ++i)
    if (std::abs(placeOf(tissue, i).z() - height) < 1e-6) found.push_back(i);
  return found;
}

double meanHeight(const SoftTissue& tissue, const std::vector<int>& nodes) {
  double sum = 0;
  for (const int i : nodes) sum += placeOf(tissue, i).z();
  return sum / static_cast<double>(nodes.size());
}

double volumeOf(const Mesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& t : mesh.triangles)
    sum += mesh.vertices[static_cast<std::size_t>(t[0])].dot(
               mesh.vertices[static_cast<std::size_t>(t[1])].cross(
                   mesh.vertices[static_cast<std::size_t>(t[2])])) /
           6;
  return sum;
}

struct Bodies {
  Vec3 momentum = Vec3::Zero(), turn = Vec3::Zero(), center = Vec3::Zero();
  double energy = 0, mass = 0;
};
Bodies sumOf(const SoftTissue& tissue) {
  Bodies sum;
  sum.energy = tissue.elasticEnergy();
  for (int i = 0; i < tissue.nodes(); ++i) {
    const double mass = tissue.matter(i).mass;
    const Vec3 x = placeOf(tissue, i), v = velocityOf(tissue, i);
    sum.mass += mass;
    sum.center += mass * x;
    sum.momentum += mass * v;
    sum.turn += mass * x.cross(v);
    sum.energy += 0.5 * mass * v.squaredNorm();
  }
  sum.center /= sum.mass;
  return sum;
}

// A column that hangs by its top end stretches by density * g * L^2 / (2 E).
TEST(SoftTissue, ColumnStretchesUnderItsWeight) {
  for (const double elasticity : {1e5, 1e7}) {
    TissueWorld world(kGravity);
    const double length = 0.2, wanted = 1000 * kGravity * length * length / (2 * elasticity);
    SoftTissue column(boxCloud({0.02, 0.02, length}, 0.0025), {soft("flesh", elasticity)},
                      at({0, 0, 0}), world.world.getWorldInfo(), every(0.01));
    const auto top = layer(column, length), bottom = layer(column, 0);
    ASSERT_EQ(top.size(), 9u);
    ASSERT_EQ(bottom.size(), 9u);
    for (const int i : top) column.body().setMass(i, 0);
    column.addTo(world.world);
    world.step(kStep, 700);
    const double stretch = -meanHeight(column, bottom);
    // At 1e7 Pa it is 20 micrometers, of which float knows a tenth of a percent.
    EXPECT_NEAR(stretch / wanted, 1, 0.02);
    EXPECT_LT(column.missed(), 1e-7);
  }
}

// F (L1 / E1 + L2 / E2) / A, with the seam on a layer of nodes and between two.
TEST(SoftTissue, TwoTissuesStretchInSeries) {
  for (const double seam : {0.1, 0.125}) {
    TissueWorld world(0);
    const double length = 0.2, width = 0.02, force = 0.04, lower = 5e4, upper = 2e5;
    SoftTissue bar(layeredCloud({width, width, length}, 0.0025, seam),
                   {soft("lower", lower), soft("upper", upper)}, at({0, 0, 0}),
                   world.world.getWorldInfo(), every(0.01));
    const auto top = layer(bar, length), bottom = layer(bar, 0);
    const std::vector<int> low[2] = {layer(bar, 0.03), layer(bar, 0.07)},
                           high[2] = {layer(bar, 0.14), layer(bar, 0.18)};
    for (const int i : top) bar.body().setMass(i, 0);
    bar.addTo(world.world);
    for (int k = 0; k < 700; ++k) {
      // On the bottom face by its nodes' areas: corners a quarter, edges a half.
      for (const int i : bottom) {
        const Vec3 x = placeOf(bar, i);
        const auto inner = [&](double u) { return std::abs(u - 0.01) < 0.005 ? 0.5 : 0.25; };
        bar.body().addForce({0, 0, btScalar(-force * inner(x.x()) * inner(x.y()))}, i);
      }
      world.step(kStep);
    }
    const double wanted = force / (width * width) * (seam / lower + (length - seam) / upper);
    const double stretch = -meanHeight(bar, bottom);
    // The seam and the held end keep the tissue from growing thinner, as they would a solid.
    EXPECT_NEAR(stretch / wanted, 1, 0.03);
    const auto strainOf = [&](const std::vector<int>& a, const std::vector<int>& b) {
      return (meanHeight(bar, b) - meanHeight(bar, a)) / 0.04 - 1;
    };
    EXPECT_NEAR(strainOf(low[0], low[1]), force / (width * width) / lower, 5e-3 * wanted / length);
    EXPECT_NEAR(strainOf(high[0], high[1]), force / (width * width) / upper,
                5e-3 * wanted / length);
    // It grows thinner by Poisson's ratio of 1/4.
    const auto inLower = [&](int i) { return std::abs(placeOf(bar, i).z() - 0.05) < 0.006; };
    double left = 1, right = 0;
    for (int i = 0; i < bar.nodes(); ++i)
      if (inLower(i)) {
        left = std::min(left, placeOf(bar, i).x());
        right = std::max(right, placeOf(bar, i).x());
      }
    EXPECT_NEAR((width - (right - left)) / width, 0.25 * force / (width * width) / lower, 2e-5);
  }
}

// The link across a seam in its middle stretches by both halves: F (l / E1 + l / E2) / (2 A). Had
// it the mean of both moduli, that would be a fifth.
TEST(SoftTissue, ALinkAcrossASeamIsInSeries) {
  TissueWorld world(0);
  const double width = 0.02, force = 0.04, lower = 2e4, upper = 4e5;
  SoftTissue bar(layeredCloud({width, width, 0.2}, 0.0025, 0.09),
                 {soft("lower", lower), soft("upper", upper)}, at({0, 0, 0}),
                 world.world.getWorldInfo(), every(0.02));
  const auto below = layer(bar, 0.08), above = layer(bar, 0.1), bottom = layer(bar, 0);
  ASSERT_EQ(bottom.size(), 4u);
  for (const int i : layer(bar, 0.2)) bar.body().setMass(i, 0);
  bar.addTo(world.world);
  for (int k = 0; k < 1000; ++k) {
    for (const int i : bottom) bar.body().addForce({0, 0, btScalar(-force / 4)}, i);
    world.step(kStep);
  }
  const double stretch = meanHeight(bar, above) - meanHeight(bar, below) - 0.02;
  const double wanted = force / (width * width) * (0.01 / lower + 0.01 / upper);
  EXPECT_NEAR(stretch / wanted, 1, 0.15);
}

// A plate of 40 x 24 x 3 mm has cells of about 3 mm, though 8 were asked for, and the modulus that
// it should: its end, pulled, moves by F L / (E A).
TEST(SoftTissue, ThinMatterHasSmallCells) {
  TissueWorld world(0);
  const double force = 0.01, modulus = 5e4;
  SoftTissue plate(boxCloud({0.024, 0.003, 0.04}, 0.001), {soft("flesh", modulus)}, at({0, 0, 0}),
                   world.world.getWorldInfo(), every(0.008));
  const auto bottom = layer(plate, 0), top = layer(plate, 0.04);
  EXPECT_GT(bottom.size(), 2u * 6);
  for (const int i : top) plate.body().setMass(i, 0);
  plate.addTo(world.world);
  for (int k = 0; k < 1000; ++k) {
    double all = 0;
    for (const int i : bottom) all += plate.matter(i).mass;
    for (const int i : bottom)
      plate.body().addForce({0, 0, btScalar(-force * plate.matter(i).mass / all)}, i);
    world.step(kStep);
  }
  const double wanted = force * 0.04 / (modulus * 0.024 * 0.003);
  EXPECT_NEAR(-meanHeight(plate, bottom) / wanted, 1, 0.05);
}

TEST(SoftTissue, HasTheMassOfItsMatter) {
  TissueWorld world(0);
  DigitizeSettings settings;
  settings.voxelSize = 0.002;
  const Cloud ball = digitize(sphereMesh(0.03, 1e-5), settings);
  SoftTissue tissue(ball, {soft("flesh", 1e5, 1100)}, at({0.1, 0, 0}), world.world.getWorldInfo(),
                    every(0.008));
  const Bodies sum = sumOf(tissue);
  const MassProperties exact = ball.massProperties();
  EXPECT_NEAR(sum.mass, 1100 * exact.mass, 1e-9 * sum.mass);
  EXPECT_LT((sum.center - Vec3(0.1, 0, 0)).norm(), 1e-5);
  EXPECT_NEAR(double(tissue.body().getTotalMass()), sum.mass, 1e-5 * sum.mass);
  // Nodes of the surface lie on the ball.
  double farthest = 0;
  for (int i = 0; i < tissue.nodes(); ++i)
    farthest = std::max(farthest, (placeOf(tissue, i) - Vec3(0.1, 0, 0)).norm());
  EXPECT_NEAR(farthest, 0.03, 0.0005);
  EXPECT_NEAR(volumeOf(tissue.surface()), exact.volume, 0.1 * exact.volume);
  SoftTissue layered(layeredCloud({0.02, 0.02, 0.04}, 0.0025, 0.01),
                     {soft("lower", 1e5, 2000), soft("upper", 1e5, 800)}, at({0, 0, 0}),
                     world.world.getWorldInfo(), every(0.01));
  EXPECT_NEAR(sumOf(layered).mass, 4e-4 * (0.01 * 2000 + 0.03 * 800), 1e-9);
  EXPECT_NEAR(volumeOf(layered.surface()), 4e-4 * 0.04, 1e-10);
}

// A free bar, stretched and spinning: forces within it move nothing outside, and its energy falls.
TEST(SoftTissue, FreeBodyKeepsItsMomentum) {
  TissueWorld world(0);
  SoftTissue bar(boxCloud({0.02, 0.02, 0.06}, 0.0025), {soft("flesh", 1e5)}, at({0, 0, 0}),
                 world.world.getWorldInfo(), every(0.01));
  bar.addTo(world.world);
  for (int i = 0; i < bar.nodes(); ++i) {
    btSoftBody::Node& node = bar.body().m_nodes[i];
    node.m_v = {btScalar(0.1 + 5 * node.m_x.z()), btScalar(0.2), btScalar(3 * node.m_x.z())};
  }
  const Bodies before = sumOf(bar);
  double energy = before.energy;
  for (int k = 0; k < 500; ++k) {
    world.step(0.0005);
    const Bodies now = sumOf(bar);
    EXPECT_LE(now.energy, energy * (1 + 10 * kRounding));
    energy = now.energy;
  }
  const Bodies after = sumOf(bar);
  EXPECT_LT((after.momentum - before.momentum).norm(),
            (sizeof(btScalar) == 4 ? 2e-3 : 1e-9) * before.momentum.norm());
  EXPECT_NEAR(after.turn.norm() / before.turn.norm(), 1, 0.01);
  EXPECT_LT(after.energy, 0.98 * before.energy);  // the vibration is gone, the flight is left
}

TEST(SoftTissue, RunsAreTheSame) {
  const auto run = [] {
    TissueWorld world(kGravity);
    SoftTissue bar(boxCloud({0.02, 0.02, 0.06}, 0.0025), {soft("flesh", 1e4)}, at({0, 0, 0}),
                   world.world.getWorldInfo(), every(0.01));
    bar.body().setMass(0, 0);
    bar.addTo(world.world);
    world.step(kStep, 100);
    return placeOf(bar, bar.nodes() - 1);
  };
  EXPECT_EQ(run(), run());
}

TEST(SoftTissue, RefusesWhatDoesNotFit) {
  TissueWorld world(0);
  const Cloud cloud = boxCloud({0.02, 0.02, 0.02}, 0.0025);
  const auto message = [&](const TissueTable& tissues, double spacing) -> std::string {
    try {
      SoftTissue(cloud, tissues, at({0, 0, 0}), world.world.getWorldInfo(), every(spacing));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({soft("flesh", 1e4)}, 0.01), "");
  EXPECT_NE(message({soft("flesh", 0)}, 0.01).find("flesh: soft tissue needs its elasticity"),
            std::string::npos);
  EXPECT_NE(message({soft("flesh", -1)}, 0.01).find("elasticity"), std::string::npos);
  EXPECT_NE(message({soft("flesh", 1e4)}, 0).find("spacing"), std::string::npos);
  EXPECT_NE(message({soft("flesh", 1e4)}, 0.001).find("spacing"), std::string::npos);
  EXPECT_NE(message({soft("a", 1e4), soft("b", 1e4)}, 0.01).find("one tissue for each"),
            std::string::npos);
}

}  // namespace
}  // namespace cloudcontact::testing::soft_tissue_test
