// The PLY format: its header and its numbers one after the other, for checking meshes and reading
// points.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cloudcontact {

// The next word of a text, taken from it, or nothing at its end.
std::string_view nextWord(std::string_view& text);
bool isNumber(std::string_view word);

// One property of a PLY element: its numbers' size in bytes, and that of a list's length.
struct PlyProperty {
  std::string name;
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

// What is wrong with the header of a file, or nothing: then `header` is it.
std::string readPlyHeader(std::string_view bytes, PlyHeader& header);

// The numbers of a PLY file one after the other, as text or bytes.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view bytes, const std::string& format)
      : left_(bytes), text_(format == "ascii"), big_(format == "binary_big_endian") {}

  // Nothing where the file ends. Of a text, NaN where the word is no number.
  std::optional<double> next(std::size_t size, char kind);
  std::size_t left() const { return left_.size(); }  // bytes

 private:
  std::string_view left_;
  bool text_, big_;
};

}  // namespace cloudcontact
