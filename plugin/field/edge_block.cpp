// Coverage of a block by sub-samples. Each is full, empty, or on a ramp that ends half a
// sub-sample's width on either side of the surface.
#include "field/edge_block.h"

#include "base/simd.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace cloudcontact {

namespace {

float middleOf(int voxel, int axis) {
  const int at[3] = {voxel % 3, voxel / 3 % 3, voxel / 9};
  return static_cast<float>(at[axis] - 1);
}

// How much of a sub-sample two faces leave together, if each alone leaves r and q: r q for faces at
// right angles, which cut independently; min(r, q) for parallel faces; max(0, r + q - 1) for
// opposite ones. Interpolated by the angle, which is exact where both run through the center. With
// min(r, q) throughout, edges lie 0.03 voxel inside.
Angle angleOf(const Eigen::Vector3f& n, const Eigen::Vector3f& m) {
  const float turn = std::acos(std::clamp(n.dot(m), -1.0f, 1.0f)) * (2.0f / 3.14159265f);
  return {std::max(1.0f - turn, 0.0f), std::max(turn - 1.0f, 0.0f)};
}

// Inlined into the clone that calls it, so that it is compiled for the same instruction set.
#define CC_INLINE [[gnu::always_inline]] inline

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

// Sums run over the four layers of a voxel first, then over the 16 sub-samples of a layer in
// halves. This fixes the order of additions whatever the register width.
typedef float F4 __attribute__((vector_size(16)));
typedef float F16 __attribute__((vector_size(64)));

// The layers of a voxel. A struct, because functions cannot return so wide a register everywhere.
struct Layers {
  F16 at[kSub];

  CC_INLINE explicit Layers(const Lanes& v) { std::memcpy(at, v.at, sizeof at); }
};
CC_INLINE F4 quarters(const F16& v) {
  const F4 a = __builtin_shufflevector(v, v, 0, 1, 2, 3),
           b = __builtin_shufflevector(v, v, 4, 5, 6, 7),
           c = __builtin_shufflevector(v, v, 8, 9, 10, 11),
           d = __builtin_shufflevector(v, v, 12, 13, 14, 15);
  return (a + b) + (c + d);
}
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
  switch (c.count) {
    case 2:
      return voxelCoverage<2>(c, voxel);
    case 3:
      return voxelCoverage<3>(c, voxel);
    case 4:
      return voxelCoverage<4>(c, voxel);
    case 5:
      return voxelCoverage<5>(c, voxel);
    default:
      return voxelCoverage<6>(c, voxel);
  }
}

CC_LANES float slopesOf(const Combination& c, int voxel, Slope* slopes) {
  switch (c.count) {
    case 2:
      return voxelSlopes<2>(c, voxel, slopes);
    case 3:
      return voxelSlopes<3>(c, voxel, slopes);
    case 4:
      return voxelSlopes<4>(c, voxel, slopes);
    case 5:
      return voxelSlopes<5>(c, voxel, slopes);
    default:
      return voxelSlopes<6>(c, voxel, slopes);
  }
}

// The coverage of all voxels at once, by the parts of a voxel that each face alone leaves, joined
// as if they were those of a sub-sample.
template <int kFaces>
CC_INLINE void roughly(const Combination& c, float* coverage) {
  const float* alone[kFaces];
  for (int i = 0; i < kFaces; ++i) alone[i] = c.face[i]->cuts().volume;
  const float start = c.concave ? 1.0f : 0.0f, side = c.concave ? -1.0f : 1.0f;
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    float r[kFaces], left, slope[kFaces];
#pragma GCC unroll 8
    for (int i = 0; i < kFaces; ++i) r[i] = start + side * alone[i][k];
    join<kFaces>(r, c.angle, left, slope);
    coverage[k] = start + side * left;
  }
}

