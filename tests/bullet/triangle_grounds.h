// The same flat ground at z = 0 by each Bullet shape that is made of triangles, and clouds to set
// on it.
#pragma once

#include "bullet/bullet_world.h"
#include "mesh/test_meshes.h"
#include "mesh/thread_meshes.h"
#include "mesh/turned_mesh.h"

#include <BulletCollision/CollisionShapes/btBox2dShape.h>
#include <BulletCollision/CollisionShapes/btConvex2dShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultimaterialTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>

namespace cloudcontact::testing {

constexpr double kVoxel = 0.004;
constexpr double kSide = 2;  // of a ground [m]

inline btVector3 bullet(const Vec3& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

// A shape with the data that it points to.
struct Kept {
  std::unique_ptr<btCollisionShape> shape;
  std::vector<std::shared_ptr<void>> data = {};
};

inline std::shared_ptr<btTriangleMesh> triangleMesh(const Mesh& mesh,
                                                    const Vec3& scale = {1, 1, 1}) {
  auto made = std::make_shared<btTriangleMesh>();
  for (const auto& t : mesh.triangles) {
    btVector3 corner[3];
    for (int k = 0; k < 3; ++k)
      corner[k] = bullet(mesh.vertices[std::size_t(t[k])].cwiseProduct(scale));
    made->addTriangle(corner[0], corner[1], corner[2]);
  }
  return made;
}

inline Mesh centered(Mesh mesh) {
  for (auto& v : mesh.vertices) v -= Vec3(kSide / 2, kSide / 2, 0);
  return mesh;
}
// n x n squares.
inline Mesh groundMesh(int n) {
  return centered(test::sheetMesh(kSide, n));
}

inline Kept bvhShape(const Mesh& mesh) {
  auto triangles = triangleMesh(mesh);
  return {std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true), {triangles}};
}

inline Kept gimpactShape(const Mesh& mesh) {
  auto triangles = triangleMesh(mesh);
  auto shape = std::make_unique<btGImpactMeshShape>(triangles.get());
  shape->updateBound();
  return {std::move(shape), {triangles}};
}

inline Kept scaledShape(const Mesh& mesh) {
  auto triangles = triangleMesh(mesh, {0.5, 0.25, 2});
  auto inner = std::make_shared<btBvhTriangleMeshShape>(triangles.get(), true);
  return {std::make_unique<btScaledBvhTriangleMeshShape>(inner.get(), btVector3(2, 4, 0.5)),
          {triangles, inner}};
}

inline Kept multimaterialShape(const Mesh& mesh) {
  auto triangles = triangleMesh(mesh);
  return {std::make_unique<btMultimaterialTriangleMeshShape>(triangles.get(), true), {triangles}};
}

// Heights by a formula, on n x n squares.
// This constructor reads heights as btScalar, whatever PHY_FLOAT says.
inline Kept heightfieldShape(int n, const std::function<double(double, double)>& height) {
  auto heights = std::make_shared<std::vector<btScalar>>();
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x)
      heights->push_back(btScalar(height(kSide * x / n - kSide / 2, kSide * y / n - kSide / 2)));
  auto shape = std::make_unique<btHeightfieldTerrainShape>(
      n + 1, n + 1, heights->data(), btScalar(1), btScalar(-1), btScalar(1), 2, PHY_FLOAT, false);
  shape->setLocalScaling({btScalar(kSide / n), btScalar(kSide / n), 1});
  return {std::move(shape), {heights}};
}

// Bullet asks for a child's contacts where boxes overlap, and a flat box does so late: the margin
// makes it thick.
inline Kept inCompound(Kept child) {
  child.shape->setMargin(btScalar(0.02));
  auto compound = std::make_unique<btCompoundShape>();
  const btTransform up = at({0, 0, 1});
  compound->addChildShape(up, child.shape.get());
  auto outer = std::make_unique<btCompoundShape>();
  outer->addChildShape(at({0, 0, -1}), compound.get());
  child.data.emplace_back(std::move(child.shape));
  child.data.emplace_back(std::move(compound));
  return {std::move(outer), std::move(child.data)};
}

struct Ground {
  const char* name;
  std::function<Kept()> make;
};

inline std::vector<Ground> grounds() {
  const btScalar h = btScalar(kSide / 2);
  return {
      {"two triangles", [] { return bvhShape(groundMesh(1)); }},
      {"bvh", [] { return bvhShape(groundMesh(90)); }},
      {"bvh, turned over", [] { return bvhShape(test::turnedInsideOut(groundMesh(90))); }},
      {"scaled", [] { return scaledShape(groundMesh(90)); }},
      {"multimaterial", [] { return multimaterialShape(groundMesh(90)); }},
      {"heightfield", [] { return heightfieldShape(90, [](double, double) { return 0.0; }); }},
      {"gimpact", [] { return gimpactShape(groundMesh(90)); }},
      {"triangle",
       [h] {
         return Kept{std::make_unique<btTriangleShape>(
             btVector3(-2 * h, -h, 0), btVector3(2 * h, -h, 0), btVector3(0, 3 * h, 0))};
       }},
      {"box 2d", [h] { return Kept{std::make_unique<btBox2dShape>(btVector3(h, h, 0))}; }},
      {"convex 2d",
       [h] {
         auto child = std::make_shared<btBox2dShape>(btVector3(h, h, 0));
         return Kept{std::make_unique<btConvex2dShape>(child.get()), {child}};
       }},
      {"compound of bvh", [] { return inCompound(bvhShape(groundMesh(90))); }},
      {"compound of gimpact", [] { return inCompound(gimpactShape(groundMesh(90))); }},
  };
}

struct TestCloud {
  const char* name;
  std::shared_ptr<const SurfaceField> field;
  double below;  // from its origin to its lowest point [m]
};

// A box, a torus with axis z and a cup, about 20 voxels wide.
inline const std::vector<TestCloud>& testClouds() {
  static const std::vector<TestCloud> all = [] {
    const Mesh torus = revolvedMesh(96, 48, true, [](double angle, double s) {
      const double turn = 2 * std::numbers::pi * s, r = 0.036 + 0.012 * std::cos(turn);
      return Vec3(r * std::cos(angle), r * std::sin(angle), 0.012 * std::sin(turn));
    });
    const Mesh cup = test::turnedMesh(
        {{0, -0.03}, {0.04, -0.03}, {0.04, 0.03}, {0.028, 0.03}, {0.028, -0.016}, {0, -0.016}}, 96);
    return std::vector<TestCloud>{{"box", fieldOf(boxMesh({0.08, 0.06, 0.05}), kVoxel), 0.025},
                                  {"torus", fieldOf(torus, kVoxel), 0.012},
                                  {"cup", fieldOf(cup, kVoxel), 0.03}};
  }();
  return all;
}

inline const TestCloud& testCloudOf(std::string_view name) {
  return *std::ranges::find(testClouds(), name, &TestCloud::name);
}

}  // namespace cloudcontact::testing
