// The haptic loop on surfaces of known stiffness: force, passivity, and forces without jumps.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/haptic_loop.h>
#include <cloudcontact/workpiece/simulated_hand.h>

#include <cmath>
#include <limits>

#include "voxels/small_clouds.h"

namespace cloudcontact::haptic_loop_test {
namespace {

constexpr double kVoxel = 1e-4;                          // [m]
const Vec3 kTop(20 * kVoxel, 20 * kVoxel, 20 * kVoxel);  // center of the slab's surface

// 40 by 40 voxels, solid below z = 20.
Cloud slab(const std::vector<std::string>& materials = {},
           const std::function<int(int, int, int)>& tissue = {}) {
  return test::smallCloud(
      kVoxel, {5, 5, 5},
      [](int x, int y, int z) {
        return x >= 2 && y >= 2 && z >= 2 && x < 38 && y < 38 && z < 20 ? 255 : 0;
      },
      materials, tissue);
}

// A ball bur of 8 voxels' radius.
HapticSettings burSettings(double step = 1e-3) {
  HapticSettings s;
  s.tool.area = {Sphere{8 * kVoxel}};
  s.tool.hardness = false;
  s.step = step;
  return s;
}

constexpr double kAbove = 8 * kVoxel;  // the bur's center, just touching

Pose at(const Vec3& place) {
  return {Eigen::Quaterniond::Identity(), place};
}

// Moves the hand to `place` at 5 mm/s and holds it there.
const HapticOutput& pressTo(HapticLoop& loop, const Vec3& place, double step, double hold = 0.2) {
  const Vec3 start = place + Vec3(0, 0, 2e-3);
  const int moving = static_cast<int>(0.4 / step), holding = static_cast<int>(hold / step);
  const HapticOutput* out = nullptr;
  for (int k = 0; k <= moving + holding; ++k) {
    const bool moves = k < moving;
    const Vec3 hand = moves ? Vec3(start + (place - start) * k / moving) : place;
    out = &loop.tick({at(hand), moves ? Vec3((place - start) / 0.4) : Vec3::Zero()});
  }
  return *out;
}

// Two springs in series, the hand's and the material's: depth and force in closed form.
TEST(HapticLoop, HandAndMaterialAreSpringsInSeries) {
  for (const double k : {500.0, 5e3, 5e4}) {
    BaseVectorField field(slab(), {{"tooth", k, 2e-5 * k, 1e9, 2000}}, sphereWindow(kVoxel));
    HapticLoop loop(field, {}, burSettings());
    const double lead = k < 1000 ? 0.5e-3 : 1e-3;
    const HapticOutput& out = pressTo(loop, kTop + Vec3(0, 0, kAbove - lead), 1e-3);
    const double depth = lead * 1000 / (1000 + k);
    EXPECT_EQ(out.end, EmbeddingEnd::Found);
    EXPECT_NEAR(out.depth, depth, 0.03 * depth + 1e-3 * kVoxel) << k;
    EXPECT_NEAR(out.onHand.force.z(), k * depth, 0.03 * k * depth) << k;
    EXPECT_LT(out.onHand.force.head<2>().norm(), 0.01 * out.onHand.force.z());
    // The displayed tool has the reported depth: a ball's depth in a plane.
    EXPECT_NEAR(kTop.z() + kAbove - out.tool.position.z(), depth, 0.1 * depth + 0.05 * kVoxel);
  }
}

// Pressed and pulled back repeatedly by a simulated hand on very stiff enamel: the hand never gets
// back more energy than it gave.
TEST(HapticLoop, IsPassiveOnTheStiffestTissue) {
  for (const int delay : {0, 1}) {
    BaseVectorField field(slab(), {{"enamel", 1e5, 1, 1e9, 2000}}, sphereWindow(kVoxel));
    HapticLoop loop(field, {}, burSettings());
    HandSettings settings;
    settings.delay = delay;
    SimulatedHand hand(settings, kTop + Vec3(0, 0, kAbove + 1e-3));
    double most = 0, late = 0;
    HapticOutput out;
    for (int k = 0; k < 10000; ++k) {
      out = loop.tick({at(hand.position()), hand.velocity()});
      const double time = 1e-3 * k, swing = std::sin(2 * M_PI * 3 * time);
      hand.advance(kTop + Vec3(1e-3 * std::sin(time), 0, kAbove - 8e-3 * swing), out.onHand.force,
                   1e-3);
      most = std::max(most, out.onHand.force.norm());
      if (k > 9000) late = std::max(late, hand.velocity().norm());
      ASSERT_TRUE(hand.position().allFinite());
    }
    EXPECT_GT(most, 1) << "it did press";
    EXPECT_LT(late, 0.3) << "it does not swing up";
    EXPECT_GE(out.leastEnergy, -1e-6) << "of millijoules; delay " << delay;
    EXPECT_GT(out.energy, 0);
  }
}

// Stroking over a face under a firm force: it changes by less than a twentieth per millisecond.
TEST(HapticLoop, NoForceJumpsWithoutACut) {
  BaseVectorField field(slab(), {{"tooth", 2e4, .4, 1e9, 2000}}, sphereWindow(kVoxel));
  HapticLoop loop(field, {}, burSettings());
  pressTo(loop, kTop + Vec3(-8 * kVoxel, 0, kAbove - 2e-3), 1e-3);
  Vec3 last = loop.tick({at(kTop + Vec3(-8 * kVoxel, 0, kAbove - 2e-3))}).onHand.force;
  double worst = 0;
  for (int k = 0; k < 160; ++k) {  // 1.6 mm at 10 mm/s
    const Vec3 place = kTop + Vec3(-8 * kVoxel + 1e-5 * k, 3e-6 * k, kAbove - 2e-3);
    const Vec3 now = loop.tick({at(place), Vec3(1e-2, 3e-3, 0)}).onHand.force;
    worst = std::max(worst, (now - last).norm() / now.norm());
    last = now;
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_GT(last.norm(), 1);
}

// While cutting, the force falls without a jump, and Archard's volume is removed.
TEST(HapticLoop, CutsByForceSpeedAndHardness) {
  const double h = kVoxel;
  for (const double hardness : {6e8, 2.7e9}) {
    BaseVectorField field(slab(), {{"tooth", 2e4, .4, hardness, 2000}}, sphereWindow(kVoxel));
    const double before = field.mass().volume;
    HapticSettings settings = burSettings();
    settings.cutter = Cutter{17e9, 0.1, 5.0};
    HapticLoop loop(field, {}, settings);
    double work = 0, worst = 0, cut = 0;
    Vec3 last = Vec3::Zero();
    for (int k = 0; k < 400; ++k) {
      const double lead = std::min(1e-5 * k, 1.5e-3);
      const HapticOutput& out = loop.tick({at(kTop + Vec3(0, 0, kAbove - lead))});
      work += 1e-3 * 5 * out.onHand.force.z();
      cut += out.cutVolume;
      const Vec3 now = out.onHand.force;
      if (now.norm() > 0.3) worst = std::max(worst, (now - last).norm() / now.norm());
      last = now;
    }
    EXPECT_NEAR(cut, 0.1 * work / hardness, 0.02 * cut + h * h * h);
    EXPECT_NEAR(before - field.mass().volume, cut, 1e-6 * cut);
    EXPECT_GT(cut, 3 * h * h * h);
    EXPECT_LT(worst, 0.05);
  }
  // Tissue that is too hard for the tool stays.
  BaseVectorField field(slab(), {{"steel", 2e4, .4, 2e10, 2000}}, sphereWindow(kVoxel));
  HapticSettings settings = burSettings();
  settings.cutter = Cutter{17e9, 0.1, 5.0};
  HapticLoop loop(field, {}, settings);
  const std::uint64_t hash = field.hash();
  EXPECT_GT(pressTo(loop, kTop + Vec3(0, 0, kAbove - 1e-3), 1e-3).onHand.force.z(), 0.5);
  EXPECT_EQ(field.hash(), hash);
}

// Each law at rest: Maxwell creeps, the standard linear solid relaxes to its spring, a user's law
// applies as it is.
TEST(HapticLoop, OtherLaws) {
  const double k = 4e3, lead = 1e-3;
  const auto depthOf = [&](const std::optional<Law>& law, bool perTissue, double hold) {
    BaseVectorField field(slab(), {{"flesh", k, 40, 1e9, 1000}}, sphereWindow(kVoxel));
    HapticSettings settings = burSettings();
    settings.law = law;
    settings.perTissue = perTissue;
    HapticLoop loop(field, {}, settings);
    return pressTo(loop, kTop + Vec3(0, 0, kAbove - lead), 1e-3, hold).depth;
  };
  const double series = lead * 1000 / (1000 + k);
  EXPECT_NEAR(depthOf({}, false, 0.5), series, 0.02 * series);
  EXPECT_NEAR(depthOf(StandardLinearSolid{1, 1, 1}, true, 0.5), series, 0.02 * series);
  EXPECT_GT(depthOf(Maxwell{1, 1}, true, 0.03), 1.5 * series) << "it flows";
  const UserLaw hertz{[](double d, double) { return 1e6 * d * std::sqrt(d); }};
  const double d = depthOf(hertz, false, 0.5);
  EXPECT_NEAR(1e6 * d * std::sqrt(d), 1000 * (lead - d), 0.02);
}

// Torque: a contact beside the tool's position turns the tool.
TEST(HapticLoop, TorqueOfATipAside) {
  BaseVectorField field(slab(), {{"tooth", 2e4, .4, 1e9, 2000}}, sphereWindow(kVoxel));
  HapticSettings settings = burSettings();
  const Vec3 aside(5e-3, 0, -2e-3);
  settings.tool.area = {Sphere{8 * kVoxel}, {.position = aside}};
  HapticLoop loop(field, {}, settings);
  const HapticOutput& out = pressTo(loop, kTop + Vec3(0, 0, kAbove - 1e-3) - aside, 1e-3);
  EXPECT_NEAR(out.onHand.torque.y(), -5e-3 * out.onHand.force.z(),
              0.01 * 5e-3 * out.onHand.force.z());
}

TEST(HapticLoop, SameInputSameBits) {
  const auto run = [] {
    BaseVectorField field(slab(), {{"tooth", 2e4, .4, 1e9, 2000}}, sphereWindow(kVoxel));
    HapticSettings settings = burSettings();
    settings.cutter = Cutter{17e9, 0.1, 5.0};
    HapticLoop loop(field, {}, settings);
    const Vec3 force =
        pressTo(loop, kTop + Vec3(1e-4, 2e-4, kAbove - 2e-3), 1e-3, 0.1).onHand.force;
    return std::make_pair(field.hash(), force);
  };
  const auto [hash, force] = run();
  const auto [again, same] = run();
  EXPECT_EQ(hash, again);
  EXPECT_EQ(force, same);
}

TEST(HapticLoop, BadInput) {
  BaseVectorField field(slab(), {{"tooth", 2e4, .4, 1e9, 2000}}, sphereWindow(kVoxel));
  HapticSettings settings = burSettings();
  settings.step = 0;
  EXPECT_THROW(HapticLoop(field, {}, settings), std::invalid_argument);
  settings = burSettings();
  settings.tool.area = {Sphere{-1}};
  EXPECT_THROW(HapticLoop(field, {}, settings), std::invalid_argument);
  HapticLoop loop(field, {}, burSettings());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(loop.tick({at(Vec3(nan, 0, 0))}).onHand.force.norm(), 0);
  EXPECT_GT(pressTo(loop, kTop + Vec3(0, 0, kAbove - 1e-3), 1e-3).onHand.force.z(), 0.5);
  EXPECT_EQ(loop.tick({at(kTop), Vec3(nan, 0, 0)}).onHand.force.norm(), 0);
  EXPECT_THROW(SimulatedHand({0, 1, 1, 0, 1}, Vec3::Zero()), std::invalid_argument);
  EXPECT_THROW(SimulatedHand({1, 1, 1, 99, 1}, Vec3::Zero()), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::haptic_loop_test
