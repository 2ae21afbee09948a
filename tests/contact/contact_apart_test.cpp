// Pairs far apart are skipped without looking up a sample; other pairs are not. A shape is seen
// from as far away as is asked for.
#include <gtest/gtest.h>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::contact_apart_test {
namespace {

constexpr double kVoxel = 1e-3, kMargin = 2 * kVoxel;

// True if a sample of one body lies in the other or within the margin.
bool meets(const ContactBody& sampled, const ContactBody& other) {
  if (!sampled.field) return false;
  const Cloud& cloud = sampled.field->cloud();
  for (std::size_t k = 0; k < sampled.field->sampleCount(); ++k) {
    const SurfaceSample sample = sampled.field->sample(k);
    const Vec3 grid = Eigen::Map<const Eigen::Vector3f>(sample.position).cast<double>();
    const Vec3 local =
        other.pose.toLocal(sampled.pose.toWorld(cloud.origin() + cloud.voxelSize() * grid));
    if (other.shape && solidAt(*other.shape, local).depth > -kMargin) return true;
    if (!other.field) continue;
    const auto found = other.field->at(local);
    if (found && found->depth > -kMargin) return true;
  }
  return false;
}

std::size_t lookups(const ContactBody& a, const ContactBody& b) {
  ContactSettings settings;
  settings.margin = kMargin;
  ContactFinder finder;
  finder.find(a, b, settings);
  return finder.sampleLookups();
}

class FarApart : public ::testing::Test {
 protected:
  BodyMaker maker{kVoxel, Random(11)};
  Body bar = maker.box(Vec3(40, 8, 6), true);  // its grid along its edges

  // Against the bar, at random poses around it.
  void check(const Body& other, double reach) {
    int skipped = 0, met = 0;
    for (int i = 0; i < 300; ++i) {
      const Pose place{maker.random.rotation(),
                       kVoxel * reach * (2 * maker.random.inCube() - Vec3::Ones())};
      const ContactBody a = bar.at({}), b = other.at(place);
      const bool skip = lookups(a, b) == 0;
      EXPECT_EQ(lookups(b, a) == 0, skip);
      const bool meeting = meets(a, b) || meets(b, a);
      EXPECT_FALSE(skip && meeting) << "pose " << i;
      skipped += skip;
      met += meeting;
    }
    EXPECT_GT(skipped, 30);
    EXPECT_GT(met, 30);
  }
};

TEST_F(FarApart, Clouds) {
  check(maker.box(Vec3(30, 10, 5)), 30);
}

TEST_F(FarApart, AConvexShape) {
  check(BodyMaker::shape(Cylinder{4 * kVoxel, 12 * kVoxel}), 30);
}

// Crossed bars that only an axis across two edges separates.
TEST_F(FarApart, AlongEdgeAxes) {
  const Pose turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.25 * EIGEN_PI, Vec3::UnitX())),
                    Vec3::Zero()};
  Pose crossed = turned;
  crossed.orientation = Eigen::AngleAxisd(0.5 * EIGEN_PI, Vec3::UnitZ()) * turned.orientation;
  crossed.position = Vec3(0, 0, 16 * kVoxel);  // edges reach 4.95 voxels: 6.1 apart
  EXPECT_GT(lookups(bar.at(turned), bar.at({crossed.orientation, Vec3(0, 0, 9 * kVoxel)})), 0u);
  EXPECT_EQ(lookups(bar.at(turned), bar.at(crossed)), 0u);
}

TEST_F(FarApart, AHalfSpace) {
  const Body ground = BodyMaker::shape(HalfSpace{});
  Pose upright{Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * EIGEN_PI, Vec3::UnitY())), Vec3::Zero()};
  upright.position = Vec3(0.3, -0.2, 21.5 * kVoxel);  // its end within the margin
  EXPECT_GT(lookups(bar.at(upright), ground.at({})), 0u);
  upright.position.z() = 26 * kVoxel;
  EXPECT_EQ(lookups(bar.at(upright), ground.at({})), 0u);
  upright.position.z() = -1;  // deep below
  EXPECT_GT(lookups(bar.at(upright), ground.at({})), 0u);
}

// A ball above others, whose gap is known: how deep its deepest point is, 1 without any.
double deepestAbove(const Body& other, double top, double gap, double margin) {
  BodyMaker maker{kVoxel, Random(3)};
  const Body ball = maker.sphere(12);
  ContactSettings settings;
  settings.margin = margin;
  ContactFinder finder;
  const Pose above{Eigen::Quaterniond::Identity(), Vec3(0, 0, top + 12 * kVoxel + gap)};
  const ContactResult& seen = finder.find(ball.at(above), other.at({}), settings);
  double deepest = seen.points.empty() ? 1 : -1;
  for (const ContactPoint& point : seen.points) {
    deepest = std::max(deepest, point.depth);
    EXPECT_LT(point.normal.z(), -0.95);
  }
  return deepest;
}

TEST(SeenFromAfar, APlane) {
  constexpr double kGap = 10 * kVoxel;
  const Body ground = BodyMaker::shape(HalfSpace{});
  EXPECT_EQ(deepestAbove(ground, 0, kGap, kGap - kVoxel), 1);
  EXPECT_NEAR(deepestAbove(ground, 0, kGap, kGap + kVoxel), -kGap, 0.1 * kVoxel);
}

// What is nearest to a ball is not where a body that flies by would touch it.
TEST(SeenFromAfar, NoOtherShape) {
  const Body ball = BodyMaker::shape(Sphere{8 * kVoxel});
  EXPECT_EQ(deepestAbove(ball, 8 * kVoxel, 3 * kVoxel, 10 * kVoxel), 1);
  EXPECT_NEAR(deepestAbove(ball, 8 * kVoxel, kVoxel, 10 * kVoxel), -kVoxel, 0.1 * kVoxel);
}

}  // namespace
}  // namespace cloudcontact::testing::contact_apart_test
