// Assimp's meshes become ours, in their own coordinates or in a scene's.
#include <assimp/scene.h>
#include <cloudcontact/mesh/assimp_mesh.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <gtest/gtest.h>

#include "mesh/test_meshes.h"

namespace cloudcontact::assimp_mesh_test {
namespace {

// Assimp's classes own what they point to.
aiMesh* assimpBox(const Eigen::Vector3d& edges) {
  const Mesh box = test::boxMesh(Eigen::Vector3d::Zero(), edges);
  auto* const mesh = new aiMesh;
  mesh->mNumVertices = static_cast<unsigned>(box.vertices.size());
  mesh->mVertices = new aiVector3D[box.vertices.size()];
  for (std::size_t i = 0; i < box.vertices.size(); ++i)
    mesh->mVertices[i] = aiVector3D(static_cast<ai_real>(box.vertices[i].x()),
                                    static_cast<ai_real>(box.vertices[i].y()),
                                    static_cast<ai_real>(box.vertices[i].z()));
  mesh->mNumFaces = static_cast<unsigned>(box.triangles.size());
  mesh->mFaces = new aiFace[box.triangles.size()];
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    mesh->mFaces[t].mNumIndices = 3;
    mesh->mFaces[t].mIndices = new unsigned[3];
    for (int k = 0; k < 3; ++k)
      mesh->mFaces[t].mIndices[k] = static_cast<unsigned>(box.triangles[t][k]);
  }
  return mesh;
}

TEST(AssimpMesh, IsTheMesh) {
  const std::unique_ptr<aiMesh> box(assimpBox({1, 2, 3}));
  const MeshReport report = inspect(meshOf(*box, 0.1));
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.volume, 0.006, 1e-7);
  EXPECT_THROW(meshOf(*box, 0), std::invalid_argument);
  box->mVertices[2].y = std::numeric_limits<ai_real>::quiet_NaN();
  EXPECT_THROW(meshOf(*box), std::invalid_argument);
}

// A mirrored node still faces outward; equal names are one part.
TEST(AssimpMesh, PartsAreWhereTheirNodesAre) {
  aiScene scene;
  scene.mNumMeshes = 1;
  scene.mMeshes = new aiMesh* [1] { assimpBox({1, 1, 1}) };
  scene.mMeshes[0]->mName = "box";
  scene.mRootNode = new aiNode;
  auto** const nodes = new aiNode*[2];
  for (int k = 0; k < 2; ++k) {
    nodes[k] = new aiNode;
    nodes[k]->mParent = scene.mRootNode;
    nodes[k]->mNumMeshes = 1;
    nodes[k]->mMeshes = new unsigned[1]{0};
  }
  nodes[0]->mTransformation.a4 = 5;
  nodes[1]->mTransformation.a1 = -2;
  scene.mRootNode->mChildren = nodes;
  scene.mRootNode->mNumChildren = 2;
  const std::vector<NamedMesh> parts = meshParts(scene);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].name, "box");
  EXPECT_NEAR(inspect(parts[0].mesh).volume, 3, 1e-6);
  double least = 0, most = 0;
  for (const Eigen::Vector3d& v : parts[0].mesh.vertices)
    least = std::min(least, v.x()), most = std::max(most, v.x());
  EXPECT_NEAR(least, -2, 1e-6);
  EXPECT_NEAR(most, 6, 1e-6);
}

}  // namespace
}  // namespace cloudcontact::assimp_mesh_test
