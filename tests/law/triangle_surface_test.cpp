// The signed distance to triangles, against sums over all triangles and the solid angle.
#include <gtest/gtest.h>

#include "contact/contact_cases.h"
#include "law/triangle_point.h"
#include "law/triangle_surface.h"
#include "mesh/test_meshes.h"

#include <cmath>
#include <limits>
#include <thread>

namespace cloudcontact::testing::triangle_surface_test {
namespace {

std::vector<double> cornersOf(const Mesh& mesh) {
  std::vector<double> corners;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) corners.push_back(mesh.vertices[std::size_t(t[k])][i]);
  return corners;
}

TriangleSurface surfaceOf(const Mesh& mesh) {
  TriangleSurface surface;
  const double far = 100;
  surface.build(cornersOf(mesh), {Vec3::Constant(-far), Vec3::Constant(far)});
  return surface;
}

// 1 inside a closed mesh that faces outward, 0 outside (van Oosterom and Strackee 1983).
double winding(const Mesh& mesh, const Vec3& x) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[std::size_t(t[0])] - x, b = mesh.vertices[std::size_t(t[1])] - x,
               c = mesh.vertices[std::size_t(t[2])] - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum +=
        std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

double distanceTo(const Mesh& mesh, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) -> const Vec3& { return mesh.vertices[std::size_t(t[k])]; };
    Vec3 foot;
    nearestOnTriangle(corner(0), corner(1), corner(2), x, foot);
    least = std::min(least, (x - foot).norm());
  }
  return least;
}

// Over a lattice of places on the triangle: at least the true distance.
double sampledDistance(const Mesh& mesh, const Vec3& x, int n) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles)
    for (int i = 0; i <= n; ++i)
      for (int k = 0; k <= n - i; ++k) {
        const Vec3 at =
            (mesh.vertices[std::size_t(t[0])] * i + mesh.vertices[std::size_t(t[1])] * k +
             mesh.vertices[std::size_t(t[2])] * (n - i - k)) /
            n;
        least = std::min(least, (x - at).norm());
      }
  return least;
}

Mesh needle() {  // corners of 10 deg
  return test::tetrahedronMesh({0, 0, 0}, {1, 0, 0}, {1, 0.2, 0}, {1, 0.1, 0.15});
}

TEST(TriangleSurface, SignIsThatOfTheWindingNumber) {
  const Mesh meshes[] = {needle(), test::boxMesh({0, 0, 0}, {1, 0.2, 0.1}),
                         test::sphereMesh(0.5, 2),
                         test::joined(needle(), test::boxMesh({2, 0, 0}, {3, 1, 1}))};
  Random random(1);
  for (const Mesh& mesh : meshes) {
    const TriangleSurface surface = surfaceOf(mesh);
    for (int i = 0; i < 5000; ++i) {
      const Vec3 x = 1.6 * random.inCube() - Vec3::Constant(0.3);
      const SolidPoint p = surface.at(x);
      EXPECT_EQ(p.depth > 0, winding(mesh, x) > 0.5) << x.transpose();
      EXPECT_NEAR(p.normal.norm(), 1, 1e-9);
      EXPECT_NEAR(surface.at(Vec3(x + p.depth * p.normal)).depth, 0, 1e-9);
    }
  }
}

TEST(TriangleSurface, DistanceIsTheLeast) {
  const Mesh mesh = test::sphereMesh(0.5, 1);
  const TriangleSurface surface = surfaceOf(mesh);
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Vec3 x = 1.6 * random.inCube() - Vec3::Constant(0.8);
    const double found = std::abs(surface.at(x).depth), sampled = sampledDistance(mesh, x, 24);
    EXPECT_LE(found, sampled + 1e-12);
    EXPECT_GT(found, sampled - 0.02);
  }
}

// A search begins where the last one nearby has ended.
TEST(TriangleSurface, WhatWasAskedBeforeDoesNotShow) {
  const TriangleSurface surface = surfaceOf(test::sheetMesh(1, 8));
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    // Places over corners and edges are equally near to several triangles.
    Vec3 x = random.inCube();
    if (i % 2) x.head<2>() = (8 * x.head<2>()).array().round() / 8;
    const SolidPoint plain = surface.at(x);
    for (int before = 0; before < 8; ++before) {
      surface.at(Vec3(x + 0.2 * random.inCube() - Vec3::Constant(0.1)));
      const SolidPoint p = surface.at(x);
      EXPECT_EQ(p.depth, plain.depth);
      EXPECT_EQ(p.normal, plain.normal);
    }
  }
}

// Bumps, ditches of flat walls, a plate's two sides and a thin fin: a face that is surely the
// nearest is the one that a search of all triangles finds, wherever the search starts.
Mesh bumpySheet(double height) {
  Mesh mesh = test::sheetMesh(1, 8);
  for (Vec3& v : mesh.vertices) v.z() += height * std::sin(9 * v.x()) * std::cos(7 * v.y());
  return mesh;
}
Mesh ditches() {
  Mesh mesh = test::sheetMesh(1, 8);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) mesh.vertices[i].z() -= 0.1;
  return mesh;
}

