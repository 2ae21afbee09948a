// Span: items in a row that somebody else owns. std::span is C++20, and programs in C++17 use these
// headers too.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <type_traits>
#include <utility>

namespace cloudcontact {

template <typename Item>
class Span {
 public:
  using value_type = std::remove_cv_t<Item>;
  using iterator = Item*;

  Span() = default;
  Span(Item* first, std::size_t count) : first_(first), count_(count) {}
  // Any container in a row, which must outlive the span.
  template <typename Container, typename = std::enable_if_t<std::is_convertible_v<
                                    decltype(std::data(std::declval<Container&>())), Item*>>>
  Span(Container&& items) : first_(std::data(items)), count_(std::size(items)) {}
  // For calls: cut({a, b}).
  Span(std::initializer_list<value_type> items) : first_(items.begin()), count_(items.size()) {}

  Item* data() const { return first_; }
  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  Item* begin() const { return first_; }
  Item* end() const { return first_ + count_; }
  Item& operator[](std::size_t i) const { return first_[i]; }

 private:
  Item* first_ = nullptr;
  std::size_t count_ = 0;
};

}  // namespace cloudcontact
