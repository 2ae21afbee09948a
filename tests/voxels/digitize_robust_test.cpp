// Digitizing bodies that are not one closed shell: nested and intersecting shells, surfaces with
// holes, cracks, doubled and reversed triangles, sheets; and input that is refused.
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include <thread>

#include "contact/convex_oracle.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::digitize_robust_test {
namespace {

using namespace test;

Cloud cloudOf(const Mesh& mesh, double voxelSize, DigitizeReport* report = nullptr) {
  DigitizeSettings settings;
  settings.voxelSize = voxelSize;
  return digitize(mesh, settings, report);
}

template <typename Visit>
void forEachVoxel(const Cloud& cloud, Visit&& visit) {
  const Vector3i n = cloud.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) visit(x, y, z, cloud.coverage(x, y, z));
}

// The number of voxels that differ by more than `tolerance` [1/255], and the largest difference.
struct Difference {
  int largest = 0;
  std::size_t count = 0;
};

Difference difference(const Cloud& a, const Cloud& b, int tolerance = 1) {
  EXPECT_EQ(a.bricks(), b.bricks());
  Difference d;
  forEachVoxel(a, [&](int x, int y, int z, int c) {
    const int off = std::abs(c - b.coverage(x, y, z));
    d.largest = std::max(d.largest, off);
    d.count += off > tolerance;
  });
  return d;
}

double volumeOf(const Cloud& cloud) {
  return cloud.massProperties().volume;
}

TEST(DigitizeShells, NestedShellChangesNothing) {
  const Mesh outer = moved(sphereMesh(0.5, 4), oddTurn(), {0, 0, 0});
  const Mesh inner = moved(boxMesh({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}), oddTurn(), {0, 0.05, 0});
  EXPECT_LE(difference(cloudOf(joined(outer, inner), 0.02), cloudOf(outer, 0.02)).largest, 1);
}

TEST(DigitizeShells, CavityStaysEmpty) {
  const Mesh outer = moved(sphereMesh(0.5, 4), oddTurn(), {0, 0, 0});
  const Mesh hole = turnedInsideOut(sphereMesh(0.25, 4));
  const Cloud cloud = cloudOf(joined(outer, hole), 0.02);
  EXPECT_NEAR(volumeOf(cloud), inspect(outer).volume + inspect(hole).volume, 1e-4);
  const Vector3i middle = cloud.size() / 2;
  EXPECT_EQ(cloud.coverage(middle[0], middle[1], middle[2]), 0);
}

TEST(DigitizeShells, StrayBodyThatFacesInwardIsReversed) {
  const Mesh a = sphereMesh(0.5, 3), b = moved(sphereMesh(0.3, 3), oddTurn(), {1, 0, 0});
  EXPECT_LE(
      difference(cloudOf(joined(a, turnedInsideOut(b)), 0.03), cloudOf(joined(a, b), 0.03)).largest,
      1);
}

// Two boxes that overlap and share the planes of four faces, none on a voxel face: there the shares
// of the shells must not add up.
TEST(DigitizeShells, CoplanarFacesCountOnce) {
  const double h = 0.05;
  const Mesh left = boxMesh({0, 0, 0}, {0.613, 0.437, 0.331});
  const Mesh right = boxMesh({0.4, 0, 0}, {1.013, 0.437, 0.331});
  const Mesh both = boxMesh({0, 0, 0}, {1.013, 0.437, 0.331});
  EXPECT_LE(difference(cloudOf(joined(left, right), h), cloudOf(both, h)).largest, 1);
}

// Two bodies that touch in a plane inside a voxel make one body without a seam.
TEST(DigitizeShells, TouchingBodiesHaveNoSeam) {
  const double h = 0.05;
  const Mesh left = boxMesh({0, 0, 0}, {0.5, 0.437, 0.331});
  const Mesh right = boxMesh({0.5, 0, 0}, {1.013, 0.437, 0.331});
  const Mesh both = boxMesh({0, 0, 0}, {1.013, 0.437, 0.331});
  EXPECT_LE(difference(cloudOf(joined(left, right), h), cloudOf(both, h)).largest, 1);
}

