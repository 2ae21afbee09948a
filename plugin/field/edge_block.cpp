// Coverage of a block by sub-samples. Each is full, empty, or on a ramp that ends half a
// sub-sample's width on either side of the surface.
#include "field/edge_block.h"

#include "base/simd.h"
#include "field/share_lanes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>

namespace cloudcontact {

namespace {

float middleOf(int voxel, int axis) {
  const int at[3] = {voxel % 3, voxel / 3 % 3, voxel / 9};
  return static_cast<float>(at[axis] - 1);
}

// The share of a sub-sample below a face is no linear ramp but an S, more so for oblique faces.
// This cubic has the slope of the closed form in the middle. Linear ramps leave a residual of
// 0.0045 at a box's edges.
CC_INLINE float bent(float r, float bend) {
  return clamped(r + bend * r * (1.0f - r) * (r + r - 1.0f));
}

CC_INLINE float bentSlope(float r, float bend) {
  const float rest = r * (1.0f - r), slope = 1.0f + bend * (6.0f * r * (1.0f - r) - 1.0f);
  return rest > 0.0f ? positive(slope) : 0.0f;  // 0 at the ramp's ends
}

// A number for each of a voxel's sub-samples.
struct Lanes {
  alignas(64) float at[kPerVoxel];
};

// A layer of a voxel, read in one piece: 16 bytes at a time would wait for wider stores.
typedef F16 Layer __attribute__((may_alias));

// The layers of a voxel. A struct, because functions cannot return so wide a register everywhere.
struct Layers {
  F16 at[kSub];

  CC_INLINE explicit Layers(const Lanes& v) {
    for (int i = 0; i < kSub; ++i) at[i] = reinterpret_cast<const Layer*>(v.at)[i];
  }
};
CC_INLINE float total(const Lanes& v) {
  const Layers layer(v);
  const F4 sum = quarters((layer.at[0] + layer.at[1]) + (layer.at[2] + layer.at[3]));
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}
// The totals of four quarters.
CC_INLINE F4 totals(const F4& a, const F4& b, const F4& c, const F4& d) {
  const F4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) +
                __builtin_shufflevector(a, b, 2, 6, 3, 7),
           cd = __builtin_shufflevector(c, d, 0, 4, 1, 5) +
                __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

// What a kernel needs to know of a combination, with faces in registers.
template <int kFaces>
struct FacesOf {
  const float* outside[kFaces];
  float bend[kFaces];
  Angle angle[kFaces * (kFaces - 1) / 2];
  float side;

  CC_INLINE FacesOf(const Combination& c, int voxel) : side(c.concave ? 1.0f : -1.0f) {
    for (int i = 0; i < kFaces; ++i) {
      outside[i] = c.face[i]->outside(voxel);
      bend[i] = c.face[i]->bend();
    }
    for (int i = 0; i < kFaces * (kFaces - 1) / 2; ++i) angle[i] = c.angle[i];
  }
};

// The share of a sub-sample that the faces leave together, and its derivatives as each alone leaves
// more, by the linear ramp.
template <int kFaces>
struct Shared {
  float left, slope[kFaces];

