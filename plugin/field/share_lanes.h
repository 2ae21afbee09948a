// What faces leave of a volume that several of them cut, for loops over lanes.
#pragma once

#include "field/combination.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace cloudcontact {

// Inlined into the clone that calls it, so that it is compiled for the same instruction set.
#define CC_INLINE [[gnu::always_inline]] inline
#define CC_INLINE_LAMBDA __attribute__((always_inline))

// Calls f with `count` faces, kLeast to kMostEdgeFaces, as a constant.
template <int kLeast, typename F>
CC_INLINE auto withFaces(int count, F&& f) {
  if constexpr (kLeast < kMostEdgeFaces) {
    if (count != kLeast) return withFaces<kLeast + 1>(count, f);
  }
  return f(std::integral_constant<int, kLeast>());
}

struct Joined {
  float both, byFirst, bySecond;  // the share left, and its derivatives by r and q
};

// max(v, 0), and the lesser of two that are not negative. As integers, because the compiler has no
// vector instruction for the comparison of floats that leaves NaN and -0 as they are.
CC_INLINE float positive(float v) {
  return std::bit_cast<float>(std::max(std::bit_cast<std::int32_t>(v), 0));
}
CC_INLINE float lesser(float a, float b) {
  return std::bit_cast<float>(
      std::min(std::bit_cast<std::int32_t>(a), std::bit_cast<std::int32_t>(b)));
}

CC_INLINE Joined join(float r, float q, float alike, float opposed) {
  const float product = r * q, over = r + q - 1.0f;
  const float free = 1.0f - alike - opposed, apart = over > 0.0f ? opposed : 0.0f;
  const float first = r < q ? alike : 0.0f;
  return {product + alike * (lesser(r, q) - product) + opposed * (positive(over) - product),
          free * q + first + apart, free * r + (alike - first) + apart};
}

CC_INLINE float clamped(float v) {
  return lesser(positive(v), 1.0f);
}

// What all faces leave of a sub-sample together, and its derivatives by what each leaves alone. A
// face shares the sub-sample with those before it by its angle to the one of them that leaves the
// least there.
template <int kFaces>
CC_INLINE void join(const float* r, const Angle* angles, float& left, float* slope) {
  left = r[0];
  slope[0] = 1.0f;
#pragma GCC unroll 8
  for (int j = 1; j < kFaces; ++j) {
    const Angle* const angle = angles + j * (j - 1) / 2;
    float least = r[0], alike = angle[0].alike, opposed = angle[0].opposed;
#pragma GCC unroll 8
    for (int i = 1; i < j; ++i) {
      const bool former = least < r[i];
      alike = former ? alike : angle[i].alike;
      opposed = former ? opposed : angle[i].opposed;
      least = former ? least : r[i];
    }
    const Joined joined = join(left, r[j], alike, opposed);
    left = joined.both;
    slope[j] = joined.bySecond;
#pragma GCC unroll 8
    for (int i = 0; i < j; ++i) slope[i] *= joined.byFirst;
  }
}

// Sums run over the four layers of a voxel first, then over the 16 sub-samples of a layer in
// halves. This fixes the order of additions whatever the register width.
typedef float F4 __attribute__((vector_size(16)));
typedef float F16 __attribute__((vector_size(64)));

CC_INLINE F4 quarters(const F16& v) {
  const F4 a = __builtin_shufflevector(v, v, 0, 1, 2, 3),
           b = __builtin_shufflevector(v, v, 4, 5, 6, 7),
           c = __builtin_shufflevector(v, v, 8, 9, 10, 11),
           d = __builtin_shufflevector(v, v, 12, 13, 14, 15);
  return (a + b) + (c + d);
}

// The sum over a window's voxels, zero in the lanes beyond.
CC_INLINE float windowTotal(const float* lanes) {
  F16 half[2];
  std::memcpy(half, lanes, sizeof half);
  const F4 sum = quarters(half[0] + half[1]);
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

}  // namespace cloudcontact
