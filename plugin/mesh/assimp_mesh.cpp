// Walks over Assimp's nodes and meshes.
#include <cloudcontact/mesh/assimp_mesh.h>

#include <assimp/scene.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace cloudcontact {

namespace {

void append(const aiMesh& part, const aiMatrix4x4& toRoot, Mesh& mesh) {
  const int base = static_cast<int>(mesh.vertices.size());
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D p = toRoot * part.mVertices[i];
    mesh.vertices.emplace_back(p.x, p.y, p.z);
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;  // points and lines
    mesh.triangles.emplace_back(base + static_cast<int>(face.mIndices[0]),
                                base + static_cast<int>(face.mIndices[1]),
                                base + static_cast<int>(face.mIndices[2]));
    // A mirroring transform reverses triangles.
    if (toRoot.Determinant() < 0) std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
  }
}

// The part of that name, added if needed. Parts without a name stay separate.
Mesh& partOf(std::vector<NamedMesh>& parts, const std::string& name) {
  for (NamedMesh& part : parts)
    if (!name.empty() && part.name == name) return part.mesh;
  parts.push_back({name, {}});
  return parts.back().mesh;
}

void appendNode(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
                std::vector<NamedMesh>& parts) {
  const aiMatrix4x4 toRoot = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    append(mesh, toRoot, partOf(parts, mesh.mName.C_Str()));
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    appendNode(scene, *node.mChildren[i], toRoot, parts);
}

void toMeters(Mesh& mesh, double metersPerUnit) {
  if (!(metersPerUnit > 0) || !std::isfinite(metersPerUnit))
    throw std::invalid_argument("mesh: metersPerUnit must be positive and finite");
  for (Eigen::Vector3d& v : mesh.vertices) v *= metersPerUnit;
  validate(mesh);
}

}  // namespace

Mesh meshOf(const aiMesh& mesh, double metersPerUnit) {
  Mesh found;
  append(mesh, aiMatrix4x4(), found);
  toMeters(found, metersPerUnit);
  return found;
}

std::vector<NamedMesh> meshParts(const aiScene& scene, double metersPerUnit) {
  std::vector<NamedMesh> parts;
  if (scene.mRootNode) appendNode(scene, *scene.mRootNode, aiMatrix4x4(), parts);
  std::erase_if(parts, [](const NamedMesh& part) { return part.mesh.triangles.empty(); });
  int nameless = 0;
  for (NamedMesh& part : parts) {
    if (part.name.empty()) part.name = "part " + std::to_string(++nameless);
    toMeters(part.mesh, metersPerUnit);
  }
  return parts;
}

}  // namespace cloudcontact
