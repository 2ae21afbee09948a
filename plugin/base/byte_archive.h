// Values as bytes in memory, the lowest byte of each number first, for records within files. One
// function names the fields of a struct for both ways: archive(x.stiffness, x.damping).
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace cloudcontact {

// Numbers, enums, and arrays and Eigen's vectors of them.
template <typename T>
concept PlainNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <PlainNumber Number>
Number inFileOrder(Number x) {
  if constexpr (std::endian::native == std::endian::big) {
    auto bytes = std::bit_cast<std::array<char, sizeof x>>(x);
    std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
  }
  return x;
}

class ByteWriter {
 public:
  static constexpr bool kReads = false;

  template <typename... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <PlainNumber Number>
  void put(const Number& x) {
    const auto ordered = std::bit_cast<std::array<char, sizeof x>>(inFileOrder(x));
    bytes_.append(ordered.data(), ordered.size());
  }
  template <typename Scalar, int kRows>
  void put(const Eigen::Matrix<Scalar, kRows, 1>& v) {
    for (int i = 0; i < kRows; ++i) put(v[i]);
  }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }

  std::string bytes_;
};

// Throws std::runtime_error where the bytes end too early.
class ByteReader {
 public:
  static constexpr bool kReads = true;

  explicit ByteReader(std::span<const char> bytes) : left_(bytes) {}
  template <typename... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }
  std::size_t left() const { return left_.size(); }
  // The next bytes, passed over.
  std::span<const char> take(std::uint64_t count) {
    if (count > left_.size()) throw std::runtime_error("a record is cut short");
    const std::span<const char> taken = left_.first(std::size_t(count));
    left_ = left_.subspan(std::size_t(count));
    return taken;
  }

 private:
  template <PlainNumber Number>
  void get(Number& x) {
    std::memcpy(&x, take(sizeof x).data(), sizeof x);
    x = inFileOrder(x);
  }
  void get(bool& x) {
    const char byte = take(1)[0];
    if (byte != 0 && byte != 1) throw std::runtime_error("a record has a flag that is none");
    x = byte == 1;
  }
  template <typename Scalar, int kRows>
  void get(Eigen::Matrix<Scalar, kRows, 1>& v) {
    for (int i = 0; i < kRows; ++i) get(v[i]);
  }
  void get(std::string& text) {
    std::uint64_t size = 0;
    get(size);
    const std::span<const char> taken = take(size);
    text.assign(taken.data(), taken.size());
  }

  std::span<const char> left_;
};

// A list, each item by `visit(archive, item)`.
template <typename Archive, typename Items, typename Visit>
void listIn(Archive& archive, Items& items, Visit&& visit) {
  auto count = static_cast<std::uint64_t>(items.size());
  archive(count);
  if constexpr (Archive::kReads) {
    if (count > archive.left()) throw std::runtime_error("a record says an impossible length");
    // One by one: an item may take hundreds of times the byte that it takes in the record.
    items.clear();
    for (; count > 0; --count) visit(archive, items.emplace_back());
  } else {
    for (auto& item : items) visit(archive, item);
  }
}

template <typename Archive, typename Item, typename Visit>
void optionalIn(Archive& archive, std::optional<Item>& item, Visit&& visit) {
  bool is = item.has_value();
  archive(is);
  if constexpr (Archive::kReads) {
    item.reset();
    if (is) item.emplace();
  }
  if (is) visit(archive, *item);
}

}  // namespace cloudcontact
