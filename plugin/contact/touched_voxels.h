// TouchedVoxels: the collision voxels of one body inside the other, near a contact that the search
// has found. Paper, Step 2, and the collision detection area D of Step 5.
#pragma once

#include <cloudcontact/voxels/voxel_cut.h>

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

  // Calls visit(TouchedVoxel) for each collision voxel in `box` (pair's frame) [m], in a fixed
  // order.
  template <typename Visit>
  void each(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    const Range range = rangeOf(box);
    const Eigen::Vector3i first = range.low / kBrickEdge, last = range.high / kBrickEdge;
    TouchedVoxel found;
    for (int z = first.z(); z <= last.z(); ++z)
      for (int y = first.y(); y <= last.y(); ++y)
        for (int x = first.x(); x <= last.x(); ++x) {
          const Eigen::Vector3i brick(x, y, z);
          const std::uint8_t* const coverage = coverageOf(brick);
          if (!coverage || farFrom(brick)) continue;
          const Eigen::Vector3i corner = kBrickEdge * brick;
          const Eigen::Vector3i low = range.low.cwiseMax(corner),
                                high = range.high.cwiseMin(
                                    Eigen::Vector3i(corner.array() + (kBrickEdge - 1)));
          for (int k = low.z(); k <= high.z(); ++k)
            for (int j = low.y(); j <= high.y(); ++j)
              for (int i = low.x(); i <= high.x(); ++i) {
                const std::uint8_t full = coverage[cellIndex(i, j, k)];
                if (full == 0 || !lookUp({i, j, k}, full, found)) continue;
                visit(found);
              }
        }
  }

 private:
  struct Range {
    Eigen::Vector3i low, high;  // voxels, both included
  };
  Range rangeOf(const Eigen::AlignedBox3d& box) const;
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
