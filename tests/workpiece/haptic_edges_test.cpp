// The haptic loop and the finder at the edges of the method: hardness 0, a representative point off
// center, voxels from elsewhere, a force without the division of (6), an index of the user's own.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/haptic_loop.h>

#include <cmath>

#include "voxels/small_clouds.h"

namespace cloudcontact::haptic_edges_test {
namespace {

constexpr double kVoxel = 1e-4;  // [m]
const Vec3 kTop(20 * kVoxel, 20 * kVoxel, 20 * kVoxel);
constexpr double kAbove = 8 * kVoxel;  // the bur's center, just touching

Cloud slab() {
  return test::smallCloud(kVoxel, {5, 5, 5}, [](int x, int y, int z) {
    return x >= 2 && y >= 2 && z >= 2 && x < 38 && y < 38 && z < 20 ? 255 : 0;
  });
}

HapticSettings burSettings() {
  HapticSettings s;
  s.tool.area = {Sphere{8 * kVoxel}};
  return s;
}

Pose at(const Vec3& place) {
  return {Eigen::Quaterniond::Identity(), place};
}

// Down to `lead` below the touch, and held there.
HapticOutput press(HapticLoop& loop, double lead) {
  HapticOutput out;
  for (int k = 0; k <= 700; ++k)
    out = loop.tick(
        {at(kTop + Vec3(0, 0, kAbove + 2e-4 - (lead + 2e-4) * std::min(1.0, k / 400.0)))});
  return out;
}

// Material that offers no resistance to cutting, and a part of the tool that does not cut, push
// back like any other: the hand's spring and the material's in series.
TEST(HapticEdges, WithoutHardnessOrAbilityTheForceIsTheSame) {
  for (const bool cuts : {false, true}) {
    BaseVectorField field(slab(), {{"gel", 1e3, 0.02, cuts ? 0.0 : 1e9, 1000}},
                          sphereWindow(kVoxel));
    HapticSettings settings = burSettings();
    settings.tool.ability = cuts ? 1 : 0;
    HapticLoop loop(field, {}, settings);
    const HapticOutput out = press(loop, 6e-4);
    EXPECT_EQ(out.end, EmbeddingEnd::Found);
    EXPECT_NEAR(out.depth, 3e-4, 0.03 * 3e-4);
    EXPECT_NEAR(out.onHand.force.z(), 0.3, 0.01);
  }
}

// The first tissue that has a hardness is the unit of h.
TEST(HapticEdges, FirstTissueWithoutHardness) {
  const Cloud cloud = test::smallCloud(
      kVoxel, {5, 5, 5}, [](int, int, int z) { return z < 20 ? 255 : 0; }, {"pulp", "enamel"},
      [](int x, int, int) { return x < 20 ? 0 : 1; });
  const BaseVectorField field(cloud, {{"pulp", 1e3, 0, 0, 1000}, {"enamel", 1e4, 0, 3e9, 1000}},
                              sphereWindow(kVoxel));
  CollisionFinder finder;
  Detection d = burSettings().tool;
  const Pose right = at(kTop + Vec3(1e-3, 0, kAbove - 2e-4));
  const Vec3 hard = finder.find(field, {}, d, right).mean;
  d.hardness = false;
  EXPECT_NEAR((finder.find(field, {}, d, right).mean - hard).norm(), 0, 1e-12) << "h is 1";
}

// Each given voxel counts as one, however deep it is in D and however full.
TEST(HapticEdges, GatheredVoxelsCountAsOne) {
  const Cloud cloud = test::smallCloud(kVoxel, {2, 2, 2}, [](int, int, int z) {
    return z < 8 ? 255 : z == 8 ? 102 : 0;
  });
  const BaseVectorField field(cloud, {{"tooth", 1e3, 0, 1e9, 1000}}, sphereWindow(kVoxel));
  const std::vector<VoxelIndex> voxels = {{4, 4, 7}, {4, 4, 8}, {5, 4, 8}};
  CollisionFinder finder;
  for (const Membership m : {Membership::Whole, Membership::Shared}) {
    Detection d = burSettings().tool;
    d.membership = m;
    const Collision& c = finder.gather(field, {}, d, at(kVoxel * Vec3(4, 4, 16)), voxels);
    EXPECT_EQ(c.count, 3);
    EXPECT_EQ(c.tissueCount[0], 3);
    EXPECT_NEAR(c.volume, 1.8 * kVoxel * kVoxel * kVoxel, 1e-18) << "of their matter";
  }
}

// (6) without the division: in equilibrium the hand feels k d |F|, F in voxels.
TEST(HapticEdges, UnscaledForceInTheLoop) {
  BaseVectorField field(slab(), {{"flesh", 4e3, 0.08, 1e9, 1000}}, sphereWindow(kVoxel));
  HapticSettings settings = burSettings();
  settings.direction = Direction::Unscaled;
  HapticLoop loop(field, {}, settings);
  const HapticOutput out = press(loop, 3e-4);
  const double length = loop.collision().mean.norm() / kVoxel;
  EXPECT_LT(length, 0.8) << "it makes a difference";
  EXPECT_NEAR(out.onHand.force.z(), 4e3 * out.depth * length, 0.02 * out.onHand.force.z());
  EXPECT_NEAR((loop.reaction().onTool.force - out.onHand.force).norm(), 0, 1e-3);
  EXPECT_NEAR(loop.reaction().magnitude, 4e3 * out.depth, 0.02 * 4e3 * out.depth);
}

// A representative point off center pushes sideways, whatever the hand does: strokes along that
// push would give energy. The watch holds the total at zero, and acts on no loop that is passive.
TEST(HapticEdges, PointOffCenterGivesNoEnergy) {
  for (const double off : {0.0, 0.3}) {
    WindowSettings window = sphereWindow(kVoxel);
    window.representative = Vec3(off * kVoxel, 0, 0);
    BaseVectorField field(slab(), {{"tooth", 2e4, 0.4, 1e9, 2000}}, window);
    HapticLoop loop(field, {}, burSettings());
    double withheld = 0, given = 0;
    HapticOutput out;
    Vec3 last = kTop + Vec3(-1e-3, 0, kAbove);
    for (int k = 0; k < 3 * 1200; ++k) {
      // Down, along x, up, and back above the surface.
      const double t = k % 1200 / 300.0, part = t - std::floor(t);
      const double x = t < 1 ? 0 : t < 2 ? part : t < 3 ? 1 : 1 - part;
      const double down = t < 1 ? part : t < 2 ? 1 : t < 3 ? 1 - part : 0;
      const Vec3 hand = kTop + Vec3(-1e-3 + 2e-3 * x, 0, kAbove + 2e-4 - 1.2e-3 * down);
      given += out.onHand.force.dot(hand - last);
      out = loop.tick({at(hand), (hand - last) / 1e-3});
      EXPECT_NEAR(-out.energy, given, 1e-9);
      last = hand;
      withheld = std::max(withheld, out.withheld);
    }
    EXPECT_GE(out.leastEnergy, -5e-6) << "of a millijoule, off by " << off;
    if (off == 0) {
      EXPECT_LT(withheld, 1e-9);
    } else {
      EXPECT_GT(withheld, 0.01) << "the watch acts";
    }
  }
}

// Paper, Step 3: the index may depend on hardness, cutting ability, speed and acceleration.
TEST(HapticEdges, IndexOfTheUsersOwn) {
  for (const double hardness : {1e9, 3e9}) {
    BaseVectorField field(slab(), {{"flesh", 500, 0, hardness, 1000}}, sphereWindow(kVoxel));
    HapticSettings settings = burSettings();
    settings.tool.ability = 0.5;
    double fastest = 0, acceleration = 0;
    settings.index = [&](const Interaction& now) {
      fastest = std::max(fastest, std::abs(now.speed));
      acceleration = std::max(acceleration, std::abs(now.acceleration));
      return now.stiffness * now.hardness / 1e9 * now.depth / now.ability + now.speed;
    };
    HapticLoop loop(field, {}, settings);
    const HapticOutput out = press(loop, 4e-4);
    const double k = 500 * hardness / 1e9 / 0.5;
    EXPECT_NEAR(out.depth, 4e-4 * 1000 / (1000 + k), 0.03 * out.depth);
    EXPECT_GT(fastest, 0);
    EXPECT_GT(acceleration, 0);
  }
}

// The table is filled once, and later ticks need a few evaluations of the law.
TEST(HapticEdges, TableIsKeptBetweenTicks) {
  BaseVectorField field(slab(), {{"flesh", 1e3, 0.02, 1e9, 1000}}, sphereWindow(kVoxel));
  HapticSettings settings = burSettings();
  settings.embedding.search = Search::Table;
  int calls = 0;
  settings.law = UserLaw{[&](double d, double) {
    ++calls;
    return 1e6 * d * std::sqrt(d);
  }};
  HapticLoop loop(field, {}, settings);
  int filled = 0, most = 0;
  HapticOutput out;
  for (int k = 0; k < 600; ++k) {
    const double lead = 3e-4 * std::min(1.0, k / 300.0);
    const int before = calls;
    out = loop.tick({at(kTop + Vec3(0, 0, kAbove - lead))});
    EXPECT_GE(out.iterations, calls - before - 1) << "all calls of the search are counted";
    filled += out.iterations >= 64;
    if (out.iterations < 64) most = std::max(most, out.iterations);
  }
  EXPECT_LT(filled, 12);
  EXPECT_LT(most, 20);
  EXPECT_NEAR(1e6 * out.depth * std::sqrt(out.depth), 1000 * (3e-4 - out.depth), 1e-3);
}

}  // namespace
}  // namespace cloudcontact::haptic_edges_test
