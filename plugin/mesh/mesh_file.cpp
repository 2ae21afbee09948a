// Reads meshes through Assimp: see mesh_file.h.
#include <cloudcontact/mesh/mesh_file.h>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "mesh/mesh_file_check.h"
#include "mesh/mesh_topology.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

std::string lowerExtension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void checkFile(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) refuse(file, "no such file; check its name");
  if (!std::filesystem::is_regular_file(file)) refuse(file, "is not a file; give a mesh file");
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(file, "cannot be read; check its permissions");
  if (std::filesystem::file_size(file) == 0) refuse(file, "is empty");
  const std::string extension = lowerExtension(file);
  if (!isCheckedMeshFile(extension)) return;
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::string fault = faultOfMeshFile(bytes, extension);
  if (!fault.empty()) refuse(file, fault);
}

// Assimp's message shortened to one line; some quote the file.
std::string oneLine(std::string message) {
  constexpr std::size_t kLongest = 160;
  message = message.substr(0, message.find('\n'));
  if (message.size() > kLongest) message = message.substr(0, kLongest) + " ...";
  return message;
}

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

}  // namespace

std::vector<NamedMesh> loadMeshParts(const std::filesystem::path& file, double metersPerUnit) {
  if (!(metersPerUnit > 0) || !std::isfinite(metersPerUnit))
    refuse(file, "metersPerUnit must be positive and finite");
  checkFile(file);
  Assimp::Importer importer;
  // Keeps the coordinates of the file, whichever axis it declares as up.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene || !scene->mRootNode)
    refuse(file, "is no mesh that can be read: " + oneLine(importer.GetErrorString()));
  std::vector<NamedMesh> parts;
  appendNode(*scene, *scene->mRootNode, aiMatrix4x4(), parts);
  std::erase_if(parts, [](const NamedMesh& part) { return part.mesh.triangles.empty(); });
  if (parts.empty()) refuse(file, "has no triangles");
  int nameless = 0;
  for (NamedMesh& part : parts) {
    if (part.name.empty()) part.name = "part " + std::to_string(++nameless);
    for (Vector3d& v : part.mesh.vertices) v *= metersPerUnit;
    try {
      validate(part.mesh);
    } catch (const std::invalid_argument& e) {
      refuse(file, e.what());
    }
  }
  return parts;
}

Mesh loadMesh(const std::filesystem::path& file, double metersPerUnit) {
  return merged(loadMeshParts(file, metersPerUnit));
}

}  // namespace cloudcontact
