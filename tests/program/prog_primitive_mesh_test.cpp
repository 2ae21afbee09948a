// Meshes of primitives: closed, with the right volume and bounds, within the tolerance of the
// surface.
#include <cloudcontact/mesh/mesh_repair.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "scene/primitive_mesh.h"

namespace prog_primitive_mesh_test {
namespace {

using namespace cloudcontact;
using program::primitiveMesh;
using std::numbers::pi;

struct Primitive {
  std::string name;
  Solid shape;
  double volume;
};

std::vector<Primitive> primitives(double size) {
  const double r = 0.7 * size, h = 0.4 * size;  // h is half a height
  const Vec3 half = size * Vec3(0.3, 0.5, 0.8);
  return {{"sphere", Sphere{r}, 4 * pi / 3 * r * r * r},
          {"box", Box{half}, 8 * half.prod()},
          {"cylinder", Cylinder{r, h}, pi * r * r * 2 * h},
          {"capsule", Capsule{r, h}, pi * r * r * 2 * h + 4 * pi / 3 * r * r * r},
          {"cone", Cone{r, h}, pi * r * r * 2 * h / 3}};
}

TEST(PrimitiveMesh, IsClosedAndHasTheShapesVolume) {
  for (double size : {0.001, 1.0, 100.0})
    for (const Primitive& p : primitives(size)) {
      SCOPED_TRACE(p.name);
      const MeshReport report = inspect(primitiveMesh(p.shape, 1e-4 * size));
      EXPECT_TRUE(report.closed());
      EXPECT_EQ(report.degenerateTriangles, 0U);
      // The volume is signed, so this checks the orientation too.
      EXPECT_NEAR(report.volume / p.volume, 1, 3e-4);
    }
}

// Checks corners, edge middles and face middles, where a facet is farthest from a curved surface.
TEST(PrimitiveMesh, LiesWithinTheToleranceOfTheSurface) {
  for (double tolerance : {1e-2, 1e-3, 1e-4})
    for (const Primitive& p : primitives(1)) {
      SCOPED_TRACE(p.name);
      const Mesh mesh = primitiveMesh(p.shape, tolerance);
      double worst = 0;
      for (const Eigen::Vector3i& t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
        for (const Vec3& x : {a, Vec3((a + b) / 2), Vec3((a + b + c) / 3)})
          worst = std::max(worst, std::abs(solidAt(p.shape, x).depth));
      }
      EXPECT_LE(worst, tolerance);
    }
}

TEST(PrimitiveMesh, StaysSmallWhereTheToleranceIsTiny) {
  for (const Primitive& p : primitives(1))
    EXPECT_LE(primitiveMesh(p.shape, 1e-12).triangles.size(), 330'000U) << p.name;
}

TEST(PrimitiveMesh, RefusesAHalfSpace) {
  EXPECT_THROW(primitiveMesh(HalfSpace{}, 0.01), std::invalid_argument);
}

}  // namespace

}  // namespace prog_primitive_mesh_test
