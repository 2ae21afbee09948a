// Support: a body's center inside the convex hull of what bears it, against the hull's width in
// many directions.
#include "bullet/support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace cloudcontact::testing::support_test {
namespace {

struct Foot {
  double x, y, depth = 1e-6;  // [m]
  Vec3 normal = -Vec3::UnitZ();
};

// Of a body at `center` that stands on feet; normals point from it to the ground.
bool holds(const std::vector<Foot>& feet, double inside, double least = 0,
           const Vec3& center = {0.3, -0.2, 0.5}) {
  PairQuery query;
  query.pull[0] = Vec3(0, 0, -9.81);
  query.pull[1] = Vec3::Zero();
  query.a.motion.center = center;
  ContactResult found;
  for (const Foot& foot : feet) {
    ContactPoint point;
    point.position = Vec3(center.x() + foot.x, center.y() + foot.y, 0);
    point.normal = foot.normal;
    point.depth = foot.depth;
    found.points.push_back(point);
  }
  return holdsWeight(query, found, least, inside);
}

// How far inside the hull the center lies: the least, over directions, of the farthest foot.
double insideOf(const std::vector<Foot>& feet) {
  constexpr int kDirections = 20000;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    double most = -std::numeric_limits<double>::infinity();
    for (const Foot& foot : feet)
      most = std::max(most, foot.x * std::cos(angle) + foot.y * std::sin(angle));
    least = std::min(least, most);
  }
  return least;
}

TEST(Support, FeetAroundTheCenterHold) {
  EXPECT_TRUE(holds({{-1, -1}, {1, -1}, {0, 1}}, 0.3));
  EXPECT_FALSE(holds({{-1, 1}, {1, 1}, {0, 2}}, 0));
  EXPECT_FALSE(holds({}, 0));
  EXPECT_FALSE(holds({{0.1, 0.1}}, 0));
}

TEST(Support, ADiagonalHoldsOnItsLineOnly) {
  const std::vector<Foot> table = {{-1, -1}, {1, 1}, {1, -1}};
  EXPECT_TRUE(holds(table, -0.01));
  EXPECT_FALSE(holds(table, 0.01));
  EXPECT_FALSE(holds({{-1, -1}, {1, 1}}, 0.01));
}

TEST(Support, OnlyWhatBearsCounts) {
  std::vector<Foot> feet = {{-1, -1}, {1, -1}, {0, 1}};
  feet[2].depth = -1e-3;
  EXPECT_FALSE(holds(feet, 0));
  EXPECT_TRUE(holds(feet, 0, -2e-3));
  feet[2].depth = 1e-6;
  feet[2].normal = Vec3::UnitX();
  EXPECT_FALSE(holds(feet, 0));
}

TEST(Support, WithoutPullAnythingHolds) {
  PairQuery query;
  query.pull[0] = query.pull[1] = Vec3::Zero();
  EXPECT_TRUE(holdsWeight(query, {}, 0, 1));
}

TEST(Support, IsTheWidthOfTheHull) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1, 1);
  int held = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Foot> feet(static_cast<std::size_t>(3 + trial % 9));
    for (Foot& foot : feet) foot.x = place(random) + 0.2, foot.y = place(random);
    feet.push_back(feet.front());
    const double inside = insideOf(feet);
    if (inside > 0) {
      ++held;
      EXPECT_TRUE(holds(feet, inside - 1e-3)) << trial;
      EXPECT_FALSE(holds(feet, inside + 1e-3)) << trial;
    } else {
      EXPECT_FALSE(holds(feet, 1e-3)) << trial;
    }
  }
  EXPECT_GT(held, 50);
}

}  // namespace
}  // namespace cloudcontact::testing::support_test