// Intersecting boxes, against the exact union: vol A + vol B - vol (A and B) in each voxel.
TEST(DigitizeShells, CrossingBoxesAreUnited) {
  const double h = 0.06;
  const Mesh a = moved(boxMesh({-0.5, -0.2, -0.2}, {0.5, 0.2, 0.2}), oddTurn(), {0, 0, 0});
  const Mesh b = boxMesh({-0.21, -0.17, -0.6}, {0.19, 0.23, 0.5});
  const std::vector<Plane> inA = planesOf(a), inB = planesOf(b);
  std::vector<Plane> inBoth = inA;
  inBoth.insert(inBoth.end(), inB.begin(), inB.end());
  const Cloud cloud = cloudOf(joined(a, b), h);
  double worst = 0, worstAlone = 0, sum = 0;
  forEachVoxel(cloud, [&](int x, int y, int z, int c) {
    const Vector3d p = cloud.center(x, y, z);
    const double fa = commonFraction(inA, p, h), fb = commonFraction(inB, p, h);
    const double error = c / 255.0 - (fa + fb - commonFraction(inBoth, p, h));
    const bool alone = fa < 1e-9 || fb < 1e-9 || fa > 1 - 1e-9 || fb > 1 - 1e-9;
    (alone ? worstAlone : worst) = std::max(alone ? worstAlone : worst, std::abs(error));
    sum += error * h * h * h;
  });
  EXPECT_LT(worstAlone, 1.0 / 510 + 1e-7);
  EXPECT_LT(worst, 0.04);
  EXPECT_LT(std::abs(sum), 3e-4);
}

// One shell that winds twice around its middle: a prism over a pentagram with ends off the grid.
TEST(DigitizeShells, ShellAroundItself) {
  const double r = 0.5, height = 0.413, h = 0.03;
  Mesh star = cylinderMesh(r, height, 5);
  for (int i = 0; i < 5; ++i)
    for (int end = 0; end < 2; ++end) {
      const double angle = 2 * std::numbers::pi * 2 * i / 5;
      Vector3d& v = star.vertices[2 * i + end];
      v = {r * std::cos(angle), r * std::sin(angle), v[2]};
    }
  // The union is a ten-cornered star, its inner corners at r cos 72 / cos 36.
  const double degree = std::numbers::pi / 180;
  const double inner = r * std::cos(72 * degree) / std::cos(36 * degree);
  const double truth = 5 * r * inner * std::sin(36 * degree) * height;
  ASSERT_GT(inspect(star).volume, 1.2 * truth);  // which counts the middle twice
  EXPECT_NEAR(volumeOf(cloudOf(star, h)), truth, 2e-3 * truth);
}

TEST(DigitizeOpen, MissingTrianglesAreFilled) {
  const Mesh sphere = moved(sphereMesh(0.5, 5), oddTurn(), {0, 0, 0});
  const double truth = inspect(sphere).volume;
  const Cloud whole = cloudOf(sphere, 0.02);
  for (const int holes : {1, 5, 40, 200}) {
    DigitizeReport report;
    const Cloud cloud = cloudOf(withHoles(sphere, holes, 7), 0.02, &report);
    EXPECT_NEAR(volumeOf(cloud), truth, 1e-3 * truth) << holes;
    EXPECT_LT(difference(cloud, whole).count, 20u * static_cast<unsigned>(holes)) << holes;
    EXPECT_FALSE(report.closed);
    EXPECT_GT(report.badColumns, 0u);
  }
}

// Three of ten triangles are missing: too many to cap, so the axes and the winding number vote.
TEST(DigitizeOpen, SurfaceWithAThirdMissing) {
  const Mesh sphere = moved(sphereMesh(0.5, 4), oddTurn(), {0, 0, 0});
  const double truth = inspect(sphere).volume;
  DigitizeReport report;
  const Cloud cloud = cloudOf(withHoles(sphere, 600, 3), 0.04, &report);
  EXPECT_NEAR(volumeOf(cloud), truth, 0.03 * truth);
  EXPECT_GT(report.undecidedVoxels, 0u);
  // No streaks: nothing outside, nothing missing deep inside.
  forEachVoxel(cloud, [&](int x, int y, int z, int c) {
    const double r = cloud.center(x, y, z).norm();
    if (r > 0.5 + 0.06) {
      ASSERT_EQ(c, 0) << r;
    }
    if (r < 0.5 - 0.08) {
      ASSERT_GE(c, 240) << r;  // nearer to a hole than to the surface
    }
  });
}

TEST(DigitizeOpen, BoxWithoutItsLid) {
  Mesh box = boxMesh({0, 0, 0}, {1, 0.7, 0.41});
  const Cloud whole = cloudOf(box, 0.03);
  box.triangles.erase(box.triangles.begin() + 2, box.triangles.begin() + 4);  // z high
  const Cloud open = cloudOf(box, 0.03);
  EXPECT_LE(difference(open, whole, 40).count, 4u);  // the corners of the opening
  EXPECT_NEAR(volumeOf(open), volumeOf(whole), 2e-3 * volumeOf(whole));
}