// The sum over a window's voxels, zero in the lanes beyond.
CC_INLINE float windowTotal(const float* lanes) {
  F16 half[2];
  std::memcpy(half, lanes, sizeof half);
  const F4 sum = quarters(half[0] + half[1]);
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

// windowWeight(), 0 in the lanes beyond.
struct LaneWeights {
  alignas(64) float at[CC_WINDOW_LANES] = {};

  constexpr LaneWeights() {
    for (std::size_t v = 0; v < CC_WINDOW_VOXELS; ++v) at[v] = kWindowWeights[v];
  }
};
constexpr LaneWeights kLaneWeights;

CC_INLINE void roughlyAny(const Combination& c, float* coverage) {
  switch (c.count) {
    case 1:
      return roughly<1>(c, coverage);
    case 2:
      return roughly<2>(c, coverage);
    case 3:
      return roughly<3>(c, coverage);
    case 4:
      return roughly<4>(c, coverage);
    case 5:
      return roughly<5>(c, coverage);
    default:
      return roughly<6>(c, coverage);
  }
}

template <int kFaces>
CC_INLINE float massWithPlane(const Combination& c, const Eigen::Vector3f& n, float s) {
  const float* alone[kFaces];
  for (int i = 0; i + 1 < kFaces; ++i) alone[i] = c.face[i]->cuts().volume;
  const float start = c.concave ? 1.0f : 0.0f, side = c.concave ? -1.0f : 1.0f;
  const float nx = n.x(), ny = n.y(), nz = n.z();
  alignas(64) float found[CC_WINDOW_LANES];
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    const float x = static_cast<float>(k % 3 - 1), y = static_cast<float>(k / 3 % 3 - 1),
                z = static_cast<float>(k / 9 - 1);
    float r[kFaces], left, slope[kFaces];
#pragma GCC unroll 8
    for (int i = 0; i + 1 < kFaces; ++i) r[i] = start + side * alone[i][k];
    r[kFaces - 1] = start + side * ccCutCube(nx, ny, nz, s - (nx * x + ny * y + nz * z)).volume;
    join<kFaces>(r, c.angle, left, slope);
    found[k] = k < CC_WINDOW_VOXELS ? start + side * left : 0.0f;
  }
  return windowTotal(found);
}

CC_LANES [[gnu::flatten]] float massWith(const Combination& c, const Eigen::Vector3f& n, float s) {
  return c.count == 2 ? massWithPlane<2>(c, n, s) : massWithPlane<3>(c, n, s);
}

CC_LANES float roughSquare(const BlockTarget& target, const Combination& c) {
  alignas(64) float found[CC_WINDOW_LANES], square[CC_WINDOW_LANES], counted[CC_WINDOW_LANES];
  roughlyAny(c, found);
  CC_INDEPENDENT
  for (int v = 0; v < CC_WINDOW_LANES; ++v) {
    const float r = target.coverage[v] - found[v];
    const bool none = (found[v] <= 0.0f) | (found[v] >= 1.0f), right = std::abs(r) < 2e-3f;
    counted[v] = none & right ? 0.0f : kLaneWeights.at[v];
    square[v] = counted[v] * r * r;
  }
  const float weight = windowTotal(counted);
  return weight > 0 ? windowTotal(square) / weight : 1.0f;
}

