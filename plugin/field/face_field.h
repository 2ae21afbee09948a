// FaceField: a face, and how it cuts the voxels of a 3x3x3 block.
#pragma once

#include "kernels/contact/surface_fit.h"

#include <Eigen/Core>
#include <array>
#include <cstdint>

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
constexpr std::uint32_t kAllVoxels = (1u << CC_WINDOW_VOXELS) - 1;  // of a block, one bit each
constexpr int kBlockPoints = CC_WINDOW_VOXELS * kPerVoxel;

// A face, scaled to sub-sample widths along its normal.
struct FaceTerms {
  Eigen::Vector3f n = Eigen::Vector3f::Zero();
  float s = 0;
  bool curved = false;
  Eigen::Matrix3f half = Eigen::Matrix3f::Zero();

  FaceTerms() = default;
  explicit FaceTerms(const Face& f);
  float flat(float x, float y, float z) const { return n.x() * x + n.y() * y + n.z() * z - s; }
  float bent(float x, float y, float z) const {
    return x * (half(0, 0) * x + 2 * half(0, 1) * y) + y * (half(1, 1) * y + 2 * half(1, 2) * z) +
           z * (half(2, 2) * z + 2 * half(0, 2) * x);
  }
};

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

 private:
  void find(int voxel) const;
  void cut() const;

  Face face_;
  FaceTerms terms_;
  mutable float bend_ = -1;  // negative: not known yet
  float perShift_ = 0;
  std::uint32_t outer_ = 0, inner_ = 0;
  alignas(64) std::array<float, CC_WINDOW_LANES> middle_{};  // distances at the voxels' centers
  mutable bool isCut_ = false;
  mutable FaceCuts cuts_;
  mutable std::uint32_t known_ = 0;  // one bit per voxel
  alignas(64) mutable std::array<float, kBlockPoints> outside_{};
};

}  // namespace cloudcontact
