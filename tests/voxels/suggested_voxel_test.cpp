// The voxel that a mesh gets where none is stated: a hundredth of the diagonal, finer where the
// body is walls and grooves, the same for the same body however it is placed.
#include <cloudcontact/base/pose.h>
#include <cloudcontact/voxels/digitize.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/test_meshes.h"
#include "mesh/turned_mesh.h"

namespace cloudcontact::suggested_voxel_test {
namespace {

using namespace test;

double diagonalOf(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  return box.diagonal().norm();
}

// The voxel in hundredths of the diagonal.
double share(const Mesh& mesh) {
  return suggestedVoxel(mesh) / (0.01 * diagonalOf(mesh));
}

Mesh plate(double thickness) {
  return boxMesh({0, 0, 0}, {1, 1, thickness});
}

// A rod about z with ribs `pitch` apart, whose flanks lean as those of a thread.
Mesh ribbedRod(double radius, double height, double pitch) {
  std::vector<std::pair<double, double>> profile = {{0, 0}};
  const double depth = pitch / 2 * std::sqrt(3.0);
  for (int k = 0; k * pitch < height; ++k) {
    profile.emplace_back(radius - depth, k * pitch);
    profile.emplace_back(radius, (k + 0.5) * pitch);
  }
  profile.emplace_back(radius - depth, height);
  profile.emplace_back(0, height);
  return turnedMesh(profile, 96);
}

TEST(SuggestedVoxel, IsAHundredthOfAThickBodysDiagonal) {
  EXPECT_DOUBLE_EQ(share(plate(1)), 1);
  EXPECT_DOUBLE_EQ(share(plate(0.1)), 1);
  EXPECT_DOUBLE_EQ(share(sphereMesh(0.3, 4)), 1);
  EXPECT_DOUBLE_EQ(share(roundMesh(0.2, 1, 64)), 1);
  EXPECT_DOUBLE_EQ(share(coneMesh(0.3, 0.5, 64)), 1);
}

TEST(SuggestedVoxel, PutsTwoIntoAWall) {
  for (const double thickness : {0.016, 0.02, 0.027})
    EXPECT_NEAR(suggestedVoxel(plate(thickness)), thickness / 2, 1e-12);
  EXPECT_NEAR(share(plate(0.001)), 0.5, 1e-12);  // no finer
}

TEST(SuggestedVoxel, PutsTenIntoAPitch) {
  std::vector<NamedMesh> plates;
  for (int k = 0; k < 4; ++k)
    plates.push_back({"plate", boxMesh({0, 0, 0.1 * k}, {1, 1, 0.1 * k + 0.06})});
  EXPECT_NEAR(suggestedVoxel(merged(plates)), 0.1 / 10, 1e-12);
  EXPECT_DOUBLE_EQ(share(ribbedRod(0.25, 1, 0.2)), 1);
  // Sharp crests are thin walls, too.
  const double ribbed = suggestedVoxel(ribbedRod(0.25, 1, 0.1));
  EXPECT_GT(ribbed, 0.7 * 0.1 / 10);
  EXPECT_LT(ribbed, 1.03 * 0.1 / 10);
  EXPECT_DOUBLE_EQ(share(ribbedRod(0.25, 1, 0.03)), 0.5);
}

TEST(SuggestedVoxel, IsThatOfTheBodyAndNotOfItsPlace) {
  for (const Mesh& mesh : {plate(0.02), ribbedRod(0.25, 1, 0.1)}) {
    const double voxel = suggestedVoxel(mesh);
    for (const double scale : {1e-3, 1e3}) {
      Mesh scaled = mesh;
      for (Vec3& v : scaled.vertices) v = scale * v + scale * Vec3(3, -5, 7);
      EXPECT_NEAR(suggestedVoxel(scaled), scale * voxel, 1e-3 * scale * voxel);
    }
    // Lines meet a turned body's walls at a slant, at 40 deg at most for the nearest axis.
    Mesh turned = mesh;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
    for (Vec3& v : turned.vertices) v = turn * v;
    EXPECT_LT(suggestedVoxel(turned), 1.4 * voxel);
    EXPECT_LT(share(turned), 0.95);
  }
}

TEST(SuggestedVoxel, RefusesWhatHasNoSize) {
  EXPECT_THROW(suggestedVoxel(Mesh{}), std::invalid_argument);
  Mesh broken = plate(1);
  broken.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(suggestedVoxel(broken), std::invalid_argument);
  broken = plate(1);
  broken.vertices[0].x() = 1.7e308;
  broken.vertices[6].x() = -1.7e308;
  EXPECT_THROW(suggestedVoxel(broken), std::invalid_argument);
  broken = plate(1);
  broken.triangles[0][0] = 99;
  EXPECT_THROW(suggestedVoxel(broken), std::invalid_argument);
}

TEST(SuggestedVoxel, OfFacesWithoutEndIsTheHundredth) {
  Mesh pile = plate(0.01);
  const std::vector<Eigen::Vector3i> once = pile.triangles;
  while (pile.triangles.size() < 10000)
    pile.triangles.insert(pile.triangles.end(), once.begin(), once.end());
  EXPECT_DOUBLE_EQ(share(pile), 1);
}

}  // namespace
}  // namespace cloudcontact::suggested_voxel_test
