// Arrays of the heap of large pages keep what is written into them, begin at lines of the cache, do
// not overlap, and what is given back is used again.
#include "base/large_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <thread>

namespace cloudcontact::large_memory_test {
namespace {

using Array = LargeVector<std::uint32_t>;

// Takes and gives back arrays of 4 KB to 4 MB at random; each is full of its own number.
void takeAndGive(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Array> held(24);
  for (std::uint32_t number = 1; number < 2000; ++number) {
    Array& one = held[random() % held.size()];
    for (const std::uint32_t x : one) ASSERT_EQ(x, one.front());
    const std::size_t count = std::size_t{1} << (10 + random() % 11);
    one = Array();
    one.resize(count - random() % (count / 2), seed + number);
    const bool large = one.size() * sizeof(std::uint32_t) >= Array::allocator_type::kLarge;
    ASSERT_TRUE(!large || reinterpret_cast<std::uintptr_t>(one.data()) % kLargeAlign == 0);
  }
}

TEST(LargeMemory, ArraysKeepWhatIsWrittenIntoThem) {
  takeAndGive(1);
}

TEST(LargeMemory, ThreadsShareIt) {
  std::vector<std::thread> threads;
  for (std::uint32_t k = 0; k < 4; ++k) threads.emplace_back(takeAndGive, 10000 * k);
  for (std::thread& thread : threads) thread.join();
}

// Whatever the order, what is given back makes room: 200 rounds of 6 MB stay within few pages.
TEST(LargeMemory, WhatIsGivenBackIsUsedAgain) {
  constexpr std::size_t kPage = 2 << 20;
  std::mt19937 random(3);
  std::set<std::uintptr_t> pages;
  for (int round = 0; round < 200; ++round) {
    std::vector<std::pair<void*, std::size_t>> held;
    for (std::size_t all = 0; all < 3 * kPage;) {
      const std::size_t bytes = 20000 + random() % 500000;
      held.emplace_back(takeLarge(bytes), bytes);
      pages.insert(reinterpret_cast<std::uintptr_t>(held.back().first) / kPage);
      all += bytes;
    }
    std::shuffle(held.begin(), held.end(), random);
    for (const auto& [memory, bytes] : held) giveLarge(memory, bytes);
  }
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(pages.size(), 12u);
#endif
}

struct alignas(64) Line {
  char bytes[64];
};

TEST(LargeMemory, SmallArraysAreAlignedToo) {
  const LargeVector<Line> few(3);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(few.data()) % 64, 0u);
}

TEST(LargeMemory, TooMuchThrows) {
  EXPECT_THROW(LargeAllocator<double>().allocate(~std::size_t{0} / 4), std::bad_alloc);
  EXPECT_THROW(takeLarge(~std::size_t{0} - 5), std::bad_alloc);
}

}  // namespace
}  // namespace cloudcontact::large_memory_test
