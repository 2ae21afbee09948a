// The coverage of a 3x3x3 block of voxels that up to six faces bound together, and the faces that
// give a wanted coverage. What field_edges.cpp measures its hypotheses by.
#pragma once

#include "field/field_builder.h"

#include <array>
#include <cstdint>
#include <initializer_list>

namespace cloudcontact {

// A face continued to the block: n.x + x.curvature.x / 2 < s about the block's middle.
struct Face {
  Eigen::Vector3f n = Eigen::Vector3f::Zero();
  float s = 0;
  float weight = 0;
  Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero();
  bool sought = false;  // no neighbour shows it: its place is a guess
};

constexpr int kSub = 4;  // sub-samples along a voxel's edge
constexpr int kPerVoxel = kSub * kSub * kSub;
constexpr int kBlockPoints = CC_WINDOW_VOXELS * kPerVoxel;

// How a face alone cuts each voxel of the block, in closed form, flat within the voxel: how much it
// leaves of it, how that grows as the face shifts outwards, and that times the place of the cut.
struct FaceCuts {
  alignas(64) float volume[CC_WINDOW_LANES], shift[CC_WINDOW_LANES], moment[3][CC_WINDOW_LANES];
};

// A face, and how far each sub-sample of the block lies outside it, in sub-sample widths along the
// normal. Stored voxel by voxel, so that a voxel's coverage is a sum over a run.
class FaceField {
 public:
  void set(const Face& face);
  const Face& face() const { return face_; }
  // Found when a voxel is first asked for: most are crossed by no other face, and then a closed
  // form serves. For one thread at a time.
  const float* outside(int voxel) const {
    if (!(known_ >> voxel & 1)) find(voxel);
    return outside_.data() + voxel * kPerVoxel;
  }
  // At the voxel's middle: where this is far from zero the face does not cross the voxel.
  float middle(int voxel) const { return middle_[static_cast<std::size_t>(voxel)]; }
  // All voxels' at once, when one is first asked for. For one thread at a time.
  const FaceCuts& cuts() const {
    if (!isCut_) cut();
    return cuts_;
  }
  // How far from a straight ramp a sub-sample's share is: 0 along an axis, 2.5 along a diagonal.
  float bend() const { return bend_; }

 private:
  void find(int voxel) const;
  void cut() const;

  Face face_;
  float bend_ = 0;
  std::array<float, CC_WINDOW_LANES> middle_{};
  mutable bool isCut_ = false;
  mutable FaceCuts cuts_;
  mutable std::uint32_t known_ = 0;  // a bit a voxel
  alignas(64) mutable std::array<float, kBlockPoints> outside_{};
};

constexpr int kMostFaces = CC_MAX_PLANES;

// How two faces share a sub-sample that both cut: 1 where they look the same way and where they are
// back to back, 0 from a right angle on.
struct Angle {
  float alike = 0, opposed = 0;
};

// Faces that bound the material together: it is their intersection, or union where `concave`.
struct Combination {
  const FaceField* face[kMostFaces] = {};
  int count = 0;
  bool concave = false;
  Angle angle[kMostFaces * (kMostFaces - 1) / 2];  // of 0 and 1, 0 and 2, 1 and 2, 0 and 3, ...

  const Angle& between(int i, int j) const { return angle[j * (j - 1) / 2 + i]; }  // i < j
};
Combination combine(std::initializer_list<const FaceField*> faces, bool concave);
void measureAngles(Combination& c);  // anew, after its faces have moved

// The block's coverage under a combination; 27 values.
void coverageOf(const Combination& c, float* coverage);
// Of the middle voxel alone.
float middleCoverageOf(const Combination& c);

// Root mean square of what is not explained, over the voxels that the surface is near.
float blockResidual(const float* wanted, const float* found);

// What explains a block.
struct Hypothesis {
  Face faces[kMostFaces];
  int count = 0;
  bool concave = false;
  float residual = 1.0f;
};

// Moves all of a hypothesis's faces at once to where the wanted coverage has them (Gauss-Newton),
// each held near where it was, as firmly as its neighbours know it. `fields` is memory to work in.
void refine(const float* wanted, Hypothesis& h, FaceField* fields);

}  // namespace cloudcontact
