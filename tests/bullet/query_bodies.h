// Seven bodies as clouds and as Bullet's triangle meshes, for queries that see both alike.
#pragma once

#include "bullet/bullet_world.h"
#include "law/hulls.h"
#include "law/triangle_point.h"
#include "mesh/test_meshes.h"
#include "mesh/thread_meshes.h"
#include "mesh/turned_mesh.h"

#include <algorithm>
#include <numbers>
#include <string>

namespace cloudcontact::testing {

// [m] Bullet's sweeps end up to 1 mm short of a surface.
constexpr double kQueryVoxel = 0.05;
constexpr double kBodyScale = 5;  // of the lengths below

inline btVector3 toBt(const Vec3& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

inline Vec3 fromBt(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

struct QueryBody {
  std::string name;
  Mesh mesh;
  std::shared_ptr<const SurfaceField> field;
  double radius;  // of a ball around it [m]
};

// A ball with humps and hollows, all of them round: radii of 20 voxels and more.
inline Mesh humpedMesh(int around, int along) {
  return revolvedMesh(around, along, false, [](double angle, double s) {
    const double polar = std::numbers::pi * s, bump = std::sin(polar);
    const double r = 0.4 * (1 + 0.05 * bump * bump * bump * std::cos(3 * angle) +
                            0.06 * std::cos(3 * polar + 1) * bump * bump);
    return Vec3(r * bump * std::cos(angle), r * bump * std::sin(angle), -r * std::cos(polar));
  });
}

// The profile of a cup about z, in steps of `step` [m].
inline Mesh cupMesh(double step, int sides) {
  const std::vector<std::pair<double, double>> corners = {{0, -0.25},   {0.3, -0.25},  {0.3, 0.25},
                                                          {0.22, 0.25}, {0.22, -0.15}, {0, -0.15}};
  std::vector<std::pair<double, double>> profile = {corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const auto [r0, z0] = corners[i - 1];
    const auto [r1, z1] = corners[i];
    const int parts = static_cast<int>(std::ceil(std::hypot(r1 - r0, z1 - z0) / step));
    for (int k = 1; k <= parts; ++k)
      profile.emplace_back(r0 + (r1 - r0) * k / parts, z0 + (z1 - z0) * k / parts);
  }
  return test::turnedMesh(profile, sides);
}

// Triangles of about `facet` voxels. The bodies' axes are not the grid's.
inline std::vector<QueryBody> queryBodies(double facet, double voxel = kQueryVoxel) {
  const auto sides = [&](double radius) {
    return static_cast<int>(2 * std::numbers::pi * radius / (facet * 0.01));
  };
  const Mesh torus = revolvedMesh(sides(0.6), sides(0.22), true, [](double angle, double s) {
    const double turn = 2 * std::numbers::pi * s, r = 0.45 + 0.22 * std::cos(turn);
    return Vec3(r * std::cos(angle), r * std::sin(angle), 0.22 * std::sin(turn));
  });
  const Thread thread{0.3, 0.16, 0.08};
  const Mesh ball = revolvedMesh(sides(0.3), sides(0.3) / 2, false, [](double angle, double s) {
    const double polar = std::numbers::pi * s, r = 0.3 * std::sin(polar);
    return Vec3(r * std::cos(angle), r * std::sin(angle), -0.3 * std::cos(polar));
  });
  std::vector<std::pair<std::string, Mesh>> meshes = {
      {"ball", ball},
      {"box", boxMesh({0.6, 0.5, 0.4})},
      {"torus", torus},
      {"cup", cupMesh(facet * 0.01, sides(0.3))},
      {"nut", test::turnedInsideOut(threadedRing(thread, 0.4, 0.45, 0, sides(0.4), sides(0.16)))},
      {"cow", humpedMesh(sides(0.4), sides(0.2))},
      {"block", test::meshOf(test::prismHull(6, 0.3, 0.2))}};
  std::vector<QueryBody> bodies;
  for (auto& [name, mesh] : meshes) {
    QueryBody body{name, transformed(mesh, Pose{test::oddTurn(), Vec3::Zero()}), nullptr, 0};
    for (Vec3& v : body.mesh.vertices) v *= kBodyScale;
    for (const Vec3& v : body.mesh.vertices) body.radius = std::max(body.radius, v.norm());
    body.field = fieldOf(body.mesh, voxel);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

// A segment across a body: it starts `away` [m] outside of a ball around it.
struct Segment {
  btVector3 from, to;
};
inline Segment randomSegment(Random& random, double radius, double away) {
  const Vec3 from = (radius + away) * (random.rotation() * Vec3::UnitX());
  const Vec3 through = 1.6 * radius * (random.inCube() - Vec3(0.5, 0.5, 0.5));
  return {toBt(from), toBt(Vec3(from + (2.5 * radius + away) * (through - from).normalized()))};
}

// The normal of a mesh's face that is nearest to a place.
struct NearestFace : btTriangleCallback {
  explicit NearestFace(const btVector3& place) : middle(fromBt(place)) {}
  void processTriangle(btVector3* corners, int, int) override {
    Vec3 foot;
    nearestOnTriangle(fromBt(corners[0]), fromBt(corners[1]), fromBt(corners[2]), middle, foot);
    if ((foot - middle).norm() >= least) return;
    least = (foot - middle).norm();
    normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  }
  Vec3 middle;
  double least = 1e9;
  btVector3 normal{0, 0, 1};
};
inline btVector3 nearestFace(const btConcaveShape& mesh, const btVector3& place) {
  NearestFace nearest(place);
  const btVector3 around = btVector3(1, 1, 1) * btScalar(kQueryVoxel);
  mesh.processAllTriangles(&nearest, place - around, place + around);
  return nearest.normal;
}

// Whether the faces of a mesh within 1.5 voxels of a place differ by more than 20 deg.
struct NearFaces : btTriangleCallback {
  NearFaces(const btVector3& place, const btVector3& normal)
      : middle(fromBt(place)), facing(normal) {}
  void processTriangle(btVector3* corners, int, int) override {
    const btVector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    Vec3 foot;
    nearestOnTriangle(fromBt(corners[0]), fromBt(corners[1]), fromBt(corners[2]), middle, foot);
    if ((foot - middle).norm() > kReach) return;
    one = one && std::abs(across.normalized().dot(facing)) > btScalar(0.94);
  }
  static constexpr double kReach = 1.5 * kQueryVoxel;
  Vec3 middle;
  btVector3 facing;
  bool one = true;
};
inline bool besideEdge(const btConcaveShape& mesh, const btVector3& place,
                       const btVector3& normal) {
  NearFaces faces(place, normal);
  const btScalar reach = btScalar(NearFaces::kReach);
  const btVector3 around(reach, reach, reach);
  mesh.processAllTriangles(&faces, place - around, place + around);
  return !faces.one;
}

inline double degreesBetween(const btVector3& a, const btVector3& b) {
  return 180 / std::numbers::pi * std::atan2(a.cross(b).length(), a.dot(b));
}

// A world that holds one body, as a cloud or as a mesh.
class QueryWorld {
 public:
  // The mesh; only where `cloud` is false.
  const btConcaveShape& faces() const {
    return static_cast<const btConcaveShape&>(
        *scene.world.getCollisionObjectArray()[0]->getCollisionShape());
  }

  QueryWorld(const QueryBody& body, bool cloud) {
    if (!cloud) {
      for (const auto& t : body.mesh.triangles) {
        btVector3 corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = toBt(body.mesh.vertices[std::size_t(t[k])]);
        triangles_.addTriangle(corner[0], corner[1], corner[2]);
      }
      auto shape = std::make_unique<btBvhTriangleMeshShape>(&triangles_, true);
      shape->setMargin(0);
      scene.add(std::move(shape), 0, at({0, 0, 0}));
    } else {
      scene.addCloud(body.field, 0, at({0, 0, 0}));
    }
    scene.detect();
  }

 private:
  btTriangleMesh triangles_;

 public:
  BulletWorld scene;
};

}  // namespace cloudcontact::testing
