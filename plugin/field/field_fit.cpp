// The first step of the field: which voxels the surface crosses, and its quadric in each.
#include "base/parallel.h"
#include "base/simd.h"
#include "field/field_builder.h"

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

// With all that it calls within it, so that the loops over the window are the machine's own.
CC_LANES [[gnu::flatten]] void fitWindow(const float* block, CcSurface& f) {
  f = ccFitSurface(block, 0);
}

// The voxel's quadric; of weight 0 where no surface crosses it. A wisp thinner than 1/255 has no
// direction: it is not a surface.
CcSurface fitVoxel(const Cloud& cloud, int x, int y, int z) {
  CcSurface f{};
  if (!crossed(cloud, x, y, z)) return f;
  float block[CC_WINDOW_VOXELS];
  gatherBlock(cloud, x, y, z, block);
  fitWindow(block, f);
  return f;
}

std::int16_t addQuadric(SurfaceBrick& brick, const CcSurface& f) {
  const std::int16_t step = brick.addStep({0, -1, 1, 0, PieceRule::Smooth});
  brick.pieces.back() = {f, {0, 0, 0}, 0};
  return step;
}

void fitBrick(FieldDraft& draft, std::size_t t) {
  const Eigen::Vector3i low = draft.cornerOf(t);
  SurfaceBrick* brick = nullptr;
  for (int k = 0; k < kBrickVoxels; ++k) {
    const CcSurface f =
        fitVoxel(draft.cloud, low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6));
    if (f.weight == 0.0f) continue;
    if (!brick) brick = &draft.write(t);
    brick->voxels.push_back({static_cast<std::int16_t>(k), addQuadric(*brick, f)});
  }
  if (brick) brick->findPlaces();
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
  parallelFor(draft.bricks().size(), draft.settings.threads, [&](std::size_t t, int) {
    if (!uniform(draft.cloud, draft.cornerOf(t) / kBrickEdge)) fitBrick(draft, t);
  });
}

namespace {

// The voxels of a brick that are looked at again, each as it now is; `changed` tells which of them
// are not what they were.
void refitBrick(FieldDraft& draft, std::size_t t, const VoxelSet::Rows& where,
                std::vector<int>& changed) {
  const Eigen::Vector3i low = draft.cornerOf(t);
  const SurfaceBrick* const before = draft.brick(t);
  std::vector<SurfaceVoxel> voxels;
  for (int k = 0; k < kBrickVoxels; ++k) {
    const int known = before ? before->place[static_cast<std::size_t>(k)] : -1;
    const auto keep = [&] {
      if (known >= 0) voxels.push_back(before->voxels[static_cast<std::size_t>(known)]);
    };
    if (!VoxelSet::holds(where, k)) {
      keep();
      continue;
    }
    const CcSurface f =
        fitVoxel(draft.cloud, low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6));
    if (f.weight == 0.0f && known < 0) continue;
    const VoxelStep quadric{0, -1, 1, 0, PieceRule::Smooth};
    const SurfacePiece piece{f, {0, 0, 0}, 0};
    if (f.weight != 0.0f && known >= 0 && same(before->state(k, 1), {&quadric, &piece})) {
      keep();
      continue;
    }
    changed.push_back(k);
    if (f.weight != 0.0f)
      voxels.push_back({static_cast<std::int16_t>(k), addQuadric(draft.write(t), f)});
  }
  if (changed.empty()) return;
  SurfaceBrick& brick = draft.write(t);
  brick.voxels = std::move(voxels);
  brick.findPlaces();
}

}  // namespace

VoxelSet refitSurfaceVoxels(FieldDraft& draft, const VoxelSet& where) {
  VoxelSet all(draft.cloud.bricks());
  std::vector<int> changed;
  for (const std::int32_t t : where.bricks()) {
    changed.clear();
    const std::size_t brick = static_cast<std::size_t>(t);
    refitBrick(draft, brick, *where.find(t), changed);
    const Eigen::Vector3i low = draft.cornerOf(brick);
    for (const int k : changed)
      all.add(low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6));
  }
  return all;
}

}  // namespace cloudcontact
