// Clouds from points that fill a body and from points of its surface, against closed forms.
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/objects/point_cloud.h>

#include <random>

#include "objects/test_objects.h"

namespace cloudcontact::point_cloud_test {
namespace {

using namespace test;

TEST(Points, CentersConvertBackToTheCloud) {
  for (const Cloud& cloud : {ballCloud(8), nutCloud(), twoMaterials()})
    expectSameVoxels(toCloud(centerPoints(cloud), kH), cloud);
}

// Parts of voxels follow the surface: their cloud at their own spacing has no steps.
TEST(Points, PartsOfVoxelsFollowTheSurface) {
  const double r = 10;
  const PointCloud points = centerPoints(ballCloud(r), 3);
  EXPECT_NEAR(points.spacing, kH / 3, 1e-12);
  EXPECT_LT(ballError(toCloud(points, kH / 3), r * kH, ballMiddle()), 0.01);
  EXPECT_LT(ballError(toCloud(points, kH), r * kH, ballMiddle()), 0.002);
}

TEST(Points, CornersGiveTheBodyHalfAVoxelAside) {
  const double r = 10;
  const PointCloud points = cornerPoints(ballCloud(r));
  const Vec3 corner = (points.positions[0] - ballCloud(r).origin()) / kH;
  EXPECT_LT((corner - corner.array().round().matrix()).norm(), 1e-6);
  EXPECT_LT(ballError(toCloud(points, kH), r * kH, ballMiddle()), 0.003);
}

TEST(Points, KeepVolumeInVoxelsOfAnySize) {
  const double volume = nutCloud().massProperties().volume;
  for (const PointCloud& points : {centerPoints(nutCloud(), 2), cornerPoints(nutCloud())})
    for (const double size : {0.5, 0.9, 1.0, 2.0})
      EXPECT_NEAR(toCloud(points, size * kH).massProperties().volume / volume, 1, 3e-3) << size;
}

TEST(Points, SurfacePointsLieOnTheSurface) {
  const double r = 9;
  for (const int perEdge : {1, 3}) {
    const PointCloud points = surfacePoints(ballCloud(r), perEdge);
    EXPECT_NEAR(double(points.positions.size()), 4 * std::numbers::pi * r * r * perEdge * perEdge,
                0.75 * 4 * std::numbers::pi * r * r * perEdge * perEdge);
    for (std::size_t i = 0; i < points.positions.size(); ++i) {
      const Vec3 out = points.positions[i] - ballMiddle();
      EXPECT_NEAR(out.norm(), r * kH, 0.03 * kH);
      EXPECT_GT(out.normalized().dot(points.normals[i].cast<double>()), std::cos(0.03));
    }
  }
}

// Points spread evenly over a ball by a spiral.
PointCloud ballScan(double radius, int count, double noise = 0, unsigned seed = 1) {
  PointCloud points;
  std::mt19937 random(seed);
  std::normal_distribution<double> shake(0, 1);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double flat = std::sqrt(1 - z * z);
    const Vec3 out(flat * std::cos(turn), flat * std::sin(turn), z);
    points.positions.push_back(ballMiddle() + (radius * kH + noise * kH * shake(random)) * out);
  }
  return points;
}

Cloud fromScan(const PointCloud& points, double voxel = kH, ScanReport* report = nullptr) {
  ScanSettings settings;
  settings.voxelSize = voxel;
  return toCloud(points, settings, report);
}

TEST(Scan, BallIsReconstructed) {
  const double r = 12;
  for (const int count : {1200, 5000, 20000}) {
    ScanReport report;
    const Cloud cloud = fromScan(ballScan(r, count), kH, &report);
    EXPECT_TRUE(report.closed);
    // Each point's share of the area.
    EXPECT_NEAR(report.pointDistance, std::sqrt(4 * std::numbers::pi / count) * r * kH,
                0.15 * report.pointDistance);
    EXPECT_LT(ballError(cloud, r * kH, ballMiddle()), 0.004) << count;
    EXPECT_NEAR(cloud.massProperties().volume / (4 * std::numbers::pi / 3 * std::pow(r * kH, 3)), 1,
                1e-3)
        << count;
  }
}

// Noise of a tenth of a voxel is averaged to less than half.
TEST(Scan, AveragesNoise) {
  const double r = 12;
  EXPECT_LT(ballError(fromScan(ballScan(r, 8000, 0.1)), r * kH, ballMiddle()), 0.06);
}

TEST(Scan, NormalsOfEitherSignGiveTheSameBody) {
  const double r = 10;
  PointCloud points = ballScan(r, 4000);
  for (const Vec3& p : points.positions)
    points.normals.push_back((p - ballMiddle()).normalized().cast<float>());
  ScanReport report;
  const Cloud right = fromScan(points, kH, &report);
  EXPECT_EQ(report.turned, 0u);
  for (Eigen::Vector3f& n : points.normals) n = -n;
  const Cloud turned = fromScan(points, kH, &report);
  EXPECT_EQ(report.turned, points.positions.size());
  expectSameVoxels(turned, right);
}

// A concave body with edges: rounded only within the smoothing, so volume and position hold.
TEST(Scan, NutIsReconstructed) {
  const Cloud nut = nutCloud();
  const PointCloud points = surfacePoints(nut, 2);
  PointCloud bare = points;
  bare.normals.clear();
  for (const PointCloud& scan : {points, bare}) {
    ScanReport report;
    const Cloud cloud = fromScan(scan, kH, &report);
    EXPECT_TRUE(report.closed);
    const MassProperties found = cloud.massProperties(), truth = nut.massProperties();
    EXPECT_NEAR(found.volume / truth.volume, 1, 0.015);
    EXPECT_LT((found.centerOfMass - truth.centerOfMass).norm(), 0.03 * kH);
  }
}

TEST(Scan, SameForAnyNumberOfThreads) {
  ScanSettings one, three;
  one.voxelSize = three.voxelSize = kH;
  one.threads = 1, three.threads = 3;
  const PointCloud points = ballScan(7, 1500, 0.05);
  expectSameVoxels(toCloud(points, one), toCloud(points, three));
}

// Half a ball closes no volume. With a thickness it becomes a cup, behind points with normals and
// centered on points without.
TEST(Scan, OpenScanIsRefusedOrBecomesAShell) {
  const double r = 14, t = 3;
  PointCloud half = ballScan(r, 12000);
  std::erase_if(half.positions, [](const Vec3& p) { return p[2] < ballMiddle()[2]; });
  try {
    fromScan(half);
    ADD_FAILURE() << "an open scan was taken for closed";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("close no volume"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("shell"), std::string::npos) << e.what();
  }
  ScanSettings settings;
  settings.voxelSize = kH;
  settings.shell = t * kH;
  const auto cup = [](double outer, double inner) {
    return 2 * std::numbers::pi / 3 * (std::pow(outer * kH, 3) - std::pow(inner * kH, 3));
  };
  ScanReport report;
  const Cloud about = toCloud(half, settings, &report);
  EXPECT_FALSE(report.closed);
  EXPECT_NEAR(about.massProperties().volume / cup(r + t / 2, r - t / 2), 1, 0.03);
  for (const Vec3& p : half.positions)
    half.normals.push_back((p - ballMiddle()).normalized().cast<float>());
  EXPECT_NEAR(toCloud(half, settings).massProperties().volume / cup(r, r - t), 1, 0.03);
}

TEST(Scan, VolumesAreRecognized) {
  PointCloud lattice;
  for (int i = 0; i < 12 * 12 * 12; ++i)
    lattice.positions.push_back(0.7e-3 * Vec3(i % 12, i / 12 % 12, i / 144));
  EXPECT_TRUE(recognizeVolume(lattice));
  EXPECT_NEAR(lattice.spacing, 0.7e-3, 1e-9);
  EXPECT_NEAR(toCloud(lattice, kH).massProperties().volume / std::pow(12 * 0.7e-3, 3), 1, 1e-3);
  for (const double noise : {0.0, 0.1}) {
    PointCloud surface = ballScan(10, 3000, noise);
    EXPECT_FALSE(recognizeVolume(surface));
    EXPECT_EQ(surface.spacing, 0);
  }
}

TEST(Points, RefuseBadInput) {
  PointCloud good = centerPoints(ballCloud(3));
  const auto refused = [&](auto change, const std::string& word) {
    PointCloud bad = good;
    change(bad);
    try {
      toCloud(bad, kH);
      ADD_FAILURE() << word << " was accepted";
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  };
  refused([](PointCloud& p) { p.positions[4][1] = NAN; }, "position 4");
  refused([](PointCloud& p) { p.positions[0][1] = INFINITY; }, "position 0");
  refused([](PointCloud& p) { p.shares.pop_back(); }, "shares");
  refused([](PointCloud& p) { p.shares[0] = -0.1f; }, "share");
  refused([](PointCloud& p) { p.shares[0] = NAN; }, "share");
  refused([](PointCloud& p) { p.spacing = -1; }, "spacing");
  refused([](PointCloud& p) { p.normals.resize(1); }, "normals");
  refused([](PointCloud& p) { p.normals.assign(p.positions.size(), {2, 0, 0}); }, "normal");
  refused([](PointCloud& p) { p.material.assign(p.positions.size(), 1); }, "material");
  refused([](PointCloud& p) { p = {}; }, "16 points");
  refused([](PointCloud& p) { p = {}, p.spacing = 1; }, "nothing");
  refused(
      [](PointCloud& p) { p.positions.assign(20, Vec3(1, 2, 3)), p.shares.clear(), p.spacing = 0; },
      "on one another");
  EXPECT_THROW(toCloud(good, 0), std::invalid_argument);
  EXPECT_THROW(toCloud(good, 1e-12), std::length_error);
  EXPECT_THROW(centerPoints(ballCloud(3), 0), std::invalid_argument);
  EXPECT_TRUE(centerPoints(Cloud()).positions.empty());
  EXPECT_TRUE(cornerPoints(Cloud()).positions.empty());
}

}  // namespace
}  // namespace cloudcontact::point_cloud_test
