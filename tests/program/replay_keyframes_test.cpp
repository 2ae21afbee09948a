// Keys of a motion: closed forms, and the bound on the deviation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "replay/keyframes.h"

namespace cloudcontact::program::replay_keyframes_test {
namespace {

Pose turned(double angle, const Vec3& axis, const Vec3& place) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), place};
}

// The pose that the keys give.
Pose shown(const std::vector<PoseKey>& keys, double time) {
  std::size_t i = 0;
  while (i + 2 < keys.size() && keys[i + 1].time < time) ++i;
  return keys.size() < 2 ? keys[0].pose : between(keys[i], keys[i + 1], time);
}

// Largest error of eight corners at distance `reach`.
double furthest(const Pose& a, const Pose& b, double reach) {
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 arm = reach / std::sqrt(3.0) *
                     Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    most = std::max(most, (a.toWorld(arm) - b.toWorld(arm)).norm());
  }
  return most;
}

TEST(Keyframes, OneForABodyAtRest) {
  Keyframes keyframes(1, 1e-6);
  for (int i = 0; i < 1000; ++i) keyframes.add(0.01 * i, turned(0.3, Vec3(1, 2, 3), Vec3(1, 0, 0)));
  keyframes.finish();
  EXPECT_EQ(keyframes.keys().size(), 1u);
}

// At rest, in motion, at rest again: a key at each change.
TEST(Keyframes, AreFewHoweverLongABodyRests) {
  Keyframes keyframes(1, 1e-6);
  const auto at = [](double t) { return std::clamp(t - 100, 0.0, 1.0); };
  for (int i = 0; i <= 20000; ++i)
    keyframes.add(0.01 * i, turned(0.2, Vec3(0, 1, 0), Vec3(at(0.01 * i), 0, 0)));
  keyframes.finish();
  EXPECT_LE(keyframes.keys().size(), 8u);
  EXPECT_DOUBLE_EQ(keyframes.keys().back().time, 200);
  for (double t = 0; t < 200; t += 0.37)
    EXPECT_NEAR(shown(keyframes.keys(), t).position.x(), at(t), 2e-6) << t;
}

TEST(Keyframes, TwoForAStraightLineAndAnEvenTurn) {
  Keyframes keyframes(1, 1e-9);
  for (int i = 0; i <= 100; ++i)
    keyframes.add(0.01 * i, turned(0.02 * i, Vec3(1, 1, 0), Vec3(0.5 * i, 0, -i)));
  keyframes.finish();
  ASSERT_EQ(keyframes.keys().size(), 2u);
  EXPECT_DOUBLE_EQ(keyframes.keys().back().time, 1.0);
}

// A chord of duration T over a parabola with acceleration g has an error of g T^2 / 8, so free fall
// for a second needs at least sqrt(g / (8 tolerance)) keys; up to twice as many are allowed.
TEST(Keyframes, AsManyForFreeFallAsAParabolaTakes) {
  constexpr double g = 9.8, tolerance = 1e-4;
  Keyframes keyframes(1, tolerance);
  for (int i = 0; i <= 240; ++i)
    keyframes.add(i / 240.0, turned(0, Vec3::UnitX(), Vec3(0, 0, -g / 2 * std::pow(i / 240.0, 2))));
  keyframes.finish();
  const double least = std::sqrt(g / (8 * tolerance));
  EXPECT_GE(double(keyframes.keys().size()), least);
  EXPECT_LE(double(keyframes.keys().size()), 2 * least + 2);
}

// A turn by more than half a circle between keys would be shown the short way. Every step is known,
// so this never occurs, whichever of its two quaternions a step has.
TEST(Keyframes, NothingStraysOnAWildMotion) {
  for (const double tolerance : {1e-2, 1e-4}) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> push(-1, 1);
    constexpr double reach = 0.3;
    Keyframes keyframes(reach, tolerance);
    std::vector<PoseKey> truth;
    Pose pose;
    Vec3 speed = Vec3::Zero(), spin = Vec3::Zero();
    for (int i = 0; i < 3000; ++i) {
      for (int k = 0; k < 3; ++k) speed[k] += 0.02 * push(random), spin[k] += 0.1 * push(random);
      pose.position += 0.002 * speed;
      const Vec3 turn = 0.002 * spin;
      pose.orientation =
          Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * pose.orientation;
      if (i % 3 == 0) pose.orientation.coeffs() *= -1;
      pose.orientation.normalize();
      keyframes.add(0.002 * i, pose);
      truth.push_back({0.002 * i, pose});
    }
    keyframes.finish();
    EXPECT_LT(keyframes.keys().size(), truth.size() / 2);
    EXPECT_EQ(keyframes.keys().back().time, truth.back().time);
    for (const PoseKey& seen : truth)
      EXPECT_LE(furthest(shown(keyframes.keys(), seen.time), seen.pose, reach), tolerance);
  }
}

}  // namespace
}  // namespace cloudcontact::program::replay_keyframes_test
