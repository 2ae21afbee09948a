// What must hold of a mesh file before a parser may see it: see mesh_file_check.h.
#include "geometry/mesh_file_check.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>
#include <vector>

namespace cloudcontact {

namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;

// The next word of a text, or nothing at its end.
std::string_view nextWord(std::string_view& text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  const auto* begin = std::find_if_not(text.begin(), text.end(), blank);
  const auto* end = std::find_if(begin, text.end(), blank);
  const std::string_view word(begin, static_cast<std::size_t>(end - begin));
  text.remove_prefix(static_cast<std::size_t>(end - text.begin()));
  return word;
}

bool isNumber(std::string_view word) {
  const std::string text(word);
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

std::string faultOfStlText(std::string_view text) {
  bool facets = false;
  std::string_view last;
  for (std::string_view word = nextWord(text); !word.empty(); word = nextWord(text)) {
    facets |= word == "facet";
    if (word == "endsolid") last = word;
    if (word == "solid" || word == "endsolid")  // a name follows, of any words
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
  // Binary files may begin with `solid` too, but are known by their length.
  if (bytes.starts_with("solid")) return faultOfStlText(bytes);
  if (bytes.size() < kStlHeader)
    return "is cut short or no STL: a binary STL has at least 84 bytes; export it again";
  return "is no STL, or cut short: its header says " + std::to_string(triangles) +
         " triangles, which take " + std::to_string(expected) + " bytes, but it has " +
         std::to_string(bytes.size()) + "; export it again";
}

// One property of a PLY element: its numbers' size in bytes, and that of a list's length.
struct PlyProperty {
  std::size_t size = 0, countSize = 0;  // countSize 0: no list
  char kind = 'i';                      // f, i, u
  char countKind = 'u';
  bool indices = false;  // names vertices
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  std::string format;
  std::vector<PlyElement> elements;
  std::size_t length = 0;
};

bool plyType(const std::string& name, std::size_t& size, char& kind) {
  static constexpr struct {
    const char* name;
    std::size_t size;
    char kind;
  } kTypes[] = {{"char", 1, 'i'},  {"int8", 1, 'i'},    {"uchar", 1, 'u'},  {"uint8", 1, 'u'},
                {"short", 2, 'i'}, {"int16", 2, 'i'},   {"ushort", 2, 'u'}, {"uint16", 2, 'u'},
                {"int", 4, 'i'},   {"int32", 4, 'i'},   {"uint", 4, 'u'},   {"uint32", 4, 'u'},
                {"float", 4, 'f'}, {"float32", 4, 'f'}, {"double", 8, 'f'}, {"float64", 8, 'f'}};
  for (const auto& type : kTypes)
    if (name == type.name) return size = type.size, kind = type.kind, true;
  return false;
}

// A line `property ...` of the header; false where it is not one.
bool readProperty(std::istringstream& words, PlyElement& element) {
  PlyProperty property;
  std::string type, name;
  words >> type;
  if (type == "list") {
    std::string countType;
    words >> countType >> type;
    if (!plyType(countType, property.countSize, property.countKind)) return false;
  }
  if (!plyType(type, property.size, property.kind) || !(words >> name)) return false;
  property.indices = property.countSize > 0 && (name == "vertex_indices" || name == "vertex_index");
  element.properties.push_back(property);
  return true;
}

std::string readHeader(std::string_view bytes, PlyHeader& header) {
  std::size_t at = 0;
  for (bool first = true;; first = false) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string_view::npos)
      return first ? "is no PLY: it does not begin with `ply`"
                   : "is cut short: its header has no `end_header`; export it again";
    std::istringstream words{std::string(bytes.substr(at, end - at))};
    at = end + 1;
    std::string word;
    words >> word;
    if (first && word != "ply") return "is no PLY: it does not begin with `ply`";
    if (word == "end_header") break;
    if (word == "format") words >> header.format;
    if (word == "element") {
      PlyElement element;
      if (!(words >> element.name >> element.count)) return "has a PLY header with a bad element";
      header.elements.push_back(element);
    }
    if (word == "property" &&
        (header.elements.empty() || !readProperty(words, header.elements.back())))
      return "has a PLY header with a bad property";
  }
  header.length = at;
  return "";
}

// The numbers of a PLY file one after the other, as text or bytes.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view bytes, const std::string& format)
      : left_(bytes), text_(format == "ascii"), big_(format == "binary_big_endian") {}

  std::optional<double> next(std::size_t size, char kind) {
    if (text_) return word();
    if (left_.size() < size) return std::nullopt;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i)
      bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(left_[big_ ? size - 1 - i : i]))
              << (8 * i);
    left_.remove_prefix(size);
    if (kind == 'f' && size == 8) return std::bit_cast<double>(bits);
    if (kind == 'f') return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    const std::uint64_t sign = std::uint64_t{1} << (8 * size - 1);
    const double value = static_cast<double>(bits);
    return kind == 'i' && (bits & sign) ? value - 2 * static_cast<double>(sign) : value;
  }

 private:
  std::optional<double> word() {
    const std::string text(nextWord(left_));
    if (text.empty()) return std::nullopt;
    return std::strtod(text.c_str(), nullptr);
  }
  std::string_view left_;
  bool text_, big_;
};

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
  if (std::string fault = readHeader(bytes, header); !fault.empty()) return fault;
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
