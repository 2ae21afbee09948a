// A heap of blocks: the smallest that is free and large enough; neighbours that are free are one.
#include "base/large_memory.h"

// An address sanitizer watches each array of its own.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#include <sys/mman.h>

#include <cstdint>
#include <map>
#include <mutex>

namespace cloudcontact {

namespace {

constexpr std::size_t kPage = std::size_t{2} << 20, kLine = kLargeAlign;
constexpr std::size_t kKept = 8 * kPage;  // of regions in which nothing is taken

std::size_t roundedUp(std::size_t bytes, std::size_t unit) {
  return (bytes + unit - 1) / unit * unit;
}

class LargeHeap {
 public:
  void* take(std::size_t bytes) {
    const std::size_t size = roundedUp(bytes, kLine);
    if (size < bytes) throw std::bad_alloc();
    const std::lock_guard lock(mutex_);
    auto best = free_.end();
    for (auto it = free_.begin(); it != free_.end(); ++it)
      if (it->second >= size && (best == free_.end() || it->second < best->second)) best = it;
    if (best == free_.end()) best = addRegion(roundedUp(size, kPage));
    const auto [at, room] = *best;
    free_.erase(best);
    if (regions_.count(at) && regions_.at(at) == room) empty_ -= room;
    if (room > size) free_.emplace(at + size, room - size);
    return at;
  }

  void give(void* memory, std::size_t bytes) noexcept {
    const std::lock_guard lock(mutex_);
    auto block = free_.emplace(static_cast<char*>(memory), roundedUp(bytes, kLine)).first;
    const auto next = std::next(block);
    if (next != free_.end() && joins(block, next)) {
      block->second += next->second;
      free_.erase(next);
    }
    if (block != free_.begin() && joins(std::prev(block), block)) {
      const auto before = std::prev(block);
      before->second += block->second;
      free_.erase(block);
      block = before;
    }
    dropIfEmpty(block);
  }

 private:
  using Blocks = std::map<char*, std::size_t>;

  bool joins(Blocks::iterator low, Blocks::iterator high) const {
    return low->first + low->second == high->first && !regions_.count(high->first);
  }

  Blocks::iterator addRegion(std::size_t size) {
    const std::size_t all = size + kPage;  // to begin with a page
    if (all < size) throw std::bad_alloc();
    void* const got =
        mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (got == MAP_FAILED) throw std::bad_alloc();
    char* const from = static_cast<char*>(got);
    const std::size_t skip = roundedUp(reinterpret_cast<std::uintptr_t>(from), kPage) -
                             reinterpret_cast<std::uintptr_t>(from);
    if (skip > 0) munmap(from, skip);
    if (skip < kPage) munmap(from + skip + size, kPage - skip);
    madvise(from + skip, size, MADV_HUGEPAGE);
    regions_.emplace(from + skip, size);
    empty_ += size;
    return free_.emplace(from + skip, size).first;
  }

  void dropIfEmpty(Blocks::iterator block) {
    const auto region = regions_.find(block->first);
    if (region == regions_.end() || region->second != block->second) return;
    empty_ += region->second;
    if (empty_ <= kKept) return;
    empty_ -= region->second;
    munmap(region->first, region->second);
    regions_.erase(region);
    free_.erase(block);
  }

  std::mutex mutex_;
  Blocks regions_, free_;
  std::size_t empty_ = 0;
};

// Never destroyed: arrays of static objects may outlive it.
LargeHeap& heap() {
  static LargeHeap& it = *new LargeHeap;
  return it;
}

}  // namespace

void* takeLarge(std::size_t bytes) {
  return heap().take(bytes);
}

void giveLarge(void* memory, std::size_t bytes) noexcept {
  heap().give(memory, bytes);
}

}  // namespace cloudcontact

#else

namespace cloudcontact {

void* takeLarge(std::size_t bytes) {
  return ::operator new (bytes, std::align_val_t{kLargeAlign});
}

void giveLarge(void* memory, std::size_t) noexcept {
  ::operator delete (memory, std::align_val_t{kLargeAlign});
}

}  // namespace cloudcontact

#endif
