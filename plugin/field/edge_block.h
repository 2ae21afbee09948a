// The coverage of a 3x3x3 block of voxels that up to kMostFaces faces bound, and the faces that
// reproduce a given coverage. The edge search (edge_search.h) rates its hypotheses with it.
#pragma once

#include "field/face_field.h"
#include "kernels/contact/field_voxel.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace cloudcontact {

constexpr int kMostFaces = CC_MAX_PLANES;

// How two faces share a sub-sample that both cut. `alike` falls from 1 for equal normals to 0 at a
// right angle, `opposed` from 1 for opposite normals to 0 at a right angle.
struct Angle {
  float alike = 0, opposed = 0;
  // The voxels in all of which every point lies farther outside the first face than outside the
  // second, or less far. One of the two alone bounds the matter there. One bit each.
  std::uint32_t more = 0, less = 0;

  Angle swapped() const { return {alike, opposed, less, more}; }
};
Angle angleBetween(const FaceField& a, const FaceField& b);

// Faces that bound the material together: the intersection of their half-spaces, or the union where
// `concave`.
struct Combination {
  const FaceField* face[kMostFaces] = {};
  int count = 0;
  bool concave = false;
  Angle angle[kMostFaces * (kMostFaces - 1) / 2];  // of 0 and 1, 0 and 2, 1 and 2, 0 and 3, ...

  const Angle& between(int i, int j) const { return angle[j * (j - 1) / 2 + i]; }  // i < j
};
Combination combine(std::initializer_list<const FaceField*> faces, bool concave);
void measureAngles(Combination& c);  // needed after its faces have moved

// Derivative of a voxel's coverage as one face shifts outward, and its first moment, which gives
// the derivative as the face turns.
struct Slope {
  float shift = 0;
  Eigen::Vector3f moment = Eigen::Vector3f::Zero();
};

// The voxels of a block by the faces that bound the matter in them, one bit each.
struct BlockCases {
  std::uint32_t full = 0, empty = 0, several = 0;
  std::uint32_t only[kMostFaces] = {};  // this face alone
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

// The coverage of a voxel that several faces bound, and its slopes for each of them.
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
// About the sum over the block with the last of two or three faces, a plane, at another place: by
// each face's part of a voxel, not by sub-samples.
float roughMass(const Combination& c, float place);
// About the residual of a combination, by the same means. Costs a tenth.
float roughResidual(const BlockTarget& target, const Combination& c);
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
