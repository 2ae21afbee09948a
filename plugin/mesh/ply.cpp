// Reading PLY: see ply.h.
#include "mesh/ply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace cloudcontact {

namespace {

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

// Reads the rest of a header line `property ...`; false on a malformed one.
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
  property.name = name;
  property.indices = property.countSize > 0 && (name == "vertex_indices" || name == "vertex_index");
  element.properties.push_back(property);
  return true;
}

}  // namespace

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

std::string readPlyHeader(std::string_view bytes, PlyHeader& header) {
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
  if (header.format != "ascii" && !header.format.starts_with("binary_"))
    return "has a PLY header without a known format; export it again";
  return "";
}

std::optional<double> PlyNumbers::next(std::size_t size, char kind) {
  if (text_) {
    const std::string_view word = nextWord(left_);
    if (word.empty()) return std::nullopt;
    return isNumber(word) ? std::strtod(std::string(word).c_str(), nullptr) : NAN;
  }
  if (left_.size() < size) return std::nullopt;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i)
    bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(left_[big_ ? size - 1 - i : i]))
            << (8 * i);
  left_.remove_prefix(size);
  if (kind == 'f' && size == 8) return std::bit_cast<double>(bits);
  if (kind == 'f') return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  const std::uint64_t sign = std::uint64_t{1} << (8 * size - 1);
  const double value = bits;
  return kind == 'i' && (bits & sign) ? value - 2 * static_cast<double>(sign) : value;
}

}  // namespace cloudcontact