  CC_INLINE Shared(const FacesOf<kFaces>& faces, int k) {
    float ramp[kFaces], r[kFaces];
#pragma GCC unroll 8
    for (int i = 0; i < kFaces; ++i) {
      ramp[i] = clamped(0.5f + faces.side * faces.outside[i][k]);
      r[i] = bent(ramp[i], faces.bend[i]);
    }
    join<kFaces>(r, faces.angle, left, slope);
#pragma GCC unroll 8
    for (int i = 0; i < kFaces; ++i) slope[i] *= bentSlope(ramp[i], faces.bend[i]);
  }
};

// From the derivative of each of the voxel's sub-samples: its sum, and that of it times x, y and z.
CC_INLINE Slope slopeOf(const FaceField& face, int voxel, const Lanes& derivative) {
  constexpr float a = -0.375f, b = -0.125f, c = 0.125f, d = 0.375f;  // positions within a voxel
  constexpr F16 x = {a, b, c, d, a, b, c, d, a, b, c, d, a, b, c, d},
                y = {a, a, a, a, b, b, b, b, c, c, c, c, d, d, d, d};
  const Layers layer(derivative);
  const F16 sum = (layer.at[0] + layer.at[1]) + (layer.at[2] + layer.at[3]);
  const F16 upward = d * (layer.at[3] - layer.at[0]) + c * (layer.at[2] - layer.at[1]);
  const F4 all = totals(quarters(sum), quarters(sum * x), quarters(sum * y), quarters(upward));
  const float scale = face.perShift() / kPerVoxel, shift = scale * all[0];
  return {shift,
          {scale * all[1] + shift * middleOf(voxel, 0), scale * all[2] + shift * middleOf(voxel, 1),
           scale * all[3] + shift * middleOf(voxel, 2)}};
}

// A voxel's coverage under two or more faces, and optionally its slopes. A union is computed as the
// intersection of complements.
template <int kFaces>
CC_INLINE float voxelCoverage(const Combination& c, int voxel) {
  const FacesOf<kFaces> faces(c, voxel);
  Lanes left;
  CC_INDEPENDENT
  for (int k = 0; k < kPerVoxel; ++k) left.at[k] = Shared<kFaces>(faces, k).left;
  return total(left) * (1.0f / kPerVoxel);
}

template <int kFaces>
CC_INLINE float voxelSlopes(const Combination& c, int voxel, Slope* slopes) {
  const FacesOf<kFaces> faces(c, voxel);
  Lanes left, slope[kFaces];
  CC_INDEPENDENT
  for (int k = 0; k < kPerVoxel; ++k) {
    const Shared<kFaces> shared(faces, k);
    left.at[k] = shared.left;
    slope[0].at[k] = shared.slope[0];
    slope[1].at[k] = shared.slope[1];
    if constexpr (kFaces > 2) slope[2].at[k] = shared.slope[2];
    if constexpr (kFaces > 3) slope[3].at[k] = shared.slope[3];
    if constexpr (kFaces > 4) slope[4].at[k] = shared.slope[4];
    if constexpr (kFaces > 5) slope[5].at[k] = shared.slope[5];
  }
  for (int i = 0; i < kFaces; ++i) slopes[i] = slopeOf(*c.face[i], voxel, slope[i]);
  return total(left) * (1.0f / kPerVoxel);
}

CC_LANES float shareOf(const Combination& c, int voxel) {
  return withFaces<2>(c.count,
                      [&](auto faces) CC_INLINE_LAMBDA { return voxelCoverage<faces>(c, voxel); });
}

CC_LANES float slopesOf(const Combination& c, int voxel, Slope* slopes) {
  return withFaces<2>(
      c.count, [&](auto faces) CC_INLINE_LAMBDA { return voxelSlopes<faces>(c, voxel, slopes); });
}

template <typename Visit>
void forEachBit(std::uint32_t bits, Visit&& visit) {
  for (; bits != 0; bits &= bits - 1) visit(std::countr_zero(bits));
}

// The voxels in the order of their weight: the middle, its sides, its edges, its corners.
constexpr std::uint32_t kByWeight[] = {
    1u << 13, 1u << 4 | 1u << 10 | 1u << 12 | 1u << 14 | 1u << 16 | 1u << 22, kAllVoxels};

// What a voxel adds to the square of the residual.
float squareOf(float target, float found, int voxel) {
  const float r = target - found;
  return irrelevant(found, r) ? 0.0f : windowWeight(voxel) * r * r;
}

// Covers the full and the empty voxels, and adds up their squares.
CC_LANES float simpleSquares(const BlockTarget& target, std::uint32_t full, std::uint32_t empty,
                             float* found) {
  alignas(64) float square[CC_WINDOW_LANES];
  CC_INDEPENDENT
  for (std::uint32_t v = 0; v < CC_WINDOW_LANES; ++v) {
    const bool isFull = full >> v & 1, isEmpty = empty >> v & 1;
    found[v] = isFull ? 1.0f : 0.0f;
    square[v] = isFull ? target.ifFull[v] : isEmpty ? target.ifEmpty[v] : 0.0f;
  }
  return windowTotal(square);
}

}  // namespace

float coverageOnly(const Combination& c, int voxel) {
  const float share = shareOf(c, voxel);
  return c.concave ? 1.0f - share : share;
}

BlockCases coverSimple(const Combination& c, float* coverage) {
  const BlockCases cases = casesOf(c);
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) coverage[v] = static_cast<float>(cases.full >> v & 1);
  for (int i = 0; i < c.count; ++i)
    forEachBit(cases.only[i], [&](int v) { coverage[v] = c.face[i]->cuts().volume[v]; });
  return cases;
}

void coverageOf(const Combination& c, float* coverage) {
  const BlockCases cases = coverSimple(c, coverage);
  forEachBit(cases.several, [&](int v) { coverage[v] = coverageOnly(c, v); });
}

float coverageAndSlopes(const Combination& c, int voxel, Slope* slopes) {
  const float share = slopesOf(c, voxel, slopes);
  return c.concave ? 1.0f - share : share;
}

BlockTarget::BlockTarget(const float* block) {
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
    coverage[v] = block[v];
    ifEmpty[v] = squareOf(block[v], 0, v);
    ifFull[v] = squareOf(block[v], 1, v);
    mass += block[v];
  }
}

BlockError blockError(const float* target, const float* found) {
  BlockError error;
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
    const float r = target[v] - found[v];
    const float w = irrelevant(found[v], r) ? 0.0f : windowWeight(v);
    error.square += w * r * r;
    error.weight += w;
  }
  return error;
}

// Adds up the square, cheap voxels first, until it exceeds what the bound allows even if all voxels
// count. The residual itself is summed in the fixed order.
float residualBelow(const BlockTarget& target, const Combination& c, float bound, float miss) {
  constexpr float kAllWeights = 5.85f;  // all voxels' weights add up to a little less
  const BlockCases cases = casesOf(c);
  const float most = bound * bound * kAllWeights;
  constexpr int kMiddle = CC_WINDOW_VOXELS / 2;
  alignas(64) float found[CC_WINDOW_LANES];
  float square = simpleSquares(target, cases.full, cases.empty, found);
  const auto misses = [&] { return std::abs(found[kMiddle] - target.coverage[kMiddle]) > miss; };
  const std::uint32_t partly = kAllVoxels & ~(cases.full | cases.empty);
  if (square > most || (!(partly >> kMiddle & 1) && misses())) return kTooMuch;
  for (int i = 0; i < c.count; ++i)
    forEachBit(cases.only[i], [&](int v) {
      found[v] = c.face[i]->cuts().volume[v];
      square += squareOf(target.coverage[v], found[v], v);
    });
  if (square > most) return kTooMuch;
  std::uint32_t left = cases.several;
  for (const std::uint32_t group : kByWeight) {
    for (std::uint32_t bits = left & group; bits != 0; bits &= bits - 1) {
      const int v = std::countr_zero(bits);
      found[v] = coverageOnly(c, v);
      square += squareOf(target.coverage[v], found[v], v);
      if (square > most) return kTooMuch;
    }
    left &= ~group;
    if (misses()) return kTooMuch;
  }
  const float residual = blockError(target.coverage, found).residual();
  return residual < bound ? residual : kTooMuch;
}

}  // namespace cloudcontact