// Six faces with small gaps, each meshed differently: every edge is open, yet they form a body.
TEST(DigitizeOpen, PatchesWithCracksBetweenThem) {
  const double gap = 1e-5;
  Mesh box;
  for (int k = 0; k < 3; ++k)
    for (const double side : {-0.5, 0.5}) {
      Mesh face = moved(sheetMesh(1 - gap, 2 + k + (side > 0)), Eigen::Quaterniond::Identity(),
                        {-0.5 + gap / 2, -0.5 + gap / 2, 0});
      // The sheet faces along z; rotate that to axis k, in either direction.
      const Vector3d about =
          k == 2 ? Vector3d::UnitX() : Vector3d::UnitZ().cross(Vector3d::Unit(k));
      const double angle = (k == 2 ? side - 0.5 : side) * std::numbers::pi;
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, about));
      box = joined(box, moved(face, turn, side * Vector3d::Unit(k)));
    }
  const Mesh turned = moved(box, oddTurn(), {0, 0, 0});
  EXPECT_EQ(inspect(turned).openEdges, 4u * (2 + 3 + 3 + 4 + 4 + 5));
  // Voxels much smaller and much larger than the crack.
  for (const double h : {0.03, 0.0004 / gap * 1e-3})
    EXPECT_NEAR(volumeOf(cloudOf(turned, h)), 1, 1e-3) << h;
}

// Triangles that nearly meet, as exporters that round coordinates leave them.
TEST(DigitizeOpen, SoupWithHairlineCracks) {
  const Mesh sphere = moved(sphereMesh(0.5, 3), oddTurn(), {0, 0, 0});
  const double truth = inspect(sphere).volume, h = 0.03;
  for (const double gap : {1e-9, 1e-6, 1e-4}) {
    Mesh cracked = soup(sphere);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> jitter(-gap, gap);
    for (Vector3d& v : cracked.vertices)
      v += Vector3d(jitter(random), jitter(random), jitter(random));
    const Cloud cloud = cloudOf(cracked, h);
    EXPECT_NEAR(volumeOf(cloud), truth, 1e-3 * truth) << gap;
    EXPECT_LE(difference(cloud, cloudOf(sphere, h)).largest, 64) << gap;
  }
}

TEST(DigitizeOpen, TJunctionsAndSliversLeaveNoStreak) {
  // A vertex on an edge of the top that only one side uses.
  Mesh box = boxMesh({0, 0, 0}, {1, 0.7, 0.41});
  box.vertices.emplace_back(0.37, 0, 0.41);
  box.triangles[2] = {4, 8, 6};
  box.triangles.insert(box.triangles.begin() + 3, Vector3i(8, 5, 6));
  const Mesh turned = moved(box, oddTurn(), {0, 0, 0});
  ASSERT_EQ(inspect(turned).openEdges, 3u);
  const Mesh plain = moved(boxMesh({0, 0, 0}, {1, 0.7, 0.41}), oddTurn(), {0, 0, 0});
  EXPECT_LE(difference(cloudOf(turned, 0.03), cloudOf(plain, 0.03)).largest, 1);
}

TEST(DigitizeOpen, ReversedAndDoubledTriangles) {
  const Mesh sphere = moved(sphereMesh(0.5, 4), oddTurn(), {0, 0, 0});
  const Cloud truth = cloudOf(sphere, 0.03);
  Mesh turned = sphere;
  std::mt19937 random(11);
  for (Vector3i& t : turned.triangles)
    if (random() % 10 == 0) std::swap(t[1], t[2]);
  EXPECT_LE(difference(cloudOf(turned, 0.03), truth).largest, 1);
  Mesh doubled = sphere;
  for (std::size_t t = 0; t < sphere.triangles.size(); t += 3)
    doubled.triangles.push_back(sphere.triangles[t]);
  EXPECT_LE(difference(cloudOf(doubled, 0.03), truth).largest, 1);
  EXPECT_LE(difference(cloudOf(joined(sphere, sphere), 0.03), truth).largest, 1);
  EXPECT_LE(difference(cloudOf(joined(sphere, turnedInsideOut(sphere)), 0.03), truth).largest, 1);
  Mesh junk = sphere;  // lines and points
  junk.triangles.insert(junk.triangles.end(), {{0, 0, 5}, {7, 7, 7}});
  EXPECT_LE(difference(cloudOf(junk, 0.03), truth).largest, 1);
}

TEST(DigitizeSheet, ShellHasTheSheetsVolume) {
  const double thickness = 0.083;
  const Mesh flat = moved(sheetMesh(1, 7), oddTurn(), {0, 0, 0});
  const Mesh thick = shell(flat, thickness);
  EXPECT_TRUE(inspect(thick).closed());
  EXPECT_NEAR(volumeOf(cloudOf(thick, 0.04)), thickness, 1e-3 * thickness);
}

