// The coverage of a 3x3x3 block of voxels that up to kMostFaces faces bound, and the faces that
// reproduce a given coverage. The edge search (edge_search.h) rates its hypotheses with it.
#pragma once

#include "kernels/contact/field_voxel.h"
#include "kernels/contact/surface_fit.h"

#include <Eigen/Core>
#include <array>
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
  // Distance at the voxel's center. Where it is large the face does not cross the voxel.
  float middle(int voxel) const { return middle_[static_cast<std::size_t>(voxel)]; }
  const FaceCuts& cuts() const {
    if (!isCut_) cut();
    return cuts_;
  }
  // How far a sub-sample's share deviates from a linear ramp: 0 along an axis, 2.5 along a
  // diagonal.
  float bend() const { return bend_; }

 private:
  void find(int voxel) const;
  void cut() const;

  Face face_;
  float bend_ = 0;
  std::array<float, CC_WINDOW_LANES> middle_{};
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
};

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

// The block's coverage under a combination; 27 values.
void coverageOf(const Combination& c, float* coverage);
// The center voxel alone.
float middleCoverageOf(const Combination& c);

// Root mean square of the difference, over the voxels near the surface.
float blockResidual(const float* target, const float* found);

// Faces that explain a block.
struct Hypothesis {
  Face faces[kMostFaces];
  int count = 0;
  bool concave = false;
  float residual = 1.0f;
};

// Moves all faces of a hypothesis at once to fit the target coverage (Gauss-Newton). A prior holds
// each face near its start, weighted by how well its neighbors know it. `fields` is workspace.
void refine(const float* target, Hypothesis& h, FaceField* fields);

}  // namespace cloudcontact
