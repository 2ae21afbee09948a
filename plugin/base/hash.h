// Checksums of files and of states, equal on every machine: FNV-1a, 64 bits (Fowler, Noll, Vo), and
// a faster one for large data.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

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

// FNV-1a over 8 bytes at a time, with an extra mixing step. On little-endian machines alone, unless
// the data is turned.
class WordHash {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* const p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, p + i, std::min<std::size_t>(8, bytes - i));
      mix(word);
    }
  }
  void mix(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x100000001B3ull;
    value_ ^= value_ >> 29;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ull;
};

}  // namespace cloudcontact
