// FNV-1a, 64 bits (Fowler, Noll, Vo): a checksum of files and of states, equal on every machine.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cloudcontact {

class Fnv1a {
 public:
  // Byte by byte, as the standard has it.
  void add(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) addWord(p[i]);
  }
  // A whole number in one step: faster, and independent of the machine's byte order.
  void addWord(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001B3ull; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ull;
};

}  // namespace cloudcontact
