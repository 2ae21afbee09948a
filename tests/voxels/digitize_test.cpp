// Digitizing against closed forms and an exact oracle: every voxel of convex bodies, volumes,
// centers and inertias, and changes of the mesh that must not change a voxel.
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include "contact/convex_oracle.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::digitize_test {
namespace {

using namespace test;

// For closed meshes: every column must close.
Cloud cloudOf(const Mesh& mesh, double voxelSize, int threads = 2) {
  DigitizeSettings settings;
  settings.voxelSize = voxelSize;
  settings.threads = threads;
  DigitizeReport report;
  const Cloud cloud = digitize(mesh, settings, &report);
  EXPECT_TRUE(report.closed);
  EXPECT_EQ(report.badColumns, 0u);
  EXPECT_EQ(report.undecidedVoxels, 0u);
  return cloud;
}

template <typename Visit>
void forEachVoxel(const Cloud& cloud, Visit&& visit) {
  const Vector3i n = cloud.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) visit(x, y, z, cloud.coverage(x, y, z));
}

// The largest difference between two clouds of the same grid [1/255], and how many voxels differ.
std::pair<int, int> difference(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.bricks(), b.bricks());
  int largest = 0, count = 0;
  forEachVoxel(a, [&](int x, int y, int z, int c) {
    const int d = std::abs(c - b.coverage(x, y, z));
    largest = std::max(largest, d);
    count += d > 0;
  });
  return {largest, count};
}

// Every voxel holds its exact fraction, rounded once: 1/510, plus the rounding of the oracle.
void expectExact(const Mesh& convex, double h) {
  const Cloud cloud = cloudOf(convex, h);
  const std::vector<Plane> planes = planesOf(convex);
  double worst = 0;
  int interface = 0;
  forEachVoxel(cloud, [&](int x, int y, int z, int c) {
    const double truth = commonFraction(planes, cloud.center(x, y, z), h);
    worst = std::max(worst, std::abs(c / 255.0 - truth));
    interface += truth > 0.01 && truth < 0.99;
  });
  EXPECT_GT(interface, 100);
  EXPECT_LT(worst, 1.0 / 510 + 1e-7);
}

TEST(DigitizeExact, TurnedBoxInEveryVoxel) {
  expectExact(moved(boxMesh({-0.5, -0.3, -0.2}, {0.5, 0.3, 0.2}), oddTurn(), {0.2, 0.1, -3}),
              0.043);
}

TEST(DigitizeExact, BoxOffTheGridInEveryVoxel) {
  expectExact(boxMesh({0.013, -0.021, 0.4}, {0.613, 0.35, 0.87}), 0.05);
}

TEST(DigitizeExact, SlantedTetrahedronInEveryVoxel) {
  expectExact(tetrahedronMesh({0, 0, 0}, {1, 0.2, 0.1}, {0.1, 0.9, -0.2}, {0.3, 0.2, 1.1}), 0.07);
}

TEST(DigitizeExact, ThinPlateInEveryVoxel) {
  expectExact(moved(boxMesh({-0.5, -0.5, -0.004}, {0.5, 0.5, 0.004}), oddTurn(), {0, 0, 0}), 0.05);
}

TEST(DigitizeExact, NeedleAcrossManyVoxels) {
  expectExact(tetrahedronMesh({0, 0, 0}, {0.02, 0, 0.01}, {0, 0.03, 0}, {1.3, 0.9, 0.7}), 0.01);
}

// Cut along its length, a bar has layers of bricks without an end face, and walls along them: a
// seventh of each voxel there, a fiftieth at the edges.
TEST(DigitizeExact, LongBarAlongEachAxisInEveryVoxel) {
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d size(0.615, 0.615, 0.615);
    size[axis] = 3.01;
    expectExact(boxMesh(-0.5 * size, 0.5 * size), 0.05);
  }
}

// Faces exactly on voxel faces leave no voxel half full, at any size.
TEST(DigitizeExact, BoxOnTheGridHasNoInterface) {
  for (const double scale : {1.0, 1e-3, 100.0}) {
    const Vector3d half = scale * Vector3d(0.5, 0.75, 0.25);
    const VoxelCounts counts = cloudOf(boxMesh(-half, half), scale / 16).counts();
    EXPECT_EQ(counts.inside, 16u * 24u * 8u) << scale;
    EXPECT_EQ(counts.interface, 0u) << scale;
  }
}