TEST(TriangleSurface, ASureFaceIsTheNearest) {
  const Mesh box = test::boxMesh({0, 0, -0.1}, {1, 1, 0});
  const Mesh fin = test::boxMesh({0.5, 0.1, 0}, {0.51, 0.9, 0.3});
  const Mesh meshes[] = {bumpySheet(0.02),
                         bumpySheet(0.3),
                         ditches(),
                         box,
                         test::joined(box, fin),
                         test::joined(bumpySheet(0.05), test::boxMesh({0, 0, -0.2}, {1, 1, -0.1}))};
  Random random(7);
  for (const Mesh& mesh : meshes) {
    const TriangleSurface surface = surfaceOf(mesh);
    for (int i = 0; i < 400; ++i) {
      Vec3 x = random.inCube();
      x.z() = (i % 2 ? 0.5 : 0.05) * (2 * x.z() - 1);
      const double nearest = distanceTo(mesh, x);
      for (int before = 0; before < 8; ++before) {
        const Vec3 from = before % 2 ? random.inCube() : Vec3(x + 0.1 * random.inCube());
        surface.at(from);
        const double depth = surface.at(x).depth;
        EXPECT_NEAR(std::abs(depth), nearest, 1e-12) << x.transpose() << " from " << from;
      }
      for (const double reach : {0.01, 0.1, 0.3}) {
        const double beyond = surface.beyond(x, reach), depth = surface.at(x).depth;
        EXPECT_NEAR(beyond, std::max(0.0, -depth - reach), 1e-12) << x.transpose();
      }
    }
  }
}

// Prisms are measured when first asked for, by whichever thread asks.
TEST(TriangleSurface, ThreadsFindTheSame) {
  const Mesh mesh = bumpySheet(0.05);
  const TriangleSurface alone = surfaceOf(mesh), shared = surfaceOf(mesh);
  const auto depths = [](const TriangleSurface& surface) {
    Random random(8);
    std::vector<double> all;
    for (int i = 0; i < 2000; ++i)
      all.push_back(surface.at(Vec3(random.inCube().cwiseProduct(Vec3(1, 1, 0.1)))).depth);
    return all;
  };
  const std::vector<double> expected = depths(alone);
  std::vector<double> found[4];
  std::vector<std::thread> threads;
  for (std::vector<double>& f : found) threads.emplace_back([&] { f = depths(shared); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& f : found) EXPECT_EQ(f, expected);
}

// The part of a mesh in a box that moves on, as Bullet's callback gives it.
TriangleSurface partOf(const Mesh& mesh, const Eigen::AlignedBox3d& box) {
  Mesh part = mesh;
  std::erase_if(part.triangles, [&](const auto& t) {
    Eigen::AlignedBox3d own;
    for (const auto corner : t) own.extend(mesh.vertices[std::size_t(corner)]);
    return !own.intersects(box);
  });
  TriangleSurface surface;
  surface.build(cornersOf(part), box);
  return surface;
}

void expectSame(const TriangleSurface& found, const TriangleSurface& expected,
                const Eigen::AlignedBox3d& box) {
  Random random(9);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 x = box.min() + random.inCube().cwiseProduct(box.sizes());
    EXPECT_EQ(found.at(x).depth, expected.at(x).depth) << x.transpose();
  }
}

TEST(TriangleSurface, WhatIsKeptOfThePartBeforeIsStillTrue) {
  Mesh mesh = bumpySheet(0.05);
  const Eigen::AlignedBox3d first(Vec3(0, 0, -0.3), Vec3(0.6, 0.6, 0.3)),
      next(Vec3(0.3, 0.2, -0.3), Vec3(0.9, 0.8, 0.3));
  const TriangleSurface before = partOf(mesh, first);
  expectSame(before, partOf(mesh, first), first);  // measures its prisms
  TriangleSurface after = partOf(mesh, next);
  after.keepRooms(before);
  expectSame(after, partOf(mesh, next), next);
  // A spike beside faces that stay as they are.
  for (Vec3& v : mesh.vertices)
    if (std::hypot(v.x() - 0.5, v.y() - 0.5) < 0.01) v.z() += 0.25;
  TriangleSurface changed = partOf(mesh, next);
  changed.keepRooms(before);
  expectSame(changed, partOf(mesh, next), next);
}

TEST(TriangleSurface, WindingDoesNotMatter) {
  Mesh mesh = test::sphereMesh(0.5, 2);
  Random random(4);
  for (auto& t : mesh.triangles)
    if (random.uniform() < 0.5) std::swap(t[1], t[2]);
  TriangleSurface surface = surfaceOf(mesh);
  surface.turnTo(std::vector<Vec3>{{0.9, 0, 0}});
  EXPECT_GT(surface.at({0.1, 0, 0}).depth, 0.3);
  EXPECT_LT(surface.at({0.7, 0, 0}).depth, -0.19);
  // From inside the ball is a room.
  EXPECT_TRUE(surface.turnTo(std::vector<Vec3>{{0.1, 0, 0}}));
  EXPECT_LT(surface.at({0.1, 0, 0}).depth, -0.3);
  EXPECT_FALSE(surface.turnTo(std::vector<Vec3>{{0, 0.1, 0}}));
}

TEST(TriangleSurface, BordersAreOutside) {
  const TriangleSurface surface = surfaceOf(test::sheetMesh(1, 3));
  EXPECT_NEAR(surface.at({0.5, 0.5, -0.1}).depth, 0.1, 1e-12);
  EXPECT_NEAR(surface.at({1.1, 0.5, -0.1}).depth, -std::hypot(0.1, 0.1), 1e-12);
  EXPECT_NEAR(surface.at({1.1, 1.1, -0.1}).depth, -std::sqrt(0.03), 1e-12);
}

TEST(TriangleSurface, DropsCopiesAndFlatTriangles) {
  const Mesh one = test::sheetMesh(1, 3);
  Mesh twice = test::joined(one, test::turnedInsideOut(one));
  twice.triangles.emplace_back(0, 1, 2);  // on a line
  twice.triangles.emplace_back(0, 0, 1);
  const TriangleSurface surface = surfaceOf(twice);
  EXPECT_EQ(surface.size(), one.triangles.size());
  EXPECT_NEAR(surface.at({0.5, 0.5, -0.1}).depth, 0.1, 1e-12);
}

}  // namespace
}  // namespace cloudcontact::testing::triangle_surface_test
