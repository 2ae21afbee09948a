// Lines through solids, against the sign of the solids' depth along them; their farthest points,
// against their bounds in a turned frame.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "contact/contact_cases.h"
#include "law/solid_line.h"

namespace cloudcontact::solid_line_test {
namespace {

std::vector<Solid> solids() {
  Hull rounded = testing::boxAsHull(Vec3(0.6, 0.4, 0.5));
  rounded.margin = 0.2;
  return {Sphere{0.9},
          Box{Vec3(0.8, 0.3, 0.6)},
          Ellipsoid{Vec3(1, 0.2, 0.5)},
          Capsule{0.3, 0.7},
          Cylinder{0.5, 0.6},
          Cone{0.5, 0.9, 0},
          Cone{0.4, 0.6, 0.2},
          testing::boxAsHull(Vec3(0.8, 0.3, 0.6)),
          rounded};
}

// Between the ends the line is inside, beyond them outside; where there is no span, it is outside.
TEST(SolidLine, SpanIsWhereTheDepthIsPositive) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(-1, 1);
  const Pose place{Eigen::Quaterniond(0.8, 0.1, -0.3, 0.5).normalized(), Vec3(0.1, -0.2, 0.3)};
  for (const Solid& solid : solids()) {
    const PlacedSolid area{solid, place};
    int hits = 0;
    for (int n = 0; n < 400; ++n) {
      const Vec3 way = Vec3(in(random), in(random), in(random)).normalized();
      const Vec3 start = place.position + 0.6 * Vec3(in(random), in(random), in(random)) - 2 * way;
      const auto span = SolidLines(area, way, 0.02).through(start);
      hits += span.has_value();
      for (double t = 0; t < 4; t += 0.05) {
        const double depth = depthOf(area, start + t * way);
        const bool inside = span && t > span->from && t < span->to;
        if (std::abs(depth) > 1e-3) {
          EXPECT_EQ(inside, depth > 0) << solid.index() << " at " << t;
        }
      }
    }
    EXPECT_GT(hits, 100);
  }
}

// Lines along the faces and through the tip, where formulas divide by zero.
TEST(SolidLine, SpecialLines) {
  const PlacedSolid box{Box{Vec3(1, 2, 3)}}, cone{Cone{1, 1, 0}}, tube{Cylinder{1, 1}};
  const auto down = [](const PlacedSolid& area, double x) {
    return SolidLines(area, -Vec3::UnitZ(), 0.1).through(Vec3(x, 0, 5));
  };
  EXPECT_NEAR(down(box, 1)->to, 8, 1e-12) << "in the face";
  EXPECT_FALSE(down(box, 1.001));
  EXPECT_NEAR(down(tube, 1)->from, 4, 1e-12);
  EXPECT_FALSE(down(tube, 1.001));
  EXPECT_NEAR(down(cone, 0)->from, 4, 1e-12) << "through the tip";
  EXPECT_NEAR(down(cone, 0.5)->from, 5, 1e-12);
  EXPECT_NEAR(down(cone, 0.5)->to, 6, 1e-12);
  const Vec3 slope = Vec3(1, 0, -2).normalized();  // along the cone's side
  EXPECT_NEAR(SolidLines(cone, slope, 0.1).through(Vec3(-0.2, 0, 1))->to, 2 / -slope.z(), 1e-12);
}

// No point of a solid is farther than the farthest, which lies on its bounds.
TEST(SolidLine, FarthestPointIsOnTheBounds) {
  const Pose place{Eigen::Quaterniond(0.8, 0.1, -0.3, 0.5).normalized(), Vec3(0.1, -0.2, 0.3)};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(-1, 1);
  for (const Solid& solid : solids()) {
    const PlacedSolid area{solid, place};
    const Vec3 way = Vec3(in(random), in(random), in(random)).normalized();
    const Vec3 most = *farthestOf(area, way);
    EXPECT_NEAR(depthOf(area, most), 0, 1e-9) << solid.index();
    for (int n = 0; n < 2000; ++n) {
      const Vec3 x = place.position + 1.5 * Vec3(in(random), in(random), in(random));
      if (depthOf(area, x) > 1e-6) {
        EXPECT_LE(x.dot(way), most.dot(way)) << solid.index();
      }
    }
  }
  EXPECT_FALSE(farthestOf({HalfSpace{}}, Vec3::UnitX()));
}

}  // namespace
}  // namespace cloudcontact::solid_line_test
