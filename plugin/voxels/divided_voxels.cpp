// Adds each voxel, or the parts of it, as boxes to the new grid.
#include "voxels/divided_voxels.h"

#include <algorithm>
#include <cmath>

#include "voxels/cloud_builder.h"
#include "voxels/local_surface.h"

namespace cloudcontact {

namespace {

constexpr int kMostParts = 8;  // of a voxel's edge

}  // namespace

Eigen::AlignedBox3d boundsOfVoxels(const Cloud& cloud) {
  Eigen::AlignedBox3d box;
  const double half = 0.5 * cloud.voxelSize();
  forEachVoxel(cloud, [&](const Eigen::Vector3i& v, int) {
    const Vec3 center = cloud.center(v[0], v[1], v[2]);
    box.extend(Vec3(center.array() - half));
    box.extend(Vec3(center.array() + half));
  });
  return box;
}

Cloud inVoxels(const char* what, const Cloud& cloud, const Vec3& spacing, const Vec3& origin,
               double voxelSize) {
  const int n =
      std::clamp(static_cast<int>(std::ceil(4 * spacing.maxCoeff() / voxelSize)), 2, kMostParts);
  const Eigen::AlignedBox3d own = boundsOfVoxels(cloud);
  const auto placed = [&](const Vec3& corner) {
    return Vec3(origin + (corner - cloud.origin()).cwiseProduct(spacing) / cloud.voxelSize());
  };
  Eigen::AlignedBox3d box;
  if (!own.isEmpty()) box = Eigen::AlignedBox3d(placed(own.min()), placed(own.max()));
  CloudBuilder builder(cloudGrid(what, box, voxelSize, origin), cloud.materials());
  const Vec3 part = spacing / n;
  std::vector<float> shares;
  forEachVoxel(cloud, [&](const Eigen::Vector3i& voxel, int coverage) {
    const Vec3 low = origin + voxel.cast<double>().cwiseProduct(spacing);
    const std::uint8_t material = cloud.material(voxel[0], voxel[1], voxel[2]);
    if (coverage == 255) return builder.addBox(low, low + spacing, 1, material);
    divideVoxel(cloud, voxel, n, shares);
    for (int k = 0; k < n * n * n; ++k) {
      const Vec3 at = low + Vec3(k % n, k / n % n, k / (n * n)).cwiseProduct(part);
      builder.addBox(at, at + part, shares[k], material);
    }
  });
  return builder.build();
}

}  // namespace cloudcontact
