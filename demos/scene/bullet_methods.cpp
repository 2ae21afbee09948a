// Makes Bullet's shapes from meshes and primitives.
#include "scene/bullet_methods.h"

#include <cloudcontact/mesh/mesh_repair.h>

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <HACD/hacdHACD.h>
#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "scene/bullet_vectors.h"

namespace cloudcontact::program {

namespace {

// Bullet's default margin, 4 cm, exceeds many bodies here. This one hides no detail and is still
// enough for GJK to separate touching from apart.
constexpr double kMarginOfDiagonal = 1e-5;

// HACD's time grows faster than the square of the number of triangles (20,480 take 6 minutes), so
// meshes are coarsened first.
constexpr double kHacdDiagonal =
    2000;  // HACD scales bodies to this diagonal; its concavity refers to it
constexpr std::size_t kHacdPartVertices = 64;
constexpr std::size_t kHacdTriangles = 2000;

btScalar marginOf(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  return btScalar(kMarginOfDiagonal * box.diagonal().norm());
}

// Mesh data for btTriangleIndexVertexArray, which holds pointers only.
struct IndexedTriangles {
  std::vector<btScalar> coordinates;
  std::vector<int> indices;
  btTriangleIndexVertexArray array;

  explicit IndexedTriangles(const Mesh& mesh) {
    for (const Vec3& v : mesh.vertices)
      for (int k = 0; k < 3; ++k) coordinates.push_back(btScalar(v[k]));
    for (const Eigen::Vector3i& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) indices.push_back(t[k]);
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(mesh.triangles.size());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(indices.data());
    part.m_triangleIndexStride = 3 * sizeof(int);
    part.m_numVertices = static_cast<int>(mesh.vertices.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(coordinates.data());
    part.m_vertexStride = 3 * sizeof(btScalar);
    part.m_vertexType = std::is_same_v<btScalar, double> ? PHY_DOUBLE : PHY_FLOAT;
    array.addIndexedMesh(part);
  }
};

std::shared_ptr<btConvexHullShape> hullOf(const std::vector<btVector3>& points, btScalar margin) {
  auto hull = std::make_shared<btConvexHullShape>();
  for (const btVector3& p : points) hull->addPoint(p, false);
  hull->recalcLocalAabb();
  hull->setMargin(margin);
  return hull;
}

struct PrimitiveMaker {
  using Shape = std::shared_ptr<btCollisionShape>;