// At every size, however it divides into bricks.
TEST(DigitizeExact, TwoEmptyVoxelsOnEverySide) {
  for (double voxels = 13; voxels < 30; voxels += 0.7) {
    const Cloud cloud = cloudOf(sphereMesh(1, 2), 2 / voxels);
    const Vector3i n = cloud.size();
    forEachVoxel(cloud, [&](int x, int y, int z, int c) {
      const Vector3i v(x, y, z);
      if ((v.array() < 2).any() || ((n - v).array() <= 2).any()) {
        ASSERT_EQ(c, 0) << voxels;
      }
    });
  }
}

// Mass properties of polyhedra and round bodies. The bound on the volume is rigorous: each
// interface voxel is off by at most 1/510.
struct Truth {
  const char* name;
  Mesh mesh;
  double volume;
  Vector3d center;
  Eigen::Matrix3d inertia;
  double tolerance;  // of center and inertia, relative
};

Eigen::Matrix3d boxInertia(const Vector3d& edges) {
  const Vector3d s = edges.cwiseProduct(edges);
  const Vector3d diagonal(s[1] + s[2], s[2] + s[0], s[0] + s[1]);
  return edges.prod() / 12 * Eigen::Matrix3d(diagonal.asDiagonal());
}

std::vector<Truth> truths() {
  std::vector<Truth> all;
  const Vector3d edges(0.97, 0.61, 0.43), shift(0.3, -0.2, 5);
  const Eigen::Quaterniond q = oddTurn();
  const Eigen::Matrix3d turn = q.toRotationMatrix();
  all.push_back({"turned box", moved(boxMesh(-0.5 * edges, 0.5 * edges), q, shift), edges.prod(),
                 shift, turn * boxInertia(edges) * turn.transpose(), 2e-4});
  // The tetrahedron with legs a, b, c along the axes: V = abc / 6, about its center
  // Ixx = V (b^2 + c^2) 3 / 80, Ixy = + V a b / 80 (products enter with a minus).
  const double a = 1.1, b = 0.8, c = 0.9, v = a * b * c / 6;
  Eigen::Matrix3d tet;
  tet << 3 * (b * b + c * c), a * b, a * c, a * b, 3 * (a * a + c * c), b * c, a * c, b * c,
      3 * (a * a + b * b);
  all.push_back({"tetrahedron", tetrahedronMesh({0, 0, 0}, {a, 0, 0}, {0, b, 0}, {0, 0, c}), v,
                 Vector3d(a, b, c) / 4, v / 80 * tet, 5e-4});
  // Level 6: the polyhedron is 4e-4 smaller than the sphere, so compare with its own volume.
  const Mesh sphere = moved(sphereMesh(0.5, 6), q, shift);
  const double ball = inspect(sphere).volume;
  all.push_back(
      {"sphere", sphere, ball, shift, 0.4 * ball * 0.25 * Eigen::Matrix3d::Identity(), 1e-3});
  const int sides = 90;
  const double r = 0.4, height = 1.2;
  const double area = 0.5 * sides * r * r * std::sin(2 * std::numbers::pi / sides);
  // A regular prism: about z, V r^2 / 6 (1 + 2 cos^2(pi / n)).
  const double cosine = std::cos(std::numbers::pi / sides);
  const double iz = area * height * r * r / 6 * (1 + 2 * cosine * cosine);
  const double ix = iz / 2 + area * height * height * height / 12;
  const Eigen::Matrix3d prism = Vector3d(ix, ix, iz).asDiagonal();
  all.push_back({"prism", moved(cylinderMesh(r, height, sides), q, shift), area * height, shift,
                 turn * prism * turn.transpose(), 2e-4});
  return all;
}

TEST(DigitizeMass, ClosedFormsAtEverySize) {
  for (const Truth& truth : truths())
    for (const double scale : {1.0, 1e-3, 100.0}) {
      SCOPED_TRACE(std::string(truth.name) + " x " + std::to_string(scale));
      const double h = 0.021 * scale;
      const Cloud cloud = cloudOf(truth.mesh.scaled(Vector3d::Constant(scale)), h);
      const MassProperties mass = cloud.massProperties();
      const double bound = static_cast<double>(cloud.counts().interface) * h * h * h / 510;
      EXPECT_NEAR(mass.volume, truth.volume * std::pow(scale, 3), bound);
      EXPECT_LT((mass.centerOfMass / scale - truth.center).norm(), 1e-4);
      EXPECT_LT((mass.inertia / std::pow(scale, 5) - truth.inertia).norm(),
                truth.tolerance * truth.inertia.norm());
    }
}

