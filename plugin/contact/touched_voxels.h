// TouchedVoxels: the collision voxels of one body inside the other, near a contact that the search
// has found. Paper, Step 2, and the collision detection area D of Step 5.
#pragma once

#include <cloudcontact/voxels/voxel_cut.h>

#include <vector>

#include "base/grid_index.h"
#include "contact/hit_columns.h"
#include "contact/pair_frame.h"
#include "field/field_data.h"

namespace cloudcontact {

// A voxel of one body, inside the other's D by a share.
struct TouchedVoxel {
  VoxelIndex voxel;
  double share = 0;           // inside D, times its coverage, 0..1
  Vec3 at = Vec3::Zero();     // its center, in the pair's frame [m]
  Vec3 other = Vec3::Zero();  // the other's outward normal there; zero below its band
};

class TouchedVoxels {
 public:
  // Of `own`, a field. `area`: the other's D in its own frame, or null for all of it. `shift` [m]:
  // by which the search has moved the bodies together.
  TouchedVoxels(const ContactBody& own, const ContactBody& other, const PairFrame& frame,
                const PlacedSolid* area, double shift);

  // Calls visit(TouchedVoxel) for each collision voxel within `reach` [m] of a hit, and of the
  // bricks between them that lie in the other body, in a fixed order. Returns how many voxels these
  // bricks have.
  template <typename Visit>
  std::size_t each(const HitColumns& hits, double reach, std::vector<std::uint8_t>& memory,
                   const Visit& visit) const {
    if (hits.empty()) return 0;
    std::size_t visited = 0;
    const Range range = bricksNear(hits, reach, memory);
    const Eigen::Vector3i n = range.high - range.low + Eigen::Vector3i::Ones();
    TouchedVoxel found;
    for (std::size_t k = 0; k < memory.size(); ++k) {
      const Eigen::Vector3i brick = range.low + gridCell(k, n);
      const std::uint8_t* const coverage = coverageOf(brick);
      if (!coverage || (memory[k] == 0 ? !within(brick) : farFrom(brick))) continue;
      visited += kBrickVoxels;
      const VoxelIndex corner = kBrickEdge * brick;
      for (int cell = 0; cell < kBrickVoxels; ++cell)
        if (coverage[cell] > 0 && lookUp(corner + cellOffset(cell), coverage[cell], found))
          visit(found);
    }
    return visited;
  }

 private:
  struct Range {
    Eigen::Vector3i low, high;  // bricks, both included
  };
  // The bricks around the hits; `near` is 1 for those within `reach` of one.
  Range bricksNear(const HitColumns& hits, double reach, std::vector<std::uint8_t>& near) const;
  bool within(const Eigen::Vector3i& brick) const;  // its middle lies in the other body
  // Null for a brick without matter.
  const std::uint8_t* coverageOf(const Eigen::Vector3i& brick) const;
  bool farFrom(const Eigen::Vector3i& brick) const;
  bool lookUp(const VoxelIndex& v, std::uint8_t coverage, TouchedVoxel& found) const;
  // Depth [m] and normal (pair's frame) of a point of the own grid [voxels] in the other body.
  double depthInField(const float* at, Vec3& normal) const;
  double depthInSolid(const float* at, Vec3& normal) const;

  const FieldData& own_;
  const FieldData* field_ = nullptr;  // the other's, unless a solid stands for it
  PlacedSolid solid_;
  CcWay way_;
  Pose toFrame_;          // from the own grid [m]
  Pose toOther_;          // from the own grid to the other body [m]
  Eigen::Matrix3d turn_;  // from the other body to the frame
  double voxel_, shift_;  // [m]
};

}  // namespace cloudcontact
