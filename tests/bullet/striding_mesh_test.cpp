// Bullet's meshes are read whatever the types of their numbers, and bad ones are refused.
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <cloudcontact/bullet/striding_mesh.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <gtest/gtest.h>

#include "bullet/bullet_world.h"
#include "bullet/convert.h"

namespace cloudcontact::testing::striding_mesh_test {
namespace {

const Vec3 kEdges(0.1, 0.2, 0.3);
constexpr double kVolume = 0.006;

// A box with numbers of the given types, each row followed by a gap.
template <typename Number, typename Index>
struct Rows {
  struct Vertex {
    Number x[3], gap;
  };
  struct Corner {
    Index i[3], gap;
  };
  std::vector<Vertex> vertices;
  std::vector<Corner> corners;
  btIndexedMesh part;

  Rows(PHY_ScalarType number, PHY_ScalarType index) {
    const Mesh box = boxMesh(kEdges);
    for (const Vec3& v : box.vertices)
      vertices.push_back({{Number(v.x()), Number(v.y()), Number(v.z())}, Number(9)});
    for (const Eigen::Vector3i& t : box.triangles)
      corners.push_back({{Index(t[0]), Index(t[1]), Index(t[2])}, Index(99)});
    part.m_numVertices = int(vertices.size());
    part.m_numTriangles = int(corners.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices.data());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(corners.data());
    part.m_vertexStride = sizeof(Vertex);
    part.m_triangleIndexStride = sizeof(Corner);
    part.m_vertexType = number;
    part.m_indexType = index;
  }
};

template <typename Number, typename Index>
Mesh read(PHY_ScalarType number, PHY_ScalarType index, const btVector3& scaling = {1, 1, 1}) {
  const Rows<Number, Index> rows(number, index);
  btTriangleIndexVertexArray mesh;
  mesh.addIndexedMesh(rows.part, index);
  mesh.setScaling(scaling);
  return meshOf(mesh);
}

TEST(StridingMesh, IsReadInEachType) {
  const Mesh wanted = boxMesh(kEdges);
  const Mesh all[] = {
      read<float, int>(PHY_FLOAT, PHY_INTEGER), read<double, int>(PHY_DOUBLE, PHY_INTEGER),
      read<double, short>(PHY_DOUBLE, PHY_SHORT), read<float, unsigned char>(PHY_FLOAT, PHY_UCHAR)};
  for (const Mesh& mesh : all) {
    EXPECT_EQ(mesh.triangles, wanted.triangles);
    ASSERT_EQ(mesh.vertices.size(), wanted.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      EXPECT_LT((mesh.vertices[i] - wanted.vertices[i]).norm(), 1e-7);
  }
}

TEST(StridingMesh, IsScaledAndFacesOutward) {
  const Mesh mirrored = read<double, int>(PHY_DOUBLE, PHY_INTEGER, {-2, 3, 1});
  EXPECT_NEAR(inspect(mirrored).volume, 6 * kVolume, 1e-9);
}

TEST(StridingMesh, AllPartsAreOne) {
  const Rows<double, int> rows(PHY_DOUBLE, PHY_INTEGER);
  btTriangleIndexVertexArray mesh;
  mesh.addIndexedMesh(rows.part);
  mesh.addIndexedMesh(rows.part);
  EXPECT_EQ(meshOf(mesh).vertices.size(), 16u);
  EXPECT_NEAR(inspect(meshOf(mesh)).volume, 2 * kVolume, 1e-9);
  btTriangleMesh soup;
  const Mesh box = boxMesh(kEdges);
  for (const Eigen::Vector3i& t : box.triangles)
    soup.addTriangle(toBullet(box.vertices[t[0]]), toBullet(box.vertices[t[1]]),
                     toBullet(box.vertices[t[2]]));
  EXPECT_NEAR(inspect(meshOf(soup)).volume, kVolume, 1e-8);
}

std::string whyNot(btIndexedMesh part) {
  btTriangleIndexVertexArray mesh;
  mesh.addIndexedMesh(part, part.m_indexType);
  try {
    meshOf(mesh);
  } catch (const std::invalid_argument& why) {
    return why.what();
  }
  return "no error";
}

TEST(StridingMesh, SaysWhatIsWrong) {
  Rows<float, int> rows(PHY_FLOAT, PHY_INTEGER);
  const auto spoilt = [&](auto&& spoil) {
    btIndexedMesh part = rows.part;
    spoil(part);
    return whyNot(part);
  };
  EXPECT_EQ(whyNot(rows.part), "no error");
  EXPECT_NE(spoilt([](auto& p) { p.m_vertexBase = nullptr; }).find("no data"), std::string::npos);
  EXPECT_NE(spoilt([](auto& p) { p.m_numVertices = 7; }).find("names vertex 7, but has 7"),
            std::string::npos);
  EXPECT_NE(spoilt([](auto& p) { p.m_vertexType = PHY_SHORT; }).find("float nor double"),
            std::string::npos);
  EXPECT_NE(spoilt([](auto& p) { p.m_indexType = PHY_FLOAT; }).find("int, short nor char"),
            std::string::npos);
  rows.vertices[2].x[1] = std::numeric_limits<float>::infinity();
  EXPECT_NE(whyNot(rows.part).find("vertex 2"), std::string::npos);
}

TEST(MeshOfArrays, IsTheMesh) {
  const Mesh box = boxMesh(kEdges);
  std::vector<float> numbers;
  std::vector<unsigned> indices;
  for (const Vec3& v : box.vertices)
    for (int k = 0; k < 3; ++k) numbers.push_back(float(v[k]));
  for (const Eigen::Vector3i& t : box.triangles)
    for (int k = 0; k < 3; ++k) indices.push_back(unsigned(t[k]));
  EXPECT_NEAR(inspect(meshOf(numbers, indices, 0.1)).volume, 1e-3 * kVolume, 1e-9);
  indices[5] = 4294967295u;
  EXPECT_THROW(meshOf(numbers, indices), std::invalid_argument);
  indices.pop_back();
  EXPECT_THROW(meshOf(numbers, indices), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::striding_mesh_test
