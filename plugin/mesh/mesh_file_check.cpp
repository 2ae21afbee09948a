// Checks STL and PLY files: see mesh_file_check.h.
#include "mesh/mesh_file_check.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <sstream>

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
  if (header.format != "ascii" && !header.format.starts_with("binary_"))
    return "has a PLY header without a known format; export it again";
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

}  // namespace

bool isCheckedMeshFile(std::string_view extension) {
  return extension == ".stl" || extension == ".ply";
}

std::string faultOfMeshFile(std::string_view bytes, std::string_view extension) {
  if (extension == ".stl") return faultOfStl(bytes);
  if (extension == ".ply") return faultOfPly(bytes);
  return "";
}

}  // namespace cloudcontact
