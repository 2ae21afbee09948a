// Depth and normal of solids given by a formula: against closed forms, against dense samples of
// their surfaces, and against the inequality that holds only for the nearest point of a convex
// body.
#include <cloudcontact/law/solid.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "contact/contact_cases.h"

namespace cloudcontact::solid_test {
namespace {

constexpr double kPi = std::numbers::pi;

using testing::boxAsHull;

// The hull of points on an ellipsoid, its planes found by trying all triples.
Hull randomHull(unsigned seed, int count) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Hull hull;
  for (int i = 0; i < count; ++i) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    hull.corners.push_back(direction.cwiseProduct(Vec3(2, 1, 0.5)) + Vec3(0.3, -0.2, 0.1));
  }
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j)
      for (int k = j + 1; k < count; ++k) {
        const Vec3& a = hull.corners[i];
        Vec3 n = (hull.corners[j] - a).cross(hull.corners[k] - a).normalized();
        double most = 0, least = 0;
        for (const Vec3& c : hull.corners) {
          most = std::max(most, n.dot(c - a));
          least = std::min(least, n.dot(c - a));
        }
        if (least > -1e-12) n = -n;
        if (least > -1e-12 || most < 1e-12) hull.planes.push_back({n, n.dot(a)});
      }
  return hull;
}

struct ClosedForm {
  std::string name;
  Solid shape;
  Vec3 at;
  double depth;
  Vec3 normal;
};

std::vector<ClosedForm> closedForms() {
  const double r2 = std::sqrt(0.5);
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const Vec3 slope = Vec3(2, 0, 1).normalized();  // of the cone with radius 1, height 2
  return {
      {"half-space below", HalfSpace{z, 1}, {5, 6, 0.25}, 0.75, z},
      {"half-space above", HalfSpace{z, 1}, {5, 6, 3}, -2, z},
      {"sphere inside", Sphere{2}, {0, 0.5, 0}, 1.5, y},
      {"sphere outside", Sphere{2}, {0, 0, -5}, -3, -z},
      {"sphere's center", Sphere{2}, {0, 0, 0}, 2, z},
      {"box inside", Box{{1, 2, 3}}, {0.9, 0, 0}, 0.1, x},
      {"box face", Box{{1, 2, 3}}, {0.5, -4, 1}, -2, -y},
      {"box edge", Box{{1, 2, 3}}, {4, 6, 0}, -5, {0.6, 0.8, 0}},
      {"box corner", Box{{1, 2, 3}}, {3, 4, -4}, -3, {2. / 3, 2. / 3, -1. / 3}},
      {"capsule side", Capsule{1, 2}, {3, 0, 1.5}, -2, x},
      {"capsule cap", Capsule{1, 2}, {3, 0, 6}, -4, {0.6, 0, 0.8}},
      {"cylinder inside, near side", Cylinder{1, 2}, {0, 0.8, 0}, 0.2, y},
      {"cylinder inside, near end", Cylinder{1, 2}, {0, 0.2, -1.9}, 0.1, -z},
      {"cylinder rim", Cylinder{1, 2}, {4, 0, 6}, -5, {0.6, 0, 0.8}},
      {"cone inside, near base", Cone{1, 1}, {0.1, 0, -0.9}, 0.1, -z},
      {"cone beside its slope", Cone{1, 1}, Vec3(0.5, 0, 0) + 0.3 * slope, -0.3, slope},
      {"cone over its tip", Cone{1, 1}, {0, 0, 2}, -1, z},
      {"cone beside its rim", Cone{1, 1}, {1 + r2, 0, -1 - r2}, -1, {r2, 0, -r2}},
      {"rounded cone over its tip", Cone{1, 1, 0.25}, {0, 0, 2}, -0.75, z},
      {"hull face", boxAsHull({1, 1, 1}), {0.2, 0.1, 3}, -2, z},
  };
}

TEST(Solid, ClosedForms) {
  for (const ClosedForm& c : closedForms()) {
    const SolidPoint point = solidAt(c.shape, c.at);
    EXPECT_NEAR(point.depth, c.depth, 1e-12) << c.name;
    EXPECT_NEAR((point.normal - c.normal).norm(), 0, 1e-12)
        << c.name << ", normal is " << point.normal.transpose();
  }
}

// Points all over a surface, with neighbors at most `spacing` apart.
std::vector<Vec3> revolved(const std::vector<Eigen::Vector2d>& profile, double spacing) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const Eigen::Vector2d along = profile[i + 1] - profile[i];
    const int steps = static_cast<int>(std::ceil(along.norm() / spacing));
    for (int s = 0; s <= steps; ++s) {
      const Eigen::Vector2d p = profile[i] + along * s / steps;
      const int turns = static_cast<int>(std::ceil(2 * kPi * p.x() / spacing)) + 1;
      for (int t = 0; t < turns; ++t)
        points.emplace_back(p.x() * std::cos(2 * kPi * t / turns),
                            p.x() * std::sin(2 * kPi * t / turns), p.y());
    }
  }
  return points;
}

struct Sampled {
  std::string name;
  Solid shape;
  std::vector<Vec3> surface;
};