  Shape operator()(const HalfSpace& s) const {
    return std::make_shared<btStaticPlaneShape>(toBullet(s.normal), btScalar(s.offset));
  }
  Shape operator()(const Sphere& s) const {
    return std::make_shared<btSphereShape>(btScalar(s.radius));
  }
  Shape operator()(const Box& s) const {
    return std::make_shared<btBoxShape>(toBullet(s.halfExtents));
  }
  Shape operator()(const Capsule& s) const {
    return std::make_shared<btCapsuleShapeZ>(btScalar(s.radius), btScalar(2 * s.halfHeight));
  }
  Shape operator()(const Cylinder& s) const {
    return std::make_shared<btCylinderShapeZ>(toBullet(Vec3(s.radius, s.radius, s.halfHeight)));
  }
  Shape operator()(const Cone& s) const {
    // The only primitive whose margin Bullet adds outside.
    auto cone = std::make_shared<btConeShapeZ>(btScalar(s.radius), btScalar(2 * s.halfHeight));
    const double least = kMarginOfDiagonal * boundsOf(s).diagonal().norm();
    cone->setMargin(btScalar(std::max(least, s.margin)));
    return cone;
  }
  template <class Other>
  Shape operator()(const Other&) const {
    throw std::invalid_argument("Bullet has no ellipsoid, and no cloud but as a cloud's shape");
  }
  Shape operator()(const Hull& s) const {
    std::vector<btVector3> corners;
    for (const Vec3& c : s.corners) corners.push_back(toBullet(c));
    return hullOf(corners, btScalar(kMarginOfDiagonal * boundsOf(s).diagonal().norm()));
  }
};

// Merges the vertices in each cell of a grid.
Mesh clustered(const Mesh& mesh, double cell) {
  std::map<std::array<long, 3>, int> cells;
  std::vector<int> clusterOf;
  std::vector<double> count;
  Mesh coarse;
  for (const Vec3& v : mesh.vertices) {
    const std::array<long, 3> key = {std::lround(v.x() / cell), std::lround(v.y() / cell),
                                     std::lround(v.z() / cell)};
    const auto [entry, isNew] = cells.try_emplace(key, static_cast<int>(coarse.vertices.size()));
    if (isNew) {
      coarse.vertices.push_back(Vec3::Zero());
      count.push_back(0);
    }
    const auto index = static_cast<std::size_t>(entry->second);
    coarse.vertices[index] += v;
    count[index] += 1;
    clusterOf.push_back(entry->second);
  }
  for (std::size_t k = 0; k < count.size(); ++k) coarse.vertices[k] /= count[k];
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3i corners(clusterOf[static_cast<std::size_t>(t[0])],
                                  clusterOf[static_cast<std::size_t>(t[1])],
                                  clusterOf[static_cast<std::size_t>(t[2])]);
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      coarse.triangles.push_back(corners);
  }
  return coarse;
}

// Coarsens to at most kHacdTriangles, with the finest grid that does so.
Mesh coarsened(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  Mesh coarse = mesh;
  for (double cell = box.diagonal().norm() / 500; coarse.triangles.size() > kHacdTriangles;
       cell *= 1.1)
    coarse = clustered(mesh, cell);
  return coarse;
}

void prepare(HACD::HACD& hacd, std::vector<HACD::Vec3<HACD::Real>>& points,
             std::vector<HACD::Vec3<long>>& triangles) {
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(0.1);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(1);
  hacd.SetNVerticesPerCH(kHacdPartVertices);
  hacd.SetAddExtraDistPoints(false);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(false);
}

}  // namespace

BulletShape hullShape(const Mesh& mesh) {
  std::vector<double> coordinates;
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) coordinates.push_back(v[k]);
  btConvexHullComputer computer;
  computer.compute(coordinates.data(), 3 * sizeof(double), static_cast<int>(mesh.vertices.size()),
                   0, 0);
  std::vector<btVector3> corners;
  for (int k = 0; k < computer.vertices.size(); ++k) corners.push_back(computer.vertices[k]);
  return {{}, hullOf(corners, marginOf(mesh))};
}

BulletShape gimpactShape(const Mesh& mesh) {
  auto triangles = std::make_shared<IndexedTriangles>(mesh);
  auto shape = std::make_shared<btGImpactMeshShape>(&triangles->array);
  shape->setMargin(marginOf(mesh));
  shape->updateBound();
  return {{triangles}, shape};
}

BulletShape trianglesShape(const Mesh& mesh) {
  auto triangles = std::make_shared<IndexedTriangles>(mesh);
  auto shape = std::make_shared<btBvhTriangleMeshShape>(&triangles->array, true);
  shape->setMargin(0);
  return {{triangles}, shape};
}

ConvexParts convexParts(const Mesh& fine, double concavity) {
  const Mesh mesh = coarsened(mended(fine));
  std::vector<HACD::Vec3<HACD::Real>> points;
  for (const Vec3& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<HACD::Vec3<long>> triangles;
  for (const Eigen::Vector3i& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  HACD::HACD hacd;
  prepare(hacd, points, triangles);
  hacd.SetConcavity(concavity * kHacdDiagonal);
  if (!hacd.Compute()) throw std::runtime_error("HACD could not cut the mesh into convex parts");
  ConvexParts parts;
  parts.margin = marginOf(mesh);
  for (std::size_t part = 0; part < hacd.GetNClusters(); ++part) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(part));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(part));
    hacd.GetCH(part, corners.data(), faces.data());
    parts.corners.emplace_back();
    for (const auto& c : corners)
      parts.corners.back().push_back(toBullet(Vec3(c.X(), c.Y(), c.Z())));
  }
  return parts;
}

BulletShape convexPartsShape(const ConvexParts& parts) {
  auto compound = std::make_shared<btCompoundShape>();
  BulletShape result{{}, compound};
  for (const auto& corners : parts.corners) {
    auto hull = hullOf(corners, parts.margin);
    compound->addChildShape(btTransform::getIdentity(), hull.get());
    result.keep.push_back(hull);
  }
  return result;
}

BulletShape primitiveShape(const Solid& shape) {
  return {{}, std::visit(PrimitiveMaker{}, shape)};
}

void registerMethod(btCollisionDispatcher& dispatcher, Method method) {
  if (method == Method::Gimpact) btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
}

}  // namespace cloudcontact::program
