// The voxels of a block side by side, each as if it were one sub-sample.
#include "field/edge_estimate.h"

#include "base/simd.h"
#include "field/share_lanes.h"

#include <cmath>

namespace cloudcontact {

namespace {

// A combination's angles, in registers.
template <int kFaces>
struct Angles {
  Angle at[kFaces > 1 ? kFaces*(kFaces - 1) / 2 : 1];

  CC_INLINE explicit Angles(const Combination& c) {
    for (int i = 0; i < kFaces * (kFaces - 1) / 2; ++i) at[i] = c.angle[i];
  }
};

// The coverage of all voxels at once, by the parts of a voxel that each face alone leaves, joined
// as if they were those of a sub-sample.
template <int kFaces>
CC_INLINE void roughly(const Combination& c, float* coverage) {
  const float* alone[kFaces];
  for (int i = 0; i < kFaces; ++i) alone[i] = c.face[i]->cuts().volume;
  const Angles<kFaces> angles(c);
  const float start = c.concave ? 1.0f : 0.0f, side = c.concave ? -1.0f : 1.0f;
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    float r[kFaces], left, slope[kFaces];
#pragma GCC unroll 8
    for (int i = 0; i < kFaces; ++i) r[i] = start + side * alone[i][k];
    join<kFaces>(r, angles.at, left, slope);
    coverage[k] = start + side * left;
  }
}

// windowWeight(), 0 in the lanes beyond.
struct LaneWeights {
  alignas(64) float at[CC_WINDOW_LANES] = {};

  constexpr LaneWeights() {
    for (std::size_t v = 0; v < CC_WINDOW_VOXELS; ++v) at[v] = kWindowWeights[v];
  }
};
constexpr LaneWeights kLaneWeights;

template <int kFaces>
CC_INLINE float massWithPlane(const Combination& c, const Eigen::Vector3f& n, float s) {
  const float* alone[kFaces];
  for (int i = 0; i + 1 < kFaces; ++i) alone[i] = c.face[i]->cuts().volume;
  const Angles<kFaces> angles(c);
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
    join<kFaces>(r, angles.at, left, slope);
    found[k] = k < CC_WINDOW_VOXELS ? start + side * left : 0.0f;
  }
  return windowTotal(found);
}

CC_LANES [[gnu::flatten]] float massWith(const Combination& c, const Eigen::Vector3f& n, float s) {
  return c.count == 2 ? massWithPlane<2>(c, n, s) : massWithPlane<3>(c, n, s);
}

CC_LANES float roughSquare(const BlockTarget& target, const Combination& c) {
  alignas(64) float found[CC_WINDOW_LANES], square[CC_WINDOW_LANES], counted[CC_WINDOW_LANES];
  withFaces<1>(c.count, [&](auto faces) CC_INLINE_LAMBDA { roughly<faces>(c, found); });
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

}  // namespace

float roughMass(const Combination& c, float place) {
  return massWith(c, c.face[c.count - 1]->face().n, place);
}

float roughResidual(const BlockTarget& target, const Combination& c) {
  return std::sqrt(roughSquare(target, c));
}

}  // namespace cloudcontact
