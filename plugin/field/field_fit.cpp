// Fits the quadrics, brick by brick.
#include "field/field_fit.h"

#include "base/parallel.h"
#include "base/simd.h"

namespace cloudcontact {

void gatherBlock(const Cloud& cloud, int x, int y, int z, float* coverage) {
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k)
    coverage[k] =
        static_cast<float>(cloud.coverage(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1)) *
        (1.0f / 255.0f);
}

namespace {

// The surface crosses voxels that are partly full, and runs between a full voxel and an empty one.
bool crossed(const Cloud& cloud, int x, int y, int z) {
  const int own = cloud.coverage(x, y, z);
  if (own > 0 && own < 255) return true;
  const int other = 255 - own;
  return cloud.coverage(x - 1, y, z) == other || cloud.coverage(x + 1, y, z) == other ||
         cloud.coverage(x, y - 1, z) == other || cloud.coverage(x, y + 1, z) == other ||
         cloud.coverage(x, y, z - 1) == other || cloud.coverage(x, y, z + 1) == other;
}

// What renewing costs [us].
constexpr double kBrickCost = 3, kVoxelCost = 0.5;

// Flattened, so that the loops over the window are compiled for each instruction set.
CC_LANES [[gnu::flatten]] void fitBlock(const float* block, CcSurface& f) {
  f = ccFitSurface(block, 0);
}

VoxelStep quadricStep() {
  return {0, -1, 1, 0, PieceRule::Smooth};
}

std::int16_t addQuadric(SurfaceBrick& brick, const CcSurface& f) {
  const std::int16_t step = brick.addStep(quadricStep());
  brick.pieces.back() = {f, {0, 0, 0}, 0};
  return step;
}

CcSurface fitCell(const FieldDraft& draft, const Eigen::Vector3i& low, int cell) {
  const Eigen::Vector3i v = low + cellOffset(cell);
  return fitVoxel(draft.cloud, v.x(), v.y(), v.z());
}

void fitBrick(FieldDraft& draft, std::size_t t) {
  const Eigen::Vector3i low = draft.cornerOf(t);
  SurfaceBrick* brick = nullptr;
  for (int k = 0; k < kBrickVoxels; ++k) {
    const CcSurface f = fitCell(draft, low, k);
    if (f.weight == 0.0f) continue;
    if (!brick) brick = &draft.write(t);
    brick->voxels.push_back({static_cast<std::int16_t>(k), addQuadric(*brick, f)});
  }
  if (brick) brick->findPlaces();
}

// True if the brick and its six neighbors are all empty or all solid: it holds no surface.
bool uniform(const Cloud& cloud, const Eigen::Vector3i& brick) {
  const Eigen::Vector3i n = cloud.bricks();
  const auto kind = [&](const Eigen::Vector3i& b) {
    return insideGrid(b, n) ? cloud.voxels().table[gridIndex(b, n)] : kEmptyBrick;
  };
  const std::int32_t own = kind(brick);
  if (own >= 0) return false;
  for (int axis = 0; axis < 3; ++axis)
    for (int side : {-1, 1})
      if (kind(brick + side * Eigen::Vector3i::Unit(axis)) != own) return false;
  return true;
}

// Fits the voxels of a brick in `scope` and appends those that changed to `changed`.
void renewBrick(FieldDraft& draft, std::size_t t, const VoxelSet::Rows& scope,
                std::vector<int>& changed) {
  const Eigen::Vector3i low = draft.cornerOf(t);
  const SurfaceBrick* const before = draft.brick(t);
  std::vector<SurfaceVoxel> voxels;
  for (int k = 0; k < kBrickVoxels; ++k) {
    const int known = before ? before->place[static_cast<std::size_t>(k)] : -1;
    const auto keep = [&] {
      if (known >= 0) voxels.push_back(before->voxels[static_cast<std::size_t>(known)]);
    };
    if (!VoxelSet::holds(scope, k)) {
      keep();
      continue;
    }
    const CcSurface f = fitCell(draft, low, k);
    if (f.weight == 0.0f && known < 0) continue;
    const VoxelStep step = quadricStep();
    const SurfacePiece piece{f, {0, 0, 0}, 0};
    if (f.weight != 0.0f && known >= 0 && same(before->state(k, 1), {&step, &piece})) {
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

// A wisp thinner than 1/255 has no direction; ccFitSurface() gives it weight 0.
CcSurface fitVoxel(const Cloud& cloud, int x, int y, int z) {
  CcSurface f{};
  if (!crossed(cloud, x, y, z)) return f;
  float block[CC_WINDOW_VOXELS];
  gatherBlock(cloud, x, y, z, block);
  fitBlock(block, f);
  return f;
}

void fitVoxels(FieldDraft& draft) {
  parallelFor(draft.bricks().size(), draft.threads, [&](std::size_t t, int) {
    if (!uniform(draft.cloud, draft.cornerOf(t) / kBrickEdge)) fitBrick(draft, t);
  });
}

VoxelSet renewFits(FieldDraft& draft, const VoxelSet& scope) {
  VoxelSet all(draft.cloud.bricks());
  std::vector<int> changed;
  for (const std::int32_t t : scope.bricks()) {
    changed.clear();
    draft.spend(kBrickCost + VoxelSet::count(*scope.find(t)) * kVoxelCost);
    renewBrick(draft, static_cast<std::size_t>(t), *scope.find(t), changed);
    for (const int k : changed) {
      const DraftVoxel v = draft.voxelAt(t, k);
      all.add(v.x, v.y, v.z);
    }
  }
  return all;
}

}  // namespace cloudcontact