// Where one face lies farther outside than the other throughout a voxel. Over half a voxel's edge
// the difference of their distances changes by its gradient at the center, and by their bend.
CC_LANES void compare(const Face& a, const float* middleA, const Face& b, const float* middleB,
                      Angle& angle) {
  const float scaleA = a.n.lpNorm<1>() / kSub, scaleB = b.n.lpNorm<1>() / kSub;
  float n[3], c[3][3], bend = 0;
  for (int i = 0; i < 3; ++i) {
    n[i] = a.n[i] - b.n[i];
    for (int j = 0; j < 3; ++j) {
      c[i][j] = a.curvature(i, j) - b.curvature(i, j);
      bend += 0.125f * std::abs(c[i][j]);
    }
  }
  alignas(64) float apart[CC_WINDOW_LANES], most[CC_WINDOW_LANES];
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    const float x = static_cast<float>(k % 3 - 1), y = static_cast<float>(k / 3 % 3 - 1),
                z = static_cast<float>(k / 9 - 1);
    const float mx = n[0] + (c[0][0] * x + (c[0][1] * y + c[0][2] * z));
    const float my = n[1] + (c[1][0] * x + (c[1][1] * y + c[1][2] * z));
    const float mz = n[2] + (c[2][0] * x + (c[2][1] * y + c[2][2] * z));
    most[k] = 0.5f * (std::abs(mx) + (std::abs(my) + std::abs(mz))) + bend;
    apart[k] = middleA[k] * scaleA - middleB[k] * scaleB;
  }
  std::uint32_t more = 0, less = 0;
  for (std::uint32_t k = 0; k < CC_WINDOW_LANES; ++k) {
    more |= apart[k] > most[k] ? 1u << k : 0u;
    less |= -apart[k] > most[k] ? 1u << k : 0u;
  }
  angle.more = more & kAllVoxels;
  angle.less = less & kAllVoxels;
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

}  // namespace

Angle angleBetween(const FaceField& a, const FaceField& b) {
  Angle angle = angleOf(a.face().n, b.face().n);
  compare(a.face(), a.middle(), b.face(), b.middle(), angle);
  return angle;
}

Combination combine(std::initializer_list<const FaceField*> faces, bool concave) {
  Combination c;
  c.concave = concave;
  for (const FaceField* face : faces) c.face[c.count++] = face;
  measureAngles(c);
  return c;
}

void measureAngles(Combination& c) {
  Angle* angle = c.angle;
  for (int j = 1; j < c.count; ++j)
    for (int i = 0; i < j; ++i) *angle++ = angleBetween(*c.face[i], *c.face[j]);
}

float coverageOnly(const Combination& c, int voxel) {
  const float share = shareOf(c, voxel);
  return c.concave ? 1.0f - share : share;
}
BlockCases casesOf(const Combination& c) {
  BlockCases cases;
  std::uint32_t beyond = 0, once = 0, crossed[kMostFaces];
  for (int i = 0; i < c.count; ++i) {
    const std::uint32_t outer = c.face[i]->outer(), inner = c.face[i]->inner();
    beyond |= kAllVoxels & (c.concave ? inner : outer);
    crossed[i] = kAllVoxels & ~(outer | inner);
    once |= crossed[i];
  }
  (c.concave ? cases.full : cases.empty) = beyond;
  (c.concave ? cases.empty : cases.full) = kAllVoxels & ~(beyond | once);
  cases.several = once & ~beyond;
  std::uint32_t second[kMostFaces] = {};  // where another face that crosses the voxel bounds it
  for (int j = 1; j < c.count; ++j)
    for (int i = 0; i < j; ++i) {
      const Angle& angle = c.between(i, j);
      second[i] |= crossed[j] & ~(c.concave ? angle.less : angle.more);
      second[j] |= crossed[i] & ~(c.concave ? angle.more : angle.less);
    }
  for (int i = 0; i < c.count; ++i) {
    cases.only[i] = crossed[i] & ~(beyond | second[i]);
    cases.several &= ~cases.only[i];
  }
  return cases;
}

float roughMass(const Combination& c, float place) {
  return massWith(c, c.face[c.count - 1]->face().n, place);
}

float roughResidual(const BlockTarget& target, const Combination& c) {
  return std::sqrt(roughSquare(target, c));
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
  float found[CC_WINDOW_VOXELS], square = 0;
  constexpr int kMiddle = CC_WINDOW_VOXELS / 2;
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
    const bool full = cases.full >> v & 1, empty = cases.empty >> v & 1;
    found[v] = full ? 1.0f : 0.0f;
    square += full ? target.ifFull[v] : empty ? target.ifEmpty[v] : 0.0f;
  }
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
