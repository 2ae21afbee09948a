// Reads meshes through Assimp: see mesh_file.h.
#include <cloudcontact/mesh/assimp_mesh.h>
#include <cloudcontact/mesh/mesh_file.h>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "base/file_name.h"
#include "mesh/mesh_file_check.h"
#include "mesh/mesh_topology.h"

namespace cloudcontact {

namespace {

void checkFile(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) refuseFile(file, "no such file; check its name");
  if (!std::filesystem::is_regular_file(file)) refuseFile(file, "is not a file; give a mesh file");
  std::ifstream in(file, std::ios::binary);
  if (!in) refuseFile(file, "cannot be read; check its permissions");
  if (std::filesystem::file_size(file) == 0) refuseFile(file, "is empty");
  const std::string extension = lowerExtension(file);
  if (!isCheckedMeshFile(extension)) return;
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::string fault = faultOfMeshFile(bytes, extension);
  if (!fault.empty()) refuseFile(file, fault);
}

// Assimp's message shortened to one line; some quote the file.
std::string oneLine(std::string message) {
  constexpr std::size_t kLongest = 160;
  message = message.substr(0, message.find('\n'));
  if (message.size() > kLongest) message = message.substr(0, kLongest) + " ...";
  return message;
}

// Assimp takes such a face for a polygon and, where there is no other, ends the program.
bool hasEmptyFace(const aiScene& scene) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i)
    for (unsigned k = 0; k < scene.mMeshes[i]->mNumFaces; ++k)
      if (scene.mMeshes[i]->mFaces[k].mNumIndices == 0) return true;
  return false;
}

}  // namespace

std::vector<NamedMesh> loadMeshParts(const std::filesystem::path& file, double metersPerUnit) {
  if (!(metersPerUnit > 0) || !std::isfinite(metersPerUnit))
    refuseFile(file, "metersPerUnit must be positive and finite");
  checkFile(file);
  Assimp::Importer importer;
  // Keeps the coordinates of the file, whichever axis it declares as up.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (scene && hasEmptyFace(*scene))
    refuseFile(file, "has a face without corners; export it again");
  if (scene) scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene || !scene->mRootNode)
    refuseFile(file, "is no mesh that can be read: " + oneLine(importer.GetErrorString()));
  std::vector<NamedMesh> parts;
  try {
    parts = meshParts(*scene, metersPerUnit);
  } catch (const std::invalid_argument& e) {
    refuseFile(file, e.what());
  }
  if (parts.empty()) refuseFile(file, "has no triangles");
  return parts;
}

Mesh loadMesh(const std::filesystem::path& file, double metersPerUnit) {
  return merged(loadMeshParts(file, metersPerUnit));
}

}  // namespace cloudcontact
