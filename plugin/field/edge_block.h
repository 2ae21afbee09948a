// The coverage of a 3x3x3 block of voxels that up to kMostFaces faces bound, and the faces that
// reproduce a given coverage. The edge search (edge_search.h) rates its hypotheses with it.
#pragma once

#include "kernels/contact/field_voxel.h"
#include "kernels/contact/surface_fit.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace cloudcontact {

// A face continued to the block: n.x + x.curvature.x / 2 < s around the block's center.
struct Face {
  Eigen::Vector3f n = Eigen::Vector3f::Zero();
  float s = 0;
  float weight = 0;
  Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero();
  bool hidden = false;  // no neighbor's fit shows it; its place is a guess
};

constexpr int kSub = 4;  // sub-samples along a voxel's edge
constexpr int kPerVoxel = kSub * kSub * kSub;
constexpr int kBlockPoints = CC_WINDOW_VOXELS * kPerVoxel;

// How one face alone cuts each voxel of the block, in closed form, flat within the voxel: the
// volume it leaves, its derivative as the face shifts outward, and that times the cut's position.
struct FaceCuts {
  alignas(64) float volume[CC_WINDOW_LANES], shift[CC_WINDOW_LANES], moment[3][CC_WINDOW_LANES];
};

// A face and the distances of the block's sub-samples outside it, in sub-sample widths along the
// normal. Stored voxel by voxel, so that a voxel's coverage is a sum over a run. Distances and cuts
// are computed on first use. For one thread at a time.
class FaceField {
 public:
  void set(const Face& face);
  const Face& face() const { return face_; }
  const float* outside(int voxel) const {
    if (!(known_ >> voxel & 1)) find(voxel);
    return outside_.data() + voxel * kPerVoxel;
  }
  // The voxels that lie wholly outside the face, or inside; it may cross the others. One bit each.
  std::uint32_t outer() const { return outer_; }
  std::uint32_t inner() const { return inner_; }
  const FaceCuts& cuts() const {
    if (!isCut_) cut();
    return cuts_;
  }
  // How far a sub-sample's share is from a linear ramp: 0 along an axis, 2.5 along a diagonal.
  // Known after outside().
  float bend() const { return bend_; }
  // Widths of a sub-sample by which the distances fall as the face shifts outward by a voxel.
  float perShift() const { return perShift_; }
  // Distances outside at the voxels' centers, in sub-sample widths along the normal.
  const float* middle() const { return middle_.data(); }

 private:
  void find(int voxel) const;
  void cut() const;

  Face face_;
  mutable float bend_ = -1;  // negative: not known yet
  float perShift_ = 0;
  std::uint32_t outer_ = 0, inner_ = 0;
  alignas(64) std::array<float, CC_WINDOW_LANES> middle_{};  // distances at the voxels' centers
  mutable bool isCut_ = false;
  mutable FaceCuts cuts_;
  mutable std::uint32_t known_ = 0;  // one bit per voxel
  alignas(64) mutable std::array<float, kBlockPoints> outside_{};
};

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
BlockCases casesOf(const Combination& c);

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
float coverageOnly(const Combination& c, int voxel);
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
// Full and empty voxels that are about right say nothing of the surface.
inline bool irrelevant(float found, float difference) {
  return (found <= 0.0f || found >= 1.0f) && std::abs(difference) < 2e-3f;
}
// Root mean square of the difference, over the voxels near the surface.
float blockResidual(const float* target, const float* found);
constexpr float kTooMuch = 1e9f;
// The same for a combination; kTooMuch, with less work, where it is not below `bound`, or where the
// middle voxel's coverage is off by more than `miss`.
float roughResidual(const BlockTarget& target, const Combination& c);
float residualBelow(const BlockTarget& target, const Combination& c, float bound, float miss);

}  // namespace cloudcontact
