// Meshes from files, through Assimp: see mesh_file.h.
#include <cloudcontact/mesh_file.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <stdexcept>

namespace cloudcontact {

namespace {

using Eigen::Vector3d;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

void append(const aiMesh& part, const aiMatrix4x4& toRoot, double metresPerUnit, Mesh& mesh) {
  const int base = static_cast<int>(mesh.vertices.size());
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D p = toRoot * part.mVertices[i];
    mesh.vertices.push_back(metresPerUnit * Vector3d(p.x, p.y, p.z));
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines bound nothing
    mesh.triangles.emplace_back(base + static_cast<int>(face.mIndices[0]),
                                base + static_cast<int>(face.mIndices[1]),
                                base + static_cast<int>(face.mIndices[2]));
  }
}

void appendNode(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
                double metresPerUnit, Mesh& mesh) {
  const aiMatrix4x4 toRoot = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    append(*scene.mMeshes[node.mMeshes[i]], toRoot, metresPerUnit, mesh);
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    appendNode(scene, *node.mChildren[i], toRoot, metresPerUnit, mesh);
}

}  // namespace

Mesh loadMesh(const std::filesystem::path& file, double metresPerUnit) {
  if (!std::filesystem::exists(file)) refuse(file, "no such file");
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene || !scene->mRootNode)
    refuse(file, std::string("no mesh: ") + importer.GetErrorString());
  Mesh mesh;
  appendNode(*scene, *scene->mRootNode, aiMatrix4x4(), metresPerUnit, mesh);
  if (mesh.triangles.empty()) refuse(file, "has no triangles");
  return mesh;
}

}  // namespace cloudcontact
