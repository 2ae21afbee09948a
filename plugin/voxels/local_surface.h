// Where the surface runs inside one voxel of a cloud: what is needed to divide a voxel finer than
// the cloud itself, or to put points on its surface.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <vector>

#include "base/grid_index.h"

namespace cloudcontact {

// A place on a cloud's surface, in the body's frame.
struct SurfacePlace {
  Vec3 position;  // [m]
  Vec3 normal;    // outward unit
  std::uint8_t material;
};

// The share of material in each of the n^3 equal cubes of a voxel, x fastest. They follow the
// quadric that explains the voxel and its neighbours (kernels/surface_fit.h), moved until their
// mean is the voxel's own coverage, to 1e-5. Where nothing tells a direction all are alike.
void divideVoxel(const Cloud& cloud, const Eigen::Vector3i& voxel, int n,
                 std::vector<float>& shares);

// Places on the surface, about one for each (voxelSize / n)^2 of it, in the order of the bricks.
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
          const int c =
              b < 0 ? 255
                    : voxels.coverage[static_cast<std::size_t>(b)][static_cast<std::size_t>(v)];
          if (c > 0)
            visit(Eigen::Vector3i(kBrickEdge * Eigen::Vector3i(x, y, z) + cellOffset(v)), c);
        }
      }
}

}  // namespace cloudcontact
