// The union of spheres as voxels, against closed forms, and inscribed spheres of clouds.
#include <cloudcontact/objects/sphere_cloud.h>

#include "objects/test_objects.h"

namespace cloudcontact::sphere_cloud_test {
namespace {

using namespace test;

constexpr double kPi = std::numbers::pi;

SphereCloud spheres(std::vector<Vec3> centers, std::vector<double> radii) {
  SphereCloud s;
  s.centers = std::move(centers);
  s.radii = std::move(radii);
  return s;
}

double ballVolume(double r) {
  return 4 * kPi / 3 * r * r * r;
}

TEST(Spheres, OneIsABall) {
  for (const double r : {1.0, 3.3, 16.0}) {
    const Vec3 middle = kH * Vec3(0.3, 7.1, -2.4);
    const Cloud cloud = toCloud(spheres({middle}, {r * kH}), kH);
    const MassProperties mass = cloud.massProperties();
    EXPECT_NEAR(mass.volume / ballVolume(r * kH), 1, r < 2 ? 5e-3 : 1e-3) << r;
    EXPECT_LT((mass.centerOfMass - middle).norm(), 1e-3 * kH) << r;
    EXPECT_LT(ballError(cloud, r * kH, middle), 0.005) << r;
  }
}

// Two balls that overlap by a lens: volume in closed form. Neither their order nor a double
// matters.
TEST(Spheres, OverlapCountsOnce) {
  const double r1 = 9.2 * kH, r2 = 6.7 * kH, d = 11.1 * kH;
  const double lens = kPi * std::pow(r1 + r2 - d, 2) *
                      (d * d + 2 * d * (r1 + r2) - 3 * (r1 - r2) * (r1 - r2)) / (12 * d);
  const double truth = ballVolume(r1) + ballVolume(r2) - lens;
  const Vec3 a = kH * Vec3(0.2, 0.4, 0.1), b = a + d * Vec3(0.48, 0.6, 0.64);
  const Cloud one = toCloud(spheres({a, b}, {r1, r2}), kH);
  EXPECT_NEAR(one.massProperties().volume / truth, 1, 1e-3);
  expectSameVoxels(toCloud(spheres({b, a, b}, {r2, r1, r2}), kH), one);
}

TEST(Spheres, MaterialIsThatOfTheDeepestSphere) {
  SphereCloud s = spheres({Vec3(0, 0, 0), Vec3(12 * kH, 0, 0)}, {6 * kH, 6 * kH});
  s.material = {0, 1};
  s.materials = {"fat", "muscle"};
  const Cloud cloud = toCloud(s, kH);
  ASSERT_EQ(cloud.materials(), s.materials);
  for (int z = 0; z < cloud.size()[2]; ++z)
    for (int y = 0; y < cloud.size()[1]; ++y)
      for (int x = 0; x < cloud.size()[0]; ++x)
        if (cloud.coverage(x, y, z) > 0 && std::abs(cloud.center(x, y, z)[0] - 6 * kH) > kH) {
          ASSERT_EQ(cloud.material(x, y, z), cloud.center(x, y, z)[0] > 6 * kH);
        }
}

TEST(Spheres, ScaleDoesNotMatter) {
  const Cloud one = toCloud(spheres({Vec3(1, 2, 3)}, {7}), 1);
  const Cloud small = toCloud(spheres({Vec3(1e-6, 2e-6, 3e-6)}, {7e-6}), 1e-6);
  EXPECT_EQ(one.voxels().table, small.voxels().table);
  EXPECT_EQ(one.voxels().coverage.size(), small.voxels().coverage.size());
  EXPECT_NEAR(small.massProperties().volume * 1e18 / one.massProperties().volume, 1, 1e-4);
}

TEST(Inscribed, OneBallIsOneSphere) {
  InscribedReport report;
  const SphereCloud s = inscribedSpheres(ballCloud(12), {}, &report);
  ASSERT_LE(s.centers.size(), 3u);
  EXPECT_LT((s.centers[0] - ballMiddle()).norm(), 0.05 * kH);
  EXPECT_NEAR(s.radii[0], 12 * kH, 0.05 * kH);
  EXPECT_LE(report.worstGap, 0.05 * kH);
}

// The union of a nut's spheres is the nut, up to the tolerance. A finer tolerance gives more
// spheres and smaller gaps.
TEST(Inscribed, FillABodyWithinTheTolerance) {
  const Cloud cloud = nutCloud();
  const double volume = cloud.massProperties().volume;
  std::size_t last = 0;
  for (const double tolerance : {0.2, 0.1, 0.05}) {
    InscribedSettings settings;
    settings.tolerance = tolerance;
    InscribedReport report;
    const SphereCloud s = inscribedSpheres(cloud, settings, &report);
    EXPECT_GT(s.centers.size(), last);
    last = s.centers.size();
    EXPECT_LT(s.centers.size(), cloud.counts().interface * 2);
    EXPECT_LT(report.meanGap, tolerance * kH);
    EXPECT_LE(report.worstGap, tolerance * kH * (1 + 1e-9));
    // The area is 2100 voxels^2 on a volume of 4050: a gap of 0.1 everywhere is 5 %.
    const double filled = toCloud(s, kH).massProperties().volume / volume;
    EXPECT_GT(filled, 1 - 0.7 * tolerance - 0.01) << tolerance;
    EXPECT_LT(filled, 1.02);
  }
}

TEST(Inscribed, SameForAnyNumberOfThreads) {
  InscribedSettings one, four;
  one.threads = 1, four.threads = 4;
  const SphereCloud a = inscribedSpheres(nutCloud(), one), b = inscribedSpheres(nutCloud(), four);
  EXPECT_EQ(a.radii, b.radii);
  EXPECT_EQ(a.centers, b.centers);
}

TEST(Spheres, RefuseBadInput) {
  EXPECT_THROW(toCloud(SphereCloud(), kH), std::invalid_argument);
  EXPECT_THROW(toCloud(spheres({Vec3(0, 0, 0)}, {}), kH), std::invalid_argument);
  for (const double r : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_THROW(toCloud(spheres({Vec3(0, 0, 0)}, {r}), kH), std::invalid_argument) << r;
  EXPECT_THROW(toCloud(spheres({Vec3(0, NAN, 0)}, {1}), kH), std::invalid_argument);
  EXPECT_THROW(toCloud(spheres({Vec3(0, 0, 0)}, {1}), 0), std::invalid_argument);
  EXPECT_THROW(toCloud(spheres({Vec3(0, 0, 0)}, {1}), -1), std::invalid_argument);
  EXPECT_THROW(toCloud(spheres({Vec3(0, 0, 0)}, {1e9}), 1e-3), std::length_error);
  InscribedSettings bad;
  bad.tolerance = 0;
  EXPECT_THROW(inscribedSpheres(ballCloud(4), bad), std::invalid_argument);
  EXPECT_THROW(inscribedSpheres(Cloud()), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::sphere_cloud_test