std::vector<Sampled> sampledShapes(double spacing) {
  std::vector<Eigen::Vector2d> capsule, ball;
  for (int i = 0; i <= 100; ++i) {
    const double a = kPi * i / 100;
    ball.emplace_back(0.7 * std::sin(a), -0.7 * std::cos(a));
    capsule.emplace_back(0.4 * std::sin(a), -0.4 * std::cos(a) + (i > 50 ? 0.6 : -0.6));
    if (i == 50) capsule.emplace_back(0.4, 0.6);
  }
  return {{"sphere", Sphere{0.7}, revolved(ball, spacing)},
          {"capsule", Capsule{0.4, 0.6}, revolved(capsule, spacing)},
          {"cylinder", Cylinder{0.5, 0.8},
           revolved({{0, -0.8}, {0.5, -0.8}, {0.5, 0.8}, {0, 0.8}}, spacing)},
          {"cone", Cone{0.6, 0.7}, revolved({{0, -0.7}, {0.6, -0.7}, {0, 0.7}}, spacing)}};
}

TEST(Solid, TheFootIsTheNearestSurfacePoint) {
  const double spacing = 0.02;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  for (const Sampled& s : sampledShapes(spacing)) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 x(uniform(random), uniform(random), uniform(random));
      const SolidPoint point = solidAt(s.shape, x);
      double nearest = 1e9;
      for (const Vec3& y : s.surface) nearest = std::min(nearest, (x - y).norm());
      // Chords of the sampled profile cut off at most 1e-3 of the true surface.
      EXPECT_GT(nearest, std::abs(point.depth) - 1e-3) << s.name << " at " << x.transpose();
      EXPECT_LT(nearest, std::hypot(point.depth, spacing) + 1e-3) << s.name;
      EXPECT_NEAR(solidAt(s.shape, x + point.depth * point.normal).depth, 0, 1e-12) << s.name;
      EXPECT_NEAR(point.normal.norm(), 1, 1e-12) << s.name;
    }
  }
}

TEST(Solid, AHullsFootIsItsNearestPoint) {
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Hull hull = randomHull(seed, 6 + 2 * static_cast<int>(seed));
    std::mt19937 random(seed);
    for (int i = 0; i < 200; ++i) {
      const Vec3 x(uniform(random), uniform(random), uniform(random));
      const SolidPoint point = solidAt(hull, x);
      const Vec3 foot = x + point.depth * point.normal;
      for (const HalfSpace& plane : hull.planes)
        ASSERT_LE(plane.normal.dot(foot) - plane.offset, 1e-9) << "foot outside, seed " << seed;
      if (point.depth > 0) continue;
      // A convex body's nearest point y to x, and no other, has (c - y).(x - y) <= 0 for all c.
      for (const Vec3& corner : hull.corners)
        ASSERT_LE((corner - foot).dot(x - foot), 1e-9) << "a nearer point exists, seed " << seed;
    }
  }
}

TEST(Solid, ABoxAsAHullIsThatBox) {
  const Vec3 half(0.3, 0.5, 0.8);
  const Solid box = Box{half}, hull = boxAsHull(half);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x(uniform(random), uniform(random), uniform(random));
    const SolidPoint a = solidAt(box, x), b = solidAt(hull, x);
    EXPECT_NEAR(a.depth, b.depth, 1e-12);
    EXPECT_NEAR((a.normal - b.normal).norm(), 0, 1e-9);
  }
}

TEST(Solid, ScaleChangesLengthsOnly) {
  for (const double scale : {1e-3, 100.0}) {
    const Hull hull = randomHull(3, 20);
    Hull scaled = hull;
    for (HalfSpace& plane : scaled.planes) plane.offset *= scale;
    for (Vec3& corner : scaled.corners) corner *= scale;
    const Vec3 x(1.7, 1.1, -0.9);
    EXPECT_NEAR(solidAt(scaled, scale * x).depth, scale * solidAt(hull, x).depth, 1e-12 * scale);
    EXPECT_NEAR(solidAt(Cone{scale, scale}, scale * x).depth, scale * solidAt(Cone{1, 1}, x).depth,
                1e-12 * scale);
  }
}

TEST(Solid, BoundsTouchTheSurfaceOnEverySide) {
  std::vector<Solid> shapes = {Sphere{0.7},        Box{{1, 2, 3}},      Capsule{0.4, 0.6},
                               Cylinder{0.5, 0.8}, Cone{0.6, 0.7, 0.1}, boxAsHull({1, 2, 3})};
  for (const Solid& shape : shapes) {
    const Eigen::AlignedBox3d box = boundsOf(shape);
    for (int axis = 0; axis < 3; ++axis) {
      // Beyond a side the whole plane is outside; on it some point is not.
      double highest = -1e9;
      for (int i = -40; i <= 40; ++i)
        for (int j = -40; j <= 40; ++j) {
          const double u = i / 40.0, v = j / 40.0;  // meets the rounded cone's base, at -35 / 40
          Vec3 x = box.center() + (box.sizes() / 2).cwiseProduct(Vec3(u, u, u));
          x[(axis + 1) % 3] = box.center()[(axis + 1) % 3] + v * box.sizes()[(axis + 1) % 3] / 2;
          x[axis] = box.max()[axis];
          highest = std::max(highest, solidAt(shape, x).depth);
        }
      EXPECT_NEAR(highest, 0, 1e-9) << "axis " << axis << ", shape " << shape.index();
    }
  }
  EXPECT_TRUE(std::isinf(boundsOf(HalfSpace{}).max().x()));
}

}  // namespace
}  // namespace cloudcontact::solid_test
