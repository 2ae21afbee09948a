// The measured penetration against closed forms.
#include <cloudcontact/mesh/mesh_repair.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "scene/generated_mesh.h"
#include "scene/penetration.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program::sim_penetration_test {
namespace {

Mesh boxMesh(const Vec3& size) {
  return primitiveMesh(Box{size / 2}, 1e-3);
}

MeasuredBody bodyOf(const SceneGeometry& geometry, const Mesh* mesh = nullptr) {
  return {{{probed(geometry, mesh), Pose()}}};
}

Pose at(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), Vec3(x, y, z)};
}

// Depth in a box, from its sides.
double boxDepth(const Vec3& half, const Vec3& p) {
  const Vec3 out = p.cwiseAbs() - half;
  if (out.maxCoeff() <= 0) return -out.maxCoeff();
  return -out.cwiseMax(0).norm();
}

TEST(MeshDistanceTest, OfABoxIsTheBoxesAtEveryPoint) {
  const Vec3 half(0.5, 1, 1.5);
  const MeshDistance mesh(boxMesh(2 * half));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    ASSERT_NEAR(mesh.depth(p, 10), boxDepth(half, p), 1e-12) << p.transpose();
  }
}

// Concave, with points whose closest feature is an edge or corner, inside and outside.
TEST(MeshDistanceTest, SignsOfAConcaveBodyAreThoseOfItsWindingNumber) {
  const MeshDistance mesh(holeMesh(0.4, 2, 1, 0.2, 24));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  int inside = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    const double winding = mesh.winding(p);
    ASSERT_NEAR(winding, std::round(winding), 1e-9);
    ASSERT_EQ(mesh.depth(p, 10) > 0, winding > 0.5) << p.transpose();
    inside += winding > 0.5;
  }
  EXPECT_GT(inside, 500);
}

TEST(MeshDistanceTest, ASlitDoesNotTurnInsideOut) {
  const Vec3 half(1, 1, 1);
  Mesh slit = boxMesh(2 * half);
  // A sliver is missing along one edge, so its two neighbors are not connected.
  slit.vertices.push_back(slit.vertices[slit.triangles[0][0]]);
  slit.vertices.back() *= 1 - 1e-9;
  slit.triangles[0][0] = static_cast<int>(slit.vertices.size()) - 1;
  ASSERT_FALSE(inspect(slit).closed());
  const MeshDistance mesh(slit);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    ASSERT_NEAR(mesh.depth(p, 10), boxDepth(half, p), 1e-6) << p.transpose();
  }
}

TEST(Penetration, OfTwoSpheresIsTheRadiiLessTheDistance) {
  const MeasuredBody a = bodyOf(SceneSphere{1}), b = bodyOf(SceneSphere{0.5});
  EXPECT_NEAR(penetration(a, at(1, 2, 3), b, at(1, 2, 4.4)), 0.1, 1e-12);
  EXPECT_EQ(penetration(a, at(1, 2, 3), b, at(1, 2, 4.6)), 0);
}

TEST(Penetration, OfASphereInABoxIsThatOfItsLowestPoint) {
  const Mesh mesh = boxMesh(Vec3(2, 2, 2));
  const MeasuredBody sphere = bodyOf(SceneSphere{0.5});
  for (const MeasuredBody& box :
       {bodyOf(SceneBox{Vec3(2, 2, 2)}, &mesh), bodyOf(SceneMesh{}, &mesh)}) {
    EXPECT_NEAR(penetration(box, Pose(), sphere, at(0.2, 0.1, 1.4)), 0.1, 1e-12);
    EXPECT_NEAR(penetration(sphere, at(0.2, 0.1, 1.4), box, Pose()), 0.1, 1e-12);
    // Off a corner by (0.2, 0.2, 0.2).
    EXPECT_NEAR(penetration(box, Pose(), sphere, at(1.2, 1.2, 1.2)), 0.5 - 0.2 * std::sqrt(3.0),
                1e-12);
    EXPECT_EQ(penetration(box, Pose(), sphere, at(1.3, 1.3, 1.3)), 0);
  }
}

TEST(Penetration, OfABoxStandingOnItsCornerInAPlane) {
  const Mesh mesh = boxMesh(Vec3(1, 1, 1));
  const MeasuredBody box = bodyOf(SceneBox{Vec3(1, 1, 1)}, &mesh), plane = bodyOf(ScenePlane{});
  const auto onCorner = shortestTurn(Vec3(-1, -1, -1), Vec3(0, 0, -1));
  const double reach = std::sqrt(3.0) / 2;
  EXPECT_NEAR(penetration(plane, Pose(), box, {onCorner, Vec3(5, 6, reach - 0.07)}), 0.07, 1e-12);
  EXPECT_EQ(penetration(plane, Pose(), box, {onCorner, Vec3(5, 6, reach + 0.01)}), 0);
}

