// The coverage of a 3x3x3 block of voxels that up to kMostEdgeFaces faces bound, and the faces that
// reproduce a given coverage. The edge search (edge_search.h) rates its hypotheses with it.
#pragma once

#include "field/combination.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

namespace cloudcontact {

// Derivative of a voxel's coverage as one face shifts outward, and its first moment, which gives
// the derivative as the face turns.
struct Slope {
  float shift = 0;
  Eigen::Vector3f moment = Eigen::Vector3f::Zero();
};

// What a voxel of the block counts: (1 - r^2/R^2)^2.
inline constexpr auto kWindowWeights = [] {
  std::array<float, CC_WINDOW_VOXELS> weights{};
  for (std::size_t v = 0; v < CC_WINDOW_VOXELS; ++v) {
    const float q = 1.0f - ((v % 3 != 1) + (v / 3 % 3 != 1) + (v / 9 != 1)) / CC_WINDOW_RADIUS2;
    weights[v] = q * q;
  }
  return weights;
}();
constexpr float windowWeight(int voxel) {
  return kWindowWeights[static_cast<std::size_t>(voxel)];
}

// The coverage of a voxel that several faces cross, and its slopes for each of them.
float coverageAndSlopes(const Combination& c, int voxel, Slope* slopes);

// The coverage that a combination is to explain.
struct BlockTarget {
  alignas(64) float coverage[CC_WINDOW_LANES] = {};
  // What a voxel adds to the square of the residual if the faces leave it empty, or full.
  alignas(64) float ifEmpty[CC_WINDOW_LANES] = {}, ifFull[CC_WINDOW_LANES] = {};
  float mass = 0;

  explicit BlockTarget(const float* block);
};
// The block's coverage under a combination; 27 values.
void coverageOf(const Combination& c, float* coverage);
// The same but for `several` voxels.
BlockCases coverSimple(const Combination& c, float* coverage);
// Full and empty voxels that are about right say nothing of the surface.
inline bool irrelevant(float found, float difference) {
  return (found <= 0.0f || found >= 1.0f) && std::abs(difference) < 2e-3f;
}
// The square of the difference, summed over the voxels near the surface by their weights.
struct BlockError {
  float square = 0, weight = 0;

  float residual() const { return weight > 0 ? std::sqrt(square / weight) : 1.0f; }
};
BlockError blockError(const float* target, const float* found);
constexpr float kTooMuch = 1e9f;
// The residual of a combination; kTooMuch, with less work, where it is not below `bound`, or where
// the middle voxel's coverage is off by more than `miss`.
float residualBelow(const BlockTarget& target, const Combination& c, float bound, float miss);

}  // namespace cloudcontact
