// Memory for arrays that contacts read in many places at once: a field's records, its samples.
//
// They lie beside each other in pages of 2 MB, if the system has such (Linux's transparent huge
// pages). In pages of 4 KB each look-up in a field of 10 MB begins with a walk through the page
// table: a nut's search took 2.5 times as long, and after other work had emptied the caches five
// times.
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <vector>

namespace cloudcontact {

// Memory that begins at a line of the cache. Throws std::bad_alloc, as new does. Any thread may
// give back what another has taken.
constexpr std::size_t kLargeAlign = 64;
void* takeLarge(std::size_t bytes);
void giveLarge(void* memory, std::size_t bytes) noexcept;

// Small arrays come from new.
template <typename T>
struct LargeAllocator {
  using value_type = T;
  static constexpr std::size_t kLarge = 16384;  // [bytes]
  static constexpr std::align_val_t kAlign{alignof(T)};
  static constexpr bool kAligned = alignof(T) > __STDCPP_DEFAULT_NEW_ALIGNMENT__;
  static_assert(alignof(T) <= kLargeAlign);

  LargeAllocator() = default;
  template <typename Other>
  LargeAllocator(const LargeAllocator<Other>&) {}
  T* allocate(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_alloc();
    const std::size_t bytes = count * sizeof(T);
    if (bytes >= kLarge) return static_cast<T*>(takeLarge(bytes));
    if constexpr (kAligned) return static_cast<T*>(::operator new(bytes, kAlign));
    return static_cast<T*>(::operator new(bytes));
  }
  void deallocate(T* memory, std::size_t count) noexcept {
    const std::size_t bytes = count * sizeof(T);
    if (bytes >= kLarge) return giveLarge(memory, bytes);
    if constexpr (kAligned) return ::operator delete(memory, kAlign);
    ::operator delete(memory);
  }
  friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace cloudcontact
