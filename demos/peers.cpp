// Bullet's shapes of the same bodies: what its users have today.
#include "peers.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <HACD/hacdHACD.h>
#include <LinearMath/btConvexHullComputer.h>

#include <stdexcept>
#include <type_traits>
#include <utility>

namespace cloudcontact::program {

namespace {

// Bullet's default margin, 4 cm, is larger than many bodies here. A thousandth of a per cent of
// the diagonal hides nothing and still lets GJK tell touching from apart.
constexpr double kMarginOfDiagonal = 1e-5;

// HACD in its own units: it scales bodies to a cube of 1000.
constexpr double kHacdConcavity = 10;  // a hundredth of the body
constexpr std::size_t kHacdLeastParts = 2;
constexpr std::size_t kHacdPartVertices = 64;
constexpr double kHacdConnect = 30;  // join surfaces nearer than this

btScalar marginOf(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  return btScalar(kMarginOfDiagonal * box.diagonal().norm());
}

btVector3 toBullet(const Vec3& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

// Mesh data that btTriangleIndexVertexArray points into.
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
  Shape operator()(const SphereShape& s) const {
    return std::make_shared<btSphereShape>(btScalar(s.radius));
  }
  Shape operator()(const BoxShape& s) const {
    return std::make_shared<btBoxShape>(toBullet(s.halfExtents));
  }
  Shape operator()(const CapsuleShape& s) const {
    return std::make_shared<btCapsuleShapeZ>(btScalar(s.radius), btScalar(2 * s.halfHeight));
  }
  Shape operator()(const CylinderShape& s) const {
    return std::make_shared<btCylinderShapeZ>(toBullet(Vec3(s.radius, s.radius, s.halfHeight)));
  }
  Shape operator()(const ConeShape& s) const {
    return std::make_shared<btConeShapeZ>(btScalar(s.radius), btScalar(2 * s.halfHeight));
  }
  Shape operator()(const HullShape& s) const {
    std::vector<btVector3> corners;
    for (const Vec3& c : s.corners) corners.push_back(toBullet(c));
    return hullOf(corners, btScalar(kMarginOfDiagonal * shapeBounds(s).diagonal().norm()));
  }
};

void prepare(HACD::HACD& hacd, std::vector<HACD::Vec3<HACD::Real>>& points,
             std::vector<HACD::Vec3<long>>& triangles) {
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(0.1);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(kHacdLeastParts);
  hacd.SetNVerticesPerCH(kHacdPartVertices);
  hacd.SetConcavity(kHacdConcavity);
  hacd.SetConnectDist(kHacdConnect);
  hacd.SetAddExtraDistPoints(false);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(false);
}

}  // namespace

PeerShape hullShape(const Mesh& mesh) {
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

PeerShape gimpactShape(const Mesh& mesh) {
  auto triangles = std::make_shared<IndexedTriangles>(mesh);
  auto shape = std::make_shared<btGImpactMeshShape>(&triangles->array);
  shape->setMargin(marginOf(mesh));
  shape->updateBound();
  return {{triangles}, shape};
}

PeerShape convexPartsShape(const Mesh& mesh) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  for (const Vec3& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<HACD::Vec3<long>> triangles;
  for (const Eigen::Vector3i& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  HACD::HACD hacd;
  prepare(hacd, points, triangles);
  if (!hacd.Compute()) throw std::runtime_error("HACD could not cut the mesh into convex parts");
  auto compound = std::make_shared<btCompoundShape>();
  PeerShape result{{}, compound};
  for (std::size_t part = 0; part < hacd.GetNClusters(); ++part) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(part));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(part));
    hacd.GetCH(part, corners.data(), faces.data());
    std::vector<btVector3> hullPoints;
    for (const auto& c : corners) hullPoints.push_back(toBullet(Vec3(c.X(), c.Y(), c.Z())));
    auto hull = hullOf(hullPoints, marginOf(mesh));
    compound->addChildShape(btTransform::getIdentity(), hull.get());
    result.keep.push_back(hull);
  }
  return result;
}

PeerShape primitiveShape(const AnalyticShape& shape) {
  return {{}, std::visit(PrimitiveMaker{}, shape)};
}

void registerPeer(btCollisionDispatcher& dispatcher, Method method) {
  if (method == Method::Gimpact) btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
}

}  // namespace cloudcontact::program
