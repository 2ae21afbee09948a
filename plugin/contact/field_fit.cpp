// The first step of the field: which voxels the surface crosses, and its quadric in each.
#include "../geometry/parallel.h"
#include "field_builder.h"

namespace cloudcontact {

void gatherBlock(const Cloud& cloud, int x, int y, int z, float* coverage) {
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k)
    coverage[k] =
        static_cast<float>(cloud.coverage(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1)) *
        (1.0f / 255.0f);
}

namespace {

// A surface crosses a voxel that is partly full, and runs between a full and an empty one.
bool crossed(const Cloud& cloud, int x, int y, int z) {
  const int own = cloud.coverage(x, y, z);
  if (own > 0 && own < 255) return true;
  const int other = 255 - own;
  return cloud.coverage(x - 1, y, z) == other || cloud.coverage(x + 1, y, z) == other ||
         cloud.coverage(x, y - 1, z) == other || cloud.coverage(x, y + 1, z) == other ||
         cloud.coverage(x, y, z - 1) == other || cloud.coverage(x, y, z + 1) == other;
}

struct FoundVoxel {
  std::int16_t x, y, z;
  CcSurface surface;
};

void fitBrick(const Cloud& cloud, const Eigen::Vector3i& brick, std::vector<FoundVoxel>& found) {
  for (int k = 0; k < kBrickVoxels; ++k) {
    const int x = brick.x() * 8 + (k & 7), y = brick.y() * 8 + (k >> 3 & 7),
              z = brick.z() * 8 + (k >> 6);
    if (!crossed(cloud, x, y, z)) continue;
    float block[CC_WINDOW_VOXELS];
    gatherBlock(cloud, x, y, z, block);
    const CcSurface f = ccFitSurface(block, 0);
    // A wisp thinner than 1/255 has no direction: it is not a surface.
    if (f.weight == 0.0f) continue;
    found.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y),
                     static_cast<std::int16_t>(z), f});
  }
}

// A brick of one kind whose six neighbours are of the same kind holds no surface.
bool uniform(const Cloud& cloud, const Eigen::Vector3i& brick) {
  const Eigen::Vector3i n = cloud.bricks();
  const auto kind = [&](const Eigen::Vector3i& b) {
    if ((b.array() < 0).any() || (b.array() >= n.array()).any()) return kEmptyBrick;
    return cloud.voxels().table[static_cast<std::size_t>(b.x() + n.x() * (b.y() + n.y() * b.z()))];
  };
  const std::int32_t own = kind(brick);
  if (own >= 0) return false;
  for (int axis = 0; axis < 3; ++axis)
    for (int side : {-1, 1})
      if (kind(brick + side * Eigen::Vector3i::Unit(axis)) != own) return false;
  return true;
}

}  // namespace

void fitSurfaceVoxels(FieldDraft& draft) {
  const Cloud& cloud = draft.cloud;
  const Eigen::Vector3i bricks = cloud.bricks();
  std::vector<std::vector<FoundVoxel>> found(cloud.voxels().table.size());
  parallelFor(found.size(), draft.settings.threads, [&](std::size_t i, int) {
    const int b = static_cast<int>(i);
    const Eigen::Vector3i at(b % bricks.x(), b / bricks.x() % bricks.y(),
                             b / bricks.x() / bricks.y());
    if (!uniform(cloud, at)) fitBrick(cloud, at, found[i]);
  });
  for (const auto& list : found) {
    for (const FoundVoxel& v : list) {
      SurfaceVoxel voxel{v.x, v.y, v.z};
      voxel.first = static_cast<std::uint32_t>(draft.pieces.size());
      voxel.quadric = voxel.first;
      voxel.count = 1;
      draft.index.make(v.x, v.y, v.z) = static_cast<std::int32_t>(draft.voxels.size());
      draft.pieces.push_back({v.surface, {0, 0, 0}, 0});
      draft.voxels.push_back(voxel);
    }
  }
}

}  // namespace cloudcontact