TEST(Penetration, OfACapsuleAndACylinderLyingOnAPlane) {
  const MeasuredBody plane = bodyOf(ScenePlane{}), capsule = bodyOf(SceneCapsule{0.2, 1});
  const Eigen::Quaterniond lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  EXPECT_NEAR(penetration(plane, Pose(), capsule, {lying, Vec3(0, 0, 0.15)}), 0.05, 1e-12);
  const Mesh mesh = primitiveMesh(Cylinder{0.2, 0.5}, 1e-5);
  const MeasuredBody cylinder = bodyOf(SceneCylinder{0.2, 1}, &mesh);
  EXPECT_NEAR(penetration(plane, Pose(), cylinder, {lying, Vec3(0, 0, 0.15)}), 0.05, 2e-5);
  EXPECT_NEAR(penetration(capsule, {lying, Vec3(0, 0, 0.35)}, cylinder, {lying, Vec3::Zero()}),
              0.05, 2e-5);
}

// In front of the tip, the slant, the rim and the base, and inside: as in the cone's mesh.
TEST(Penetration, OfAConeIsThatOfItsMesh) {
  const Mesh mesh = primitiveMesh(Cone{0.5, 0.6}, 1e-5);
  const MeasuredSolid cone = SceneCone{0.5, 1.2};
  const MeshDistance distance(mesh);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    ASSERT_NEAR(depthIn(cone, p, 10), distance.depth(p, 10), 3e-5) << p.transpose();
  }
  EXPECT_NEAR(depthIn(cone, Vec3(0, 0, 0.7), 1), -0.1, 1e-12);
  EXPECT_NEAR(depthIn(cone, Vec3(0.5 + 0.03, 0, -0.6 - 0.04), 1), -0.05, 1e-12);
  EXPECT_NEAR(depthIn(cone, Vec3(0, 0, -0.5), 1), 0.1, 1e-12);
}

// No vertex of either is inside the other: only points on the faces find the overlap.
TEST(Penetration, OfCrossedBarsIsFoundBetweenVertices) {
  const Mesh mesh = boxMesh(Vec3(0.2, 0.2, 4));
  const MeasuredBody bar = bodyOf(SceneMesh{}, &mesh);
  const Pose across{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX())),
                    Vec3(0.17, 0, 0)};
  EXPECT_NEAR(penetration(bar, Pose(), bar, across), 0.03, 1e-12);
}

// Blocks of probes that are left out hold none that counts.
TEST(Penetration, IsTheDeepestOfAllProbes) {
  const Mesh hole = holeMesh(0.4, 2, 1, 0.2, 24), box = boxMesh(Vec3(0.3, 0.5, 1));
  const SceneGeometry kinds[] = {SceneMesh{}, SceneBox{Vec3(0.3, 0.5, 1)}, SceneCapsule{0.2, 0.8}};
  const Mesh* const meshes[] = {&hole, &box, nullptr};
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    const int k = i % 3, l = i / 3 % 3;
    const MeasuredBody a = bodyOf(kinds[k], meshes[k]), b = bodyOf(kinds[l], meshes[l]);
    const auto any = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
    const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(3 * uniform(random), any().normalized())),
                    any()};
    double expected = 0;
    const auto take = [&](const Probed& from, const Pose& to, const Probed& in) {
      for (const Probe& probe : from.probes)
        expected = std::max(
            expected, depthIn(in.solid, to.toWorld(probe.position), probe.radius) + probe.radius);
    };
    take(*a.parts[0].what, pose, *b.parts[0].what);
    take(*b.parts[0].what, pose.inverse(), *a.parts[0].what);
    EXPECT_NEAR(penetration(a, pose, b, Pose()), expected, 1e-12) << i;
    touching += expected > 0;
  }
  EXPECT_GT(touching, 50);
}

TEST(Penetration, ACompoundsPartsAllCount) {
  const Mesh mesh = boxMesh(Vec3(1, 1, 1));
  MeasuredBody dumbbell;
  const auto part = probed(SceneMesh{}, &mesh);
  dumbbell.parts = {{part, at(-2, 0, 0)}, {part, at(2, 0, 0)}};
  const MeasuredBody plane = bodyOf(ScenePlane{});
  const Pose tipped{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY())),
                    Vec3(0, 0, 2.4)};
  EXPECT_NEAR(penetration(dumbbell, tipped, plane, Pose()), 0.1, 1e-12);
}

}  // namespace
}  // namespace cloudcontact::program::sim_penetration_test
