// The faces that are seen near a voxel, continued to it: what the edge search combines.
#pragma once

#include "field/face_field.h"
#include "field/field_draft.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cloudcontact {

constexpr int kReach = 3;            // faces are collected this far from the block's center
constexpr float kGoodEdge = 0.005f;  // residual of an edge whose faces its neighbors may use

inline float sharpest(const CcSurface& f) {
  return std::max({std::abs(f.k11), std::abs(f.k12), std::abs(f.k22)});
}

// True if a voxel's pieces are continued to others. All have the same residual.
bool shows(const VoxelState& v);

// Calls visit(brick, cell, offset) for the surface voxels within reach of a voxel, in the order of
// the grid, until it returns true. Returns whether it did.
template <typename Visit>
bool anyNear(const FieldDraft& draft, const DraftVoxel& at, Visit&& visit) {
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach;) {
        // As far as a brick reaches.
        const int x = at.x + dx, y = at.y + dy, z = at.z + dz,
                  end = std::min(kReach + 1, dx + kBrickEdge - (x & (kBrickEdge - 1)));
        const SurfaceBrick* const brick = draft.brickOf(x, y, z);
        const int cell = cellIndex(x, y, z) - dx;
        for (; dx < end; ++dx)
          if (brick && brick->place[static_cast<std::size_t>(cell + dx)] >= 0 &&
              visit(*brick, cell + dx, Eigen::Vector3f(float(dx), float(dy), float(dz))))
            return true;
      }
  return false;
}

// The distinct faces near a voxel, as known before a pass: means over the neighbors that show them.
// Near ones with small residuals come first.
std::vector<Face> facesNear(const FieldDraft& draft, const DraftVoxel& at, int pass,
                            std::size_t most);

}  // namespace cloudcontact
