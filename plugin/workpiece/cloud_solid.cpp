// Depth fields of clouds used as solids: see field/cloud_depth.h.
#include <cloudcontact/workpiece/cloud_solid.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/grid_index.h"
#include "field/cloud_depth.h"

namespace cloudcontact {

namespace {

// Each voxel of a cloud's grid, x fastest.
template <typename What>
void forEachVoxel(const Eigen::Vector3i& size, What&& what) {
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) what(x, y, z);
}

Eigen::AlignedBox3d matterOf(const Cloud& cloud) {
  Eigen::AlignedBox3d box;
  const double h = cloud.voxelSize();
  forEachVoxel(cloud.size(), [&](int x, int y, int z) {
    if (cloud.coverage(x, y, z) == 0) return;
    const Vec3 low = cloud.origin() + h * Vec3(x, y, z);
    box.extend(low).extend(low + Vec3::Constant(h));
  });
  return box;
}

}  // namespace

PlacedSolid cloudSolid(const Cloud& cloud, const Pose& place) {
  if (cloud.empty()) throw std::invalid_argument("cloudSolid: the cloud is empty");
  return {
      CloudSolid{std::make_shared<const Cloud>(cloud),
                 std::make_shared<const std::vector<float>>(cloudDepth(cloud)), matterOf(cloud)},
      place};
}

Cloud surfaceLayer(const Cloud& tool, double thickness, const PlacedSolid* where) {
  if (!(thickness > 0) || !std::isfinite(thickness))
    throw std::invalid_argument("surfaceLayer: the thickness must be positive and finite");
  if (tool.empty()) throw std::invalid_argument("surfaceLayer: the tool is empty");
  const std::vector<float> depth = cloudDepth(tool);
  auto layer = std::make_shared<Cloud::Voxels>();
  layer->bricks = tool.bricks();
  layer->table.assign(tool.voxels().table.size(), kEmptyBrick);
  std::size_t voxel = 0;
  const double h = tool.voxelSize();
  forEachVoxel(tool.size(), [&](int x, int y, int z) {
    const double below = static_cast<double>(depth[voxel++]);
    // How much of the voxel lies above the layer's floor, and how much of it in `where`.
    double share = std::clamp((thickness - below) / h + 0.5, 0.0, 1.0);
    if (where) share *= std::clamp(depthOf(*where, tool.center(x, y, z)) / h + 0.5, 0.0, 1.0);
    const long kept = std::lround(share * tool.coverage(x, y, z));
    if (kept <= 0) return;
    const std::size_t entry = brickIndex(x, y, z, layer->bricks);
    if (layer->table[entry] < 0) {
      layer->table[entry] = static_cast<std::int32_t>(layer->coverage.size());
      layer->coverage.emplace_back();
      layer->coverage.back().fill(0);
    }
    layer->coverage[static_cast<std::size_t>(layer->table[entry])]
                   [static_cast<std::size_t>(cellIndex(x, y, z))] = static_cast<std::uint8_t>(kept);
  });
  if (layer->coverage.empty())
    throw std::invalid_argument("surfaceLayer: no matter of the tool lies there");
  return Cloud(h, tool.origin(), std::move(layer));
}

}  // namespace cloudcontact
