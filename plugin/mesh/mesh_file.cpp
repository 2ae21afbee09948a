// Reads meshes through Assimp, once STL and PLY files are known to be whole: see mesh_file.h.
#include <cloudcontact/mesh/assimp_mesh.h>
#include <cloudcontact/mesh/mesh_file.h>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "base/file_name.h"
#include "mesh/ply.h"

namespace cloudcontact {

namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;

std::string faultOfStlText(std::string_view text) {
  bool facets = false;
  std::string_view last;
  for (std::string_view word = nextWord(text); !word.empty(); word = nextWord(text)) {
    facets |= word == "facet";
    if (word == "endsolid") last = word;
    if (word == "solid" || word == "endsolid")  // followed by a name of any words
      text.remove_prefix(std::min(text.find('\n'), text.size()));
    if (word == "solid" || word == "facet") last = {};
    if (word != "vertex") continue;
    for (int k = 0; k < 3; ++k)
      if (const std::string_view number = nextWord(text); !isNumber(number))
        return "has a vertex with `" + std::string(number.substr(0, 20)) +
               "` where a number should be; export it again";
  }
  if (last.empty()) return "is cut short: the text does not end with `endsolid`; export it again";
  return facets ? "" : "has no triangles";
}

std::string faultOfStl(std::string_view bytes) {
  std::uint64_t expected = 0, triangles = 0;
  if (bytes.size() >= kStlHeader) {
    for (std::size_t k = 0; k < 4; ++k)
      triangles = triangles << 8 | static_cast<unsigned char>(bytes[kStlHeader - 1 - k]);
    expected = kStlHeader + kStlTriangle * triangles;
    if (bytes.size() == expected) return triangles > 0 ? "" : "has no triangles";
  }
  // Binary files may begin with `solid` too, so their length decides first.
  if (bytes.starts_with("solid")) return faultOfStlText(bytes);
  if (bytes.size() < kStlHeader)
    return "is cut short or no STL: a binary STL has at least 84 bytes; export it again";
  return "is no STL, or cut short: its header says " + std::to_string(triangles) +
         " triangles, which take " + std::to_string(expected) + " bytes, but it has " +
         std::to_string(bytes.size()) + "; export it again";
}

std::string faultOfList(PlyNumbers& numbers, const PlyProperty& property, double count,
                        double vertices) {
  if (!(count >= 0)) return "has a list of negative length; export it again";
  for (double i = 0; i < count; ++i) {
    const std::optional<double> value = numbers.next(property.size, property.kind);
    if (!value) return "is cut short: its data end early; export it again";
    if (property.indices && !(*value >= 0 && *value < vertices)) {
      std::ostringstream fault;
      fault << "names vertex " << *value << ", but there are " << vertices << "; export it again";
      return fault.str();
    }
  }
  return "";
}

std::string faultOfPly(std::string_view bytes) {
  PlyHeader header;
  if (std::string fault = readPlyHeader(bytes, header); !fault.empty()) return fault;
  double vertices = 0;
  for (const PlyElement& element : header.elements)
    if (element.name == "vertex") vertices = static_cast<double>(element.count);
  PlyNumbers numbers(bytes.substr(header.length), header.format);
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) continue;
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (const PlyProperty& property : element.properties) {
        const bool list = property.countSize > 0;
        const std::optional<double> value = numbers.next(list ? property.countSize : property.size,
                                                         list ? property.countKind : property.kind);
        if (!value) return "is cut short: its data end early; export it again";
        if (!list) continue;
        if (std::string fault = faultOfList(numbers, property, *value, vertices); !fault.empty())
          return fault;
      }
  }
  return "";
}

// Checks STL and PLY before Assimp parses them: it accepts truncated files, loops on a PLY header
// without an end and reads past the end of short binary data.
void checkFile(const std::filesystem::path& file) {
  std::ifstream in = openFile(file, "a mesh file");
  if (std::filesystem::file_size(file) == 0) refuseFile(file, "is empty");
  const std::string extension = lowerExtension(file);
  if (extension != ".stl" && extension != ".ply") return;
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::string fault = extension == ".stl" ? faultOfStl(bytes) : faultOfPly(bytes);
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