struct BadInput {
  const char* name;
  Mesh mesh;
  double voxelSize;
  int threads;
  const char* message;
};

TEST(DigitizeRefuses, BadInput) {
  const double nan = std::nan(""), inf = INFINITY;
  const Mesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  Mesh nanVertex = box, infVertex = box, badIndex = box, negativeIndex = box, point = box;
  nanVertex.vertices[3][1] = nan;
  infVertex.vertices[3][1] = -inf;
  badIndex.triangles[5][2] = 8;
  negativeIndex.triangles[5][0] = -1;
  for (Vector3d& v : point.vertices) v.setZero();
  const std::vector<BadInput> table = {
      {"zero size", box, 0, 0, "voxelSize is 0, must be positive"},
      {"negative size", box, -1, 0, "voxelSize is -1"},
      {"NaN size", box, nan, 0, "must be positive and finite"},
      {"infinite size", box, inf, 0, "must be positive and finite"},
      {"negative threads", box, 0.1, -1, "threads"},
      {"no mesh", Mesh(), 0.1, 0, "no triangles"},
      {"vertices alone", Mesh{box.vertices, {}}, 0.1, 0, "no triangles"},
      {"NaN vertex", nanVertex, 0.1, 0, "vertex 3 is NaN or infinite"},
      {"infinite vertex", infVertex, 0.1, 0, "vertex 3 is NaN or infinite"},
      {"index too high", badIndex, 0.1, 0, "triangle 5 names vertex 8, but there are 8"},
      {"negative index", negativeIndex, 0.1, 0, "triangle 5 names vertex -1"},
      {"a point", point, 0.1, 0, "a line or a point"},
      {"a sheet", sheetMesh(1, 5), 0.1, 0, "shell()"},
      {"two sheets", joined(sheetMesh(1, 5), moved(sheetMesh(1, 5), oddTurn(), {3, 0, 0})), 0.1, 0,
       "shell()"},
      {"a flat box", boxMesh({0, 0, 0}, {1, 1, 0}), 0.1, 0, "shell()"},
      {"one triangle", Mesh{box.vertices, {{0, 1, 2}}}, 0.1, 0, "shell()"},
      {"too small for the voxel", box, 100, 0, "choose a smaller voxelSize"},
  };
  for (const BadInput& bad : table) {
    DigitizeSettings settings;
    settings.voxelSize = bad.voxelSize;
    settings.threads = bad.threads;
    try {
      digitize(bad.mesh, settings);
      ADD_FAILURE() << bad.name << " was accepted";
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(bad.message), std::string::npos)
          << bad.name << ": " << e.what();
    }
  }
}

// The refusal names a size that fits, and that size does fit.
TEST(DigitizeRefuses, TooManyVoxelsAndNamesASizeThatFits) {
  const Mesh sphere = sphereMesh(1, 4);
  for (const double h : {1e-3, 1e-6, 1e-12, 1e-200}) {
    DigitizeSettings settings;
    settings.voxelSize = h;
    settings.maxBytes = 20'000'000;
    std::string message;
    try {
      digitize(sphere, settings);
    } catch (const std::length_error& e) {
      message = e.what();
    }
    const std::string before = "voxelSize of ";
    const std::size_t at = message.find(before);
    ASSERT_NE(at, std::string::npos) << h << ": " << message;
    settings.voxelSize = std::stod(message.substr(at + before.size()));
    const Cloud cloud = digitize(sphere, settings);
    EXPECT_LE(cloud.bytes(), settings.maxBytes);
    EXPECT_GT(cloud.bytes(), settings.maxBytes / 50);  // the named size is not needlessly coarse
  }
}

TEST(DigitizeRefuses, EstimateIsAnUpperBoundAndNotAbsurd) {
  // The cutter of each core: 214 kB at the smallest voxel here. With two cores the bound is 4 MB.
  const std::size_t scratch = 250'000 * std::max(1u, std::thread::hardware_concurrency());
  const Mesh sphere = moved(sphereMesh(1, 4), oddTurn(), {0, 0, 0});
  for (const double h : {0.2, 0.05, 0.01}) {
    const std::size_t bytes = cloudOf(sphere, h).bytes(), estimate = digitizeBytes(sphere, h);
    EXPECT_GE(estimate, bytes);
    EXPECT_LE(estimate, 4 * bytes + 3'500'000 + scratch);
  }
  EXPECT_THROW(digitizeBytes(sphere, 0), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::digitize_robust_test
