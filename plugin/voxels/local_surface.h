// The surface inside single voxels of a cloud, for dividing voxels and for points on the surface.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <vector>

#include "base/grid_index.h"

namespace cloudcontact {

// A point on a cloud's surface, in the body's frame.
struct SurfacePlace {
  Vec3 position;  // [m]
  Vec3 normal;    // outward unit
  std::uint8_t material;
};

// The share of material in each of the n^3 equal cubes of a voxel, x fastest. The shares follow the
// quadric fitted to the voxel and its neighbors (kernels/contact/surface_fit.h), shifted until
// their mean is the voxel's coverage to 1e-5. Without a surface direction all shares are equal.
void divideVoxel(const Cloud& cloud, const Eigen::Vector3i& voxel, int n,
                 std::vector<float>& shares);

// Points on the surface, about one per area of (voxelSize / n)^2, in the order of the bricks.
std::vector<SurfacePlace> surfacePlaces(const Cloud& cloud, int n, int threads);

// Calls visit(voxel, coverage) for every voxel with material, brick by brick in the table's order.
template <typename Visit>
void forEachVoxel(const Cloud& cloud, Visit&& visit) {
  if (cloud.empty()) return;
  const Cloud::Voxels& voxels = cloud.voxels();
  std::size_t entry = 0;
  for (int z = 0; z < voxels.bricks[2]; ++z)
    for (int y = 0; y < voxels.bricks[1]; ++y)
      for (int x = 0; x < voxels.bricks[0]; ++x, ++entry) {
        const std::int32_t b = voxels.table[entry];
        if (b == kEmptyBrick) continue;
        for (int v = 0; v < kBrickVoxels; ++v) {
          const int c = b < 0 ? 255 : voxels.coverage[b][v];
          if (c > 0)
            visit(Eigen::Vector3i(kBrickEdge * Eigen::Vector3i(x, y, z) + cellOffset(v)), c);
        }
      }
}

}  // namespace cloudcontact
