// The part of a voxel's piece of surface inside a box, and the sample that stands for it.
#pragma once

#include <cloudcontact/field/surface_sample.h>

#include <Eigen/Core>

#include "field/field_draft.h"

namespace cloudcontact {

// [voxels] The planes at which a piece is cut lie as far from its own as this, at most.
constexpr float kMostJitter = 0.09375f;

// The part of a piece inside a box.
struct CutPart {
  float area = 0;
  Eigen::Vector3f centroid = Eigen::Vector3f::Zero();
  // Edge of a square with the same spread (two voxels may share it), at most twice the distance to
  // the nearest edge.
  float width = 0;
  bool bounded = false;  // another piece bounds it inside the box
};

// The part of piece `own` inside a box with edge length `edge`, bounded by the voxel's other
// pieces. `low`: the box's corner, from the voxel's center.
CutPart cutPiece(const VoxelState& v, int own, const Eigen::Vector3f& low, float edge);

// The sample of a part, on the curved surface: its mean position over the width, and its normal.
SurfaceSample sampleOf(const CcSurface& f, const CutPart& part, const Eigen::Vector3f& center);

}  // namespace cloudcontact
