// The haptic loop between walls, and where the material that held the tool is gone.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/haptic_loop.h>

#include <algorithm>
#include <cmath>

#include "voxels/small_clouds.h"

namespace cloudcontact::haptic_calm_test {
namespace {

constexpr double kVoxel = 1e-4;  // [m]
constexpr double kRadius = 6 * kVoxel;
const TissueTable kTooth = {{"tooth", 2e4, .4, 1e9, 2000}};

// A block with a round-bottomed groove along x, as wide as the bur that made it.
Cloud groove() {
  return test::smallCloud(kVoxel, {6, 5, 4}, [](int x, int y, int z) {
    if (x < 2 || y < 2 || z < 2 || x >= 46 || y >= 38 || z >= 26) return 0;
    const double r = std::hypot(y + 0.5 - 20, std::min(z + 0.5 - 16, 0.0));
    return static_cast<int>(std::lround(255 * std::clamp(r - 6 + 0.5, 0.0, 1.0)));
  });
}

HapticSettings burSettings() {
  HapticSettings s;
  s.tool.area = {Sphere{kRadius}};
  s.handStiffness = 5000;
  s.handDamping = 2.5;
  return s;
}

HapticInput at(const Vec3& place, const Vec3& velocity = Vec3::Zero()) {
  return {{Eigen::Quaterniond::Identity(), place}, velocity};
}

// A bur drawn through a groove of its own width, pressed down and a little against a wall, touches
// the floor and both walls. Its force is steady; without calm() it swung from wall to wall each
// tick, by 1.9 times its magnitude.
TEST(HapticCalm, NoForceSwingsBetweenWalls) {
  BaseVectorField field(groove(), kTooth, sphereWindow(kVoxel));
  HapticLoop loop(field, {}, burSettings());
  const Vec3 start(12 * kVoxel, 20 * kVoxel, 16 * kVoxel);
  double worst = 0, down = 0;
  Vec3 last = Vec3::Zero();
  for (int k = 0; k < 1600; ++k) {
    const double press = 2e-4 * std::min(1.0, k / 400.0), along = k < 600 ? 0 : 2e-6 * (k - 600);
    const Vec3 hand = start + Vec3(along, 0.1 * press, -press);
    const Vec3 force = loop.tick(at(hand, Vec3(k < 600 ? 0 : 2e-3, 0, 0))).onHand.force;
    if (k > 600) {
      worst = std::max(worst, (force - last).norm() / force.norm());
      down += force.z() / 999;
    }
    last = force;
  }
  EXPECT_LT(worst, 0.05);
  // Springs in series, the hand's 0.2 mm ahead.
  EXPECT_NEAR(down, 2e-4 / (1 / 5000.0 + 1 / 2e4), 0.15);
}

// The material that held the tool is gone from one tick to the next: the force fades by the set
// rate, and its work is at most the energy of the spring.
TEST(HapticCalm, ForceFadesWhereMatterIsGone) {
  for (const double release : {0.02, 0.005, 0.0}) {
    BaseVectorField field(
        test::smallCloud(kVoxel, {5, 5, 4},
                         [](int x, int y, int z) {
                           return x >= 2 && y >= 2 && z >= 2 && x < 38 && y < 38 && z < 20 ? 255
                                                                                           : 0;
                         }),
        kTooth, sphereWindow(kVoxel));
    HapticSettings settings = burSettings();
    settings.release = release;
    HapticLoop loop(field, {}, settings);
    const Vec3 hand(20 * kVoxel, 20 * kVoxel, 26 * kVoxel - 3e-4);
    for (int k = 0; k <= 300; ++k)
      loop.tick(at(hand + Vec3(0, 0, 3e-4 * (1 - std::min(1.0, k / 200.0)))));
    double before = loop.tick(at(hand)).onHand.force.z();
    ASSERT_GT(before, 1);
    std::vector<VoxelCut> all;
    for (int z = 2; z < 20; ++z)
      for (int y = 2; y < 38; ++y)
        for (int x = 2; x < 38; ++x) all.push_back({{x, y, z}, 0});
    field.cut(all);
    for (int k = 0; k < 20; ++k) {
      const double now = loop.tick(at(hand)).onHand.force.z();
      const double fades = release > 0 ? std::exp(-1e-3 / release) : 0;
      EXPECT_NEAR(now, fades * before, 1e-6 * before + 1e-4) << k;
      before = now;
    }
  }
}

// A hand that leaves a surface is not held back: there is no force once the hand is out.
TEST(HapticCalm, NothingHoldsAHandThatLeaves) {
  BaseVectorField field(groove(), kTooth, sphereWindow(kVoxel));
  HapticLoop loop(field, {}, burSettings());
  const Vec3 deep(20 * kVoxel, 20 * kVoxel, 16 * kVoxel - 2e-4);
  HapticOutput out;
  for (int k = 0; k <= 400; ++k)
    out = loop.tick(at(deep + Vec3(0, 0, 2e-4 * (1 - std::min(1.0, k / 200.0)))));
  ASSERT_GT(out.onHand.force.z(), 0.5);
  for (int k = 0; k < 100; ++k) {  // out at 50 mm/s
    out = loop.tick(at(deep + Vec3(0, 0, 5e-5 * k), Vec3(0, 0, 0.05)));
    EXPECT_GE(out.onHand.force.z(), -0.3) << k;  // of the damper, while in contact
    if (k > 30) {
      EXPECT_EQ(out.onHand.force.norm(), 0) << k;
    }
  }
  EXPECT_GE(out.leastEnergy, -1e-6);
  HapticSettings settings = burSettings();
  settings.release = -1;
  EXPECT_THROW(HapticLoop(field, {}, settings), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::haptic_calm_test
