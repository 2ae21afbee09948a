// Arrays of numbers behind a JSON text that refers to them, for the page (page/record.js).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/json.h"

namespace cloudcontact::program {

// Format: "RPLY", the length of a JSON text as 4 bytes (little endian), that text, padded with
// blanks to a multiple of 8 bytes, and the arrays. The JSON refers to an array as {"at": byte after
// the text, "length": numbers, "type": "u8" | "i8" | "u16" | "i16" | "i32" | "u32" |
// "f32"}.
class PackedArrays {
 public:
  Json add(const std::vector<std::uint8_t>& v) { return add(v.data(), v.size(), "u8"); }
  Json add(const std::vector<std::int8_t>& v) { return add(v.data(), v.size(), "i8"); }
  Json add(const std::vector<std::uint16_t>& v) { return add(v.data(), v.size(), "u16"); }
  Json add(const std::vector<std::int16_t>& v) { return add(v.data(), v.size(), "i16"); }
  Json add(const std::vector<std::int32_t>& v) { return add(v.data(), v.size(), "i32"); }
  Json add(const std::vector<std::uint32_t>& v) { return add(v.data(), v.size(), "u32"); }
  Json add(const std::vector<float>& v) { return add(v.data(), v.size(), "f32"); }

  std::string packed(const Json& json) const;

 private:
  template <class Number>
  Json add(const Number* numbers, std::size_t count, const char* type) {
    bytes_.resize((bytes_.size() + 7) / 8 * 8);
    const std::size_t at = bytes_.size();
    bytes_.append(reinterpret_cast<const char*>(numbers), count * sizeof(Number));
    return {{"at", at}, {"length", count}, {"type", type}};
  }

  std::string bytes_;
};

}  // namespace cloudcontact::program