// Eight full voxels along each side: all sums are exact, including the voxels' own inertia.
TEST(DigitizeMass, SmallCubeHasItsExactInertia) {
  const MassProperties mass =
      cloudOf(boxMesh(Vector3d::Constant(-0.5), Vector3d::Constant(0.5)), 0.25).massProperties();
  EXPECT_NEAR(mass.volume, 1, 1e-12);
  EXPECT_LT(mass.centerOfMass.norm(), 1e-12);
  EXPECT_LT((mass.inertia - Eigen::Matrix3d::Identity() / 6).norm(), 1e-12);
}

TEST(DigitizeInvariance, OrderOfTrianglesAndTheirCorners) {
  const Mesh mesh = moved(cylinderMesh(0.4, 1, 37), oddTurn(), {1, 2, 3});
  Mesh other = soup(mesh);
  std::reverse(other.triangles.begin(), other.triangles.end());
  for (Vector3i& t : other.triangles) t = Vector3i(t[1], t[2], t[0]);
  EXPECT_LE(difference(cloudOf(mesh, 0.03), cloudOf(other, 0.03)).first, 1);
}

TEST(DigitizeInvariance, InwardFacingIsReversed) {
  const Mesh mesh = moved(sphereMesh(0.5, 3), oddTurn(), {0, 0, 0});
  EXPECT_LE(difference(cloudOf(mesh, 0.03), cloudOf(turnedInsideOut(mesh), 0.03)).first, 1);
}

TEST(DigitizeInvariance, PlaceAndSize) {
  const Mesh mesh = moved(boxMesh({0, 0, 0}, {1, 0.7, 0.4}), oddTurn(), {0, 0, 0});
  const Cloud cloud = cloudOf(mesh, 0.03);
  const Vector3d shift(0.01234, -7.7, 3.3);
  const Cloud shifted = cloudOf(moved(mesh, Eigen::Quaterniond::Identity(), shift), 0.03);
  EXPECT_LE(difference(cloud, shifted).first, 1);
  EXPECT_LT((shifted.origin() - cloud.origin() - shift).norm(), 1e-9);
  for (const double scale : {1e-3, 100.0})
    EXPECT_LE(
        difference(cloud, cloudOf(mesh.scaled(Vector3d::Constant(scale)), 0.03 * scale)).first, 1);
}

TEST(DigitizeInvariance, SameBytesForAnyNumberOfThreads) {
  const Mesh mesh = joined(moved(sphereMesh(0.5, 4), oddTurn(), {0, 0, 0}),
                           moved(cylinderMesh(0.2, 2, 20), oddTurn(), {0.1, 0, 0}));
  const Cloud one = cloudOf(mesh, 0.02, 1);
  for (const int threads : {2, 3, 7, 0}) {
    const Cloud many = cloudOf(mesh, 0.02, threads);
    EXPECT_EQ(one.voxels().table, many.voxels().table) << threads;
    EXPECT_EQ(one.voxels().coverage, many.voxels().coverage) << threads;
  }
}

TEST(DigitizeInvariance, VolumeUnderRotation) {
  const Mesh mesh = cylinderMesh(0.4, 1, 37);
  const double truth = inspect(mesh).volume, h = 0.05;
  std::mt19937 random(5);
  std::normal_distribution<double> any;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Quaterniond turn(any(random), any(random), any(random), any(random));
    const Cloud cloud = cloudOf(moved(mesh, turn.normalized(), {0, 0, 0.01 * i}), h);
    const double bound = static_cast<double>(cloud.counts().interface) * h * h * h / 510;
    EXPECT_NEAR(cloud.massProperties().volume, truth, bound);
  }
}

// Progress runs up to 1, from the calling thread.
TEST(Digitize, ReportsProgress) {
  DigitizeSettings settings;
  settings.voxelSize = 0.05;
  settings.threads = 1;
  std::vector<double> seen;
  settings.progress = [&](double done) { seen.push_back(done); };
  digitize(sphereMesh(1, 3), settings);
  ASSERT_GT(seen.size(), 2u);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_DOUBLE_EQ(seen.back(), 1);
}

}  // namespace
}  // namespace cloudcontact::digitize_test
