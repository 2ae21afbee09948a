// Clouds of a few voxels, with results that can be computed by hand.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <functional>
#include <string>
#include <vector>

namespace cloudcontact::test {

// `coverage` of each voxel [1/255]; `tissue` for several `materials`.
inline Cloud smallCloud(double voxel, const Eigen::Vector3i& bricks,
                        const std::function<int(int, int, int)>& coverage,
                        const std::vector<std::string>& materials = {},
                        const std::function<int(int, int, int)>& tissue = {}) {
  auto v = std::make_shared<Cloud::Voxels>();
  v->bricks = bricks;
  v->materials = materials;
  for (int bz = 0; bz < bricks.z(); ++bz)
    for (int by = 0; by < bricks.y(); ++by)
      for (int bx = 0; bx < bricks.x(); ++bx) {
        BrickCoverage brick;
        BrickMaterial of;
        bool solid = true, empty = true;
        for (int k = 0; k < kBrickVoxels; ++k) {
          const int x = 8 * bx + (k & 7), y = 8 * by + (k >> 3 & 7), z = 8 * bz + (k >> 6);
          const auto at = static_cast<std::size_t>(k);
          brick[at] = static_cast<std::uint8_t>(coverage(x, y, z));
          of[at] = static_cast<std::uint8_t>(tissue && brick[at] > 0 ? tissue(x, y, z) : 0);
          solid = solid && brick[at] == 255, empty = empty && brick[at] == 0;
        }
        v->table.push_back(solid   ? kSolidBrick
                           : empty ? kEmptyBrick
                                   : static_cast<std::int32_t>(v->coverage.size()));
        if (!solid && !empty) v->coverage.push_back(brick);
        if (materials.empty()) continue;
        v->materialTable.push_back(static_cast<std::int32_t>(v->material.size()));
        v->material.push_back(of);
      }
  return Cloud(voxel, Vec3::Zero(), std::move(v));
}

// A ball; 6x6x6 samples give the coverage of each voxel.
inline Cloud ballCloud(double voxel, int bricks, const Vec3& center, double radius,
                       const std::vector<std::string>& materials = {},
                       const std::function<int(int, int, int)>& tissue = {}) {
  return smallCloud(
      voxel, Eigen::Vector3i::Constant(bricks),
      [=](int x, int y, int z) {
        const double middle = (Vec3(x + .5, y + .5, z + .5) - center).norm();
        if (middle < radius - 1) return 255;
        if (middle > radius + 1) return 0;
        int in = 0;
        for (int k = 0; k < 216; ++k)
          in +=
              (Vec3(x + (k % 6 + .5) / 6, y + (k / 6 % 6 + .5) / 6, z + (k / 36 + .5) / 6) - center)
                  .norm() < radius;
        return (in * 255 + 108) / 216;
      },
      materials, tissue);
}

}  // namespace cloudcontact::test
