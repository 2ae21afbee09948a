// The PLY format: its header and the sequence of its numbers. For checking meshes and reading
// points.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cloudcontact {

// Removes the next word from a text and returns it; empty at the end.
std::string_view nextWord(std::string_view& text);
bool isNumber(std::string_view word);

// One property of a PLY element, a number or a list.
struct PlyProperty {
  std::string name;
  std::size_t size = 0, countSize = 0;  // bytes of a number and of a list's length; 0: no list
  char kind = 'i';                      // f, i, u
  char countKind = 'u';
  bool indices = false;  // indices of vertices
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

// Reads the header of a file. Returns the fault; empty where there is none.
std::string readPlyHeader(std::string_view bytes, PlyHeader& header);

// The numbers of a PLY file in sequence, from text or bytes.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view bytes, const std::string& format)
      : left_(bytes), text_(format == "ascii"), big_(format == "binary_big_endian") {}

  // Empty at the end of the file; NaN for a word of text that is not a number.
  std::optional<double> next(std::size_t size, char kind);
  std::size_t left() const { return left_.size(); }  // remaining bytes

 private:
  std::string_view left_;
  bool text_, big_;
};

}  // namespace cloudcontact
