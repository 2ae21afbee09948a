// A kept gap never says more than how far bodies are apart, by all pairs of their samples, and not
// much less; motion spends it.
#include "contact/kept_gap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::kept_gap_test {
namespace {

constexpr double kVoxel = 1e-3;

std::vector<Vec3> samplesOf(const ContactBody& body) {
  std::vector<Vec3> places;
  const Cloud& cloud = body.field->cloud();
  for (std::size_t k = 0; k < body.field->sampleCount(); ++k) {
    const SurfaceSample sample = body.field->sample(k);
    const Vec3 grid = Eigen::Map<const Eigen::Vector3f>(sample.position).cast<double>();
    places.push_back(body.pose.toWorld(cloud.origin() + cloud.voxelSize() * grid));
  }
  return places;
}

// Of the samples' middles [m], which are up to a voxel and a half farther apart than the surfaces.
double between(const ContactBody& a, const ContactBody& b) {
  double least = std::numeric_limits<double>::infinity();
  const std::vector<Vec3> ofA = samplesOf(a), ofB = samplesOf(b);
  for (const Vec3& x : ofA)
    for (const Vec3& y : ofB) least = std::min(least, (x - y).squaredNorm());
  return std::sqrt(least);
}

bool holdsAt(const ContactBody& a, const ContactBody& b, double least) {
  KeptGap gap;
  gap.keep(a, b, least);
  return gap.holds(a.pose, b.pose);
}

struct Pair {
  BodyMaker maker{kVoxel, Random(5)};
  Body bar = maker.box(Vec3(40, 8, 6)), ball = maker.sphere(7);

  Pose around(double voxels) {
    return {maker.random.rotation(), kVoxel * voxels * (2 * maker.random.inCube() - Vec3::Ones())};
  }
};

TEST(KeptGap, IsTrueAndNear) {
  Pair pair;
  int told = 0;
  for (int i = 0; i < 60; ++i) {
    const ContactBody a = pair.bar.at(pair.around(5)), b = pair.ball.at(pair.around(60));
    const double apart = between(a, b);
    EXPECT_FALSE(holdsAt(a, b, apart)) << "pose " << i;
    EXPECT_FALSE(holdsAt(b, a, apart)) << "pose " << i;
    // Short by half at most, or by the diameters of two leaves.
    const double least = 0.98 * std::min(apart / 2, apart - 17 * kVoxel) - kVoxel;
    if (!(least > 0)) continue;
    EXPECT_TRUE(holdsAt(a, b, least)) << "pose " << i << ": " << apart / kVoxel << " voxels";
    ++told;
  }
  EXPECT_GT(told, 20);
}

TEST(KeptGap, IsSpentByMotion) {
  Pair pair;
  constexpr double kLeast = 2 * kVoxel;
  int held = 0, spent = 0;
  for (int i = 0; i < 40; ++i) {
    ContactBody a = pair.bar.at(pair.around(2)), b = pair.ball.at(pair.around(50));
    KeptGap gap;
    gap.keep(a, b, kLeast);
    if (!gap.holds(a.pose, b.pose)) continue;
    // Turns about the bar's middle sweep its ends by 20 voxels.
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(0.2 * i, pair.maker.random.rotation() * Vec3::UnitX()));
    a.pose.orientation = turn * a.pose.orientation;
    b.pose.position += 0.5 * kVoxel * i * pair.maker.random.inCube();
    const bool holds = gap.holds(a.pose, b.pose);
    EXPECT_FALSE(holds && between(a, b) <= kLeast) << "pose " << i;
    (holds ? held : spent) += 1;
    // What moves as one is as far apart as before.
    const Pose shared = pair.around(100);
    gap.keep(a, b, kLeast);
    const bool now = gap.holds(a.pose, b.pose);
    EXPECT_EQ(gap.holds(shared * a.pose, shared * b.pose), now);
  }
  EXPECT_GT(held, 3);
  EXPECT_GT(spent, 10);
}

TEST(KeptGap, IsLookedForAgainOnceItCanBeLargeEnough) {
  Pair pair;
  const ContactBody a = pair.bar.at({});
  const auto above = [&](double voxels) {
    return pair.ball.at({Eigen::Quaterniond::Identity(), Vec3(0, 0, voxels * kVoxel)});
  };
  KeptGap gap;
  constexpr double kLeast = 30 * kVoxel;
  gap.keep(a, above(14), kLeast);
  const std::size_t first = gap.compared();
  EXPECT_GT(first, 0u);
  gap.keep(a, above(15), kLeast);
  EXPECT_EQ(gap.compared(), first);
  gap.keep(a, above(90), kLeast);
  EXPECT_GT(gap.compared(), first);
  EXPECT_TRUE(gap.holds(a.pose, above(90).pose));
}

}  // namespace
}  // namespace cloudcontact::testing::kept_gap_test
