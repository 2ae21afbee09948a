// A synthetic depth camera sees a plane, a ball, a box and a step, with noise and holes. Surfaces
// are compared with closed forms, and steps must stay open.
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/objects/depth_image.h>

#include <cloudcontact/objects/digital_object.h>

#include <functional>
#include <random>

#include "objects/test_objects.h"

namespace cloudcontact::depth_image_test {
namespace {

using namespace test;

constexpr int kPixels = 121;
constexpr double kPitch = 1e-3;  // between pixels on a plane one meter away [m]

// A pinhole camera at the origin, facing along z. The ray of `direction` (with z = 1) hits the
// scene at depth `depthOf(direction)`; NaN: nothing.
DepthImage seen(const std::function<double(const Vec3&)>& depthOf, double noise = 0) {
  DepthImage image;
  image.width = kPixels, image.height = kPixels - 20;
  std::mt19937 random(17);
  std::normal_distribution<double> shake(0, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3 ray(kPitch * (x - 60), kPitch * (y - 50), 1);
      image.points.push_back((depthOf(ray) + noise * shake(random)) * ray);
    }
  return image;
}

double ballAhead(const Vec3& ray, double radius) {  // its center one meter ahead
  const double a = ray.squaredNorm(), b = ray[2], c = 1 - radius * radius;
  const double root = b * b - a * c;
  return root < 0 ? NAN : (b - std::sqrt(root)) / a;
}

double rms(const DepthImage& image, const std::function<double(const Vec3&)>& off, int margin = 0) {
  double sum = 0, count = 0;
  for (int y = margin; y < image.height - margin; ++y)
    for (int x = margin; x < image.width - margin; ++x) {
      const Vec3& p = image.points[x + image.width * y];
      if (!p.allFinite()) continue;
      sum += off(p) * off(p), count += 1;
    }
  return std::sqrt(sum / count);
}

TEST(DepthImage, SmoothingKeepsPlanesAndBalls) {
  const auto slope = [](const Vec3& ray) { return 1 / (1 - 0.8 * ray[0] - 0.3 * ray[1]); };
  const auto offSlope = [](const Vec3& p) {
    return (p[2] - 0.8 * p[0] - 0.3 * p[1] - 1) / std::sqrt(1 + 0.64 + 0.09);
  };
  EXPECT_LT(rms(mended(seen(slope)), offSlope), 0.002 * kPitch);
  const double r = 0.08;
  const auto offBall = [&](const Vec3& p) { return (p - Vec3(0, 0, 1)).norm() - r; };
  DepthSettings settings;
  settings.jump = 10 * kPitch;
  const DepthImage near =
      mended(seen([&](const Vec3& ray) {
               return std::hypot(ray[0], ray[1]) < 0.6 * r ? ballAhead(ray, r) : NAN;
             }),
             settings);
  EXPECT_LT(rms(near, offBall), 0.02 * kPitch);
}

// The least squares of a Gaussian-weighted quadratic: the noise left at 2, 3, 4 pixels.
TEST(DepthImage, SmoothingAveragesNoise) {
  const double noise = 0.5 * kPitch;
  const DepthImage raw = seen([](const Vec3&) { return 1; }, noise);
  const auto off = [](const Vec3& p) { return p[2] - 1; };
  EXPECT_NEAR(rms(raw, off), noise, 0.03 * noise);
  const double left[] = {0.5, 0.35, 0.27};
  for (int radius = 2; radius <= 4; ++radius) {
    DepthSettings settings;
    settings.smoothing = radius;
    EXPECT_LT(rms(mended(raw, settings), off, 4), left[radius - 2] * noise) << radius;
  }
}

// A step of 20 pixels: no triangle crosses it, and both sides are as exact as a plane with noise.
TEST(DepthImage, StepsAreNotBridged) {
  const double high = 20 * kPitch;
  const auto step = [&](const Vec3& ray) { return ray[0] < 0.4e-3 ? 1 : 1 - high; };
  for (const double noise : {0.0, 0.3 * kPitch}) {
    const DepthImage clean = mended(seen(step, noise));
    const Mesh mesh = toMesh(clean);
    const auto side = [&](const Vec3& p) { return p[2] > 1 - high / 2; };
    std::size_t far = 0;
    for (const Vector3i& t : mesh.triangles) {
      far += side(mesh.vertices[t[0]]);
      ASSERT_EQ(side(mesh.vertices[t[0]]), side(mesh.vertices[t[1]]));
      ASSERT_EQ(side(mesh.vertices[t[0]]), side(mesh.vertices[t[2]]));
    }
    EXPECT_EQ(mesh.triangles.size(), 2u * (kPixels - 2) * (kPixels - 21));
    EXPECT_EQ(far, 2u * 60 * (kPixels - 21));
    const auto off = [&](const Vec3& p) { return p[2] - (side(p) ? 1 : 1 - high); };
    EXPECT_LT(rms(clean, off), 0.6 * noise + 1e-5 * kPitch);
  }
}

TEST(DepthImage, TrianglesFaceTheCamera) {
  const Mesh mesh = toMesh(seen([](const Vec3& ray) { return 1 + 0.3 * ray[1]; }));
  EXPECT_EQ(mesh.triangles.size(), 2u * (kPixels - 1) * (kPixels - 21));
  for (const Vector3i& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    ASSERT_LT((b - a).cross(c - a).dot(a), 0);
  }
}

// Small holes are filled on the surface; large ones and those across a step stay open.
TEST(DepthImage, SmallHolesAreFilledOnTheSurface) {
  const double r = 0.25;
  DepthImage image = seen([&](const Vec3& ray) { return ballAhead(ray, r); });
  const auto hole = [&](int x, int y, int size) {
    for (int k = 0; k < size * size; ++k)
      image.points[x + k % size + kPixels * (y + k / size)].setConstant(NAN);
  };
  hole(30, 40, 5), hole(50, 70, 2), hole(80, 30, 1), hole(70, 60, 12);
  DepthSettings settings;
  settings.smoothing = 0;
  DepthReport report;
  const DepthImage clean = mended(image, settings, &report);
  EXPECT_EQ(report.filled, 25u + 4 + 1);
  EXPECT_EQ(report.left, 144u);
  EXPECT_EQ(report.seen, image.points.size() - 174);
  // Each lies where its pixel's ray meets the ball, up to the error of a quadratic over five
  // pixels.
  const DepthImage whole = seen([&](const Vec3& ray) { return ballAhead(ray, r); });
  for (std::size_t k = 0; k < whole.points.size(); ++k)
    if (clean.points[k].allFinite()) {
      ASSERT_LT((clean.points[k] - whole.points[k]).norm(), 0.003 * kPitch) << k;
    }
  DepthImage step = seen([](const Vec3& ray) { return ray[0] < 0.4e-3 ? 1.0 : 0.98; });
  for (int y = 50; y < 53; ++y)
    for (int x = 59; x < 63; ++x) step.points[x + kPixels * y].setConstant(NAN);
  mended(step, settings, &report);
  EXPECT_EQ(report.filled, 0u);
}

// A plate at one meter: it has the given thickness with either backing, and its front is in place.
TEST(DepthImage, BecomesABodyOfTheGivenThickness) {
  const double t = 6e-3;
  const DepthImage image = seen([](const Vec3&) { return 1; }, 0.1 * kPitch);
  const double width = kPitch * (kPixels - 1), height = kPitch * (kPixels - 21);
  DepthCloudSettings settings;
  settings.voxelSize = 1.5e-3;
  settings.thickness = t;
  const MassProperties shell = toCloud(image, settings).massProperties();
  EXPECT_NEAR(shell.volume / (width * height * t), 1, 0.01);
  EXPECT_NEAR(shell.centerOfMass[2], 1 + t / 2, 0.02 * kPitch);
  settings.backing = Backing::Rays;
  // The rays diverge, so the back is larger: a frustum, up to the length of the rays.
  const MassProperties rays = toCloud(image, settings).massProperties();
  const double back = 1 + t;
  EXPECT_NEAR(rays.volume / (width * height * (1 + back + back * back) / 3 * t), 1, 0.01);
}

// The corner of a box: its three visible faces are in place, the rest is closed behind.
TEST(DepthImage, ABoxKeepsItsFaces) {
  const Vec3 nearest(0, 0, 1);
  const Eigen::Matrix3d turn = shortestTurn(Vec3(-1, -1, -1), -Vec3::UnitZ()).toRotationMatrix();
  const auto corner =
      [&](const Vec3& ray) {  // the nearest face along the ray is the farthest plane
        double depth = 0;
        for (int k = 0; k < 3; ++k) {
          const Vec3 n = -turn.col(k);
          depth = std::max(depth, n.dot(nearest) / n.dot(ray));
        }
        return depth;
      };
  const auto off = [&](const Vec3& p) {
    const Vec3 in = turn.transpose() * (p - nearest);
    return in.minCoeff();
  };
  const DepthImage clean = mended(seen(corner, 0.2 * kPitch));
  EXPECT_LT(rms(clean, off, 2), 0.16 * kPitch);
  DepthCloudSettings settings;
  settings.voxelSize = 2e-3;
  settings.thickness = 0.02;
  settings.backing = Backing::Rays;
  const Cloud cloud = toCloud(seen(corner, 0.2 * kPitch), settings);
  // Inside behind each face, outside in front of it.
  for (int k = 0; k < 3; ++k) {
    const Vec3 face = nearest + 0.02 * (turn.col((k + 1) % 3) + turn.col((k + 2) % 3));
    for (const double depth : {-2.0, 2.0}) {
      const Vec3 at =
          (face + depth * settings.voxelSize * turn.col(k) - cloud.origin()) / settings.voxelSize;
      EXPECT_EQ(cloud.coverage(int(at[0]), int(at[1]), int(at[2])), depth > 0 ? 255 : 0)
          << k << ' ' << depth;
    }
  }
}

TEST(DepthImage, SameForAnyNumberOfThreads) {
  const DepthImage image = seen([](const Vec3& ray) { return 1 + ray[0] * ray[1]; }, 1e-4);
  DepthSettings one, three;
  one.threads = 1, three.threads = 3;
  EXPECT_EQ(mended(image, one).points, mended(image, three).points);
}

TEST(DepthImage, RefusesBadInput) {
  const DepthImage good = seen([](const Vec3&) { return 1; });
  const auto refused = [&](auto change) {
    DepthImage bad = good;
    change(bad);
    EXPECT_THROW(mended(bad), std::invalid_argument);
    EXPECT_THROW(toMesh(bad), std::invalid_argument);
  };
  refused([](DepthImage& i) { i = {}; });
  refused([](DepthImage& i) { i.points.pop_back(); });
  refused([](DepthImage& i) { i.width = -i.width; });
  refused([](DepthImage& i) { i.points[0][0] = INFINITY; });
  refused([](DepthImage& i) { i.points[7] = i.viewpoint; });
  refused([](DepthImage& i) { i.viewpoint[1] = NAN; });
  refused([](DepthImage& i) {
    for (Vec3& p : i.points) p.setConstant(NAN);
  });
  DepthSettings bad;
  bad.jump = -1;
  EXPECT_THROW(mended(good, bad), std::invalid_argument);
  bad = {};
  bad.smoothing = -1;
  EXPECT_THROW(mended(good, bad), std::invalid_argument);
  DepthCloudSettings settings;
  EXPECT_THROW(toCloud(good, settings), std::invalid_argument);
  settings.voxelSize = 1e-3;
  settings.thickness = NAN;
  EXPECT_THROW(toCloud(good, settings), std::invalid_argument);
  settings.thickness = 0;
  settings.image.jump = 1e-9;
  EXPECT_THROW(toCloud(seen([](const Vec3& r) { return 1 + 0.5 * r[0]; }, 1e-4), settings),
               std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::depth_image_test
