// Which voxels a detection area meets, and the sums over them. The area's bounds choose bricks of
// the workpiece; each brick is worked through by itself and gives sums of its own, which are added
// in the bricks' order: so any number of threads gives the same bits.
//
// The depth d is not measured at the collision voxels, which lie anywhere in the tool, but on the
// workpiece's surface: each voxel near it knows its own depth and direction, hence a point of the
// surface, and the tool's area says how deep that point lies in the tool. Voxels share the surface
// by 1 - |depth|, which along the grid adds up to one. From the first three moments follows the
// depth of the deepest point (depth_moments.h). It is smooth in the tool's pose, and right in a
// hole that the tool has cut itself, where the volume over the area, or the deepest voxel, are not.
#include <cloudcontact/collision.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "../geometry/parallel.h"
#include "area_point.h"
#include "depth_moments.h"
#include "field_bricks.h"
#include "sample.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

// Sums over the voxels of a brick; lengths in voxels, the workpiece's grid.
struct BrickSums {
  double count = 0, volume = 0;
  Vec3 mean = Vec3::Zero();
  double moments[3] = {0, 0, 0};                     // of the depth over the touched surface
  Vec3 center = Vec3::Zero();                        // times moments[0]
  double wet = 0;                                    // area
  Eigen::Matrix3d facing = Eigen::Matrix3d::Zero();  // times it

  void add(const BrickSums& other) {
    count += other.count, volume += other.volume, mean += other.mean, center += other.center;
    wet += other.wet, facing += other.facing;
    for (int k = 0; k < 3; ++k) moments[k] += other.moments[k];
  }
};

struct BrickPart {
  Eigen::Vector3i brick;
  std::int32_t block = kNoBlock;
  BrickSums sums;
  std::vector<CollisionVoxel> voxels;
};

// The tool as a brick's loop sees it.
struct View {
  const Bricks* field;
  const Detection* tool;
  Pose toTool;           // from the workpiece's frame
  Eigen::Matrix3d turn;  // of it
  double hardest = 1;    // [Pa] what h = 1 is
  Vec3 inTool(const Vec3& grid) const {
    return turn * (field->origin + field->voxelSize * grid) + toTool.position;
  }
};

double abilityAt(const Detection& tool, const Vec3& point) {
  double ability = tool.ability;
  for (const CuttingPart& part : tool.parts)
    if (areaDepth(part.area, point) >= 0) ability = part.ability;
  return ability;
}

// The surface that this voxel stands for, as far as it lies in the tool.
template <typename Kind>
void addSurface(const View& view, const Kind& area, const Bricks::Weighed& weighed,
                const Vec3& center, BrickSums& sums) {
  if (weighed.fraction >= 1) return;
  const double length = weighed.outward.norm();
  if (!(length > 0)) return;
  const Vec3 outward = weighed.outward / length;
  const double below = view.field->depths.at(outward, weighed.fraction);
  const double weight = 1 - std::abs(below);
  if (!(weight > 0)) return;
  const Vec3 foot = center + below * outward;
  const Vec3 at = view.inTool(foot);
  const double depth = depthOf(area, at) / view.field->voxelSize;
  if (depth <= -0.5) return;  // no part of a voxel's width is deeper
  const double facing = (view.turn * outward).dot(normalOf(area, at));
  const double spread = 0.5 * std::sqrt(std::max(1 - facing * facing, 0.0));
  const CcWet wet = ccWet(static_cast<float>(depth), static_cast<float>(spread));
  sums.moments[0] += weight * static_cast<double>(wet.depth1);
  sums.moments[1] += weight * static_cast<double>(wet.depth2);
  sums.moments[2] += weight * static_cast<double>(wet.depth3);
  sums.center += weight * static_cast<double>(wet.depth1) * foot;
  sums.wet += weight * static_cast<double>(wet.share);
  sums.facing += weight * static_cast<double>(wet.share) * outward * outward.transpose();
}

void addVoxel(const View& view, const FieldBlock& block, int cell, const VoxelIndex& voxel,
              double share, const Bricks::Weighed& weighed, const Vec3& inTool, BrickPart& part) {
  const auto at = static_cast<std::size_t>(cell);
  const std::uint8_t tissue = block.tissue[at];
  const double ability =
      view.tool->parts.empty() ? view.tool->ability : abilityAt(*view.tool, inTool);
  const double hardness =
      view.tool->hardness ? view.field->tissues[tissue].hardness / view.hardest : 1;
  part.sums.count += share;
  part.sums.mean += share * hardness * ability * weighed.toRepresentative;
  part.sums.volume += share;
  part.voxels.push_back({voxel, static_cast<float>(share), static_cast<float>(ability), tissue});
}

template <typename Kind>
void searchBrick(const View& view, const Kind& area, BrickPart& part) {
  const Bricks& f = *view.field;
  const FieldBlock& block = f.blocks[static_cast<std::size_t>(part.block)];
  const bool whole = view.tool->membership == Membership::Whole;
  const Vec3 step = f.voxelSize * view.turn.col(0);
  for (int row = 0; row < kBrickVoxels; row += kBrickEdge) {
    const VoxelIndex first = kBrickEdge * part.brick + VoxelIndex(0, row >> 3 & 7, row >> 6);
    const Vec3 center = first.cast<double>() + Vec3::Constant(0.5);
    Vec3 inTool = view.inTool(center);
    for (int i = 0; i < kBrickEdge; ++i, inTool += step) {
      const int cell = row + i;
      const int coverage = block.coverage[static_cast<std::size_t>(cell)];
      if (coverage == 0) continue;
      const double depth = depthOf(area, inTool) / f.voxelSize;
      if (depth <= -1) continue;
      const Bricks::Weighed weighed = f.weigh(block, cell);
      addSurface(view, area, weighed, center + Vec3(i, 0, 0), part.sums);
      const double share =
          whole ? (depth >= 0 ? 1.0 : 0.0) : std::clamp(depth + 0.5, 0.0, 1.0) * coverage / 255;
      if (share > 0)
        addVoxel(view, block, cell, first + VoxelIndex(i, 0, 0), share, weighed, inTool, part);
    }
  }
}

// The whole brick is farther than a voxel from the area.
template <typename Kind>
bool far(const View& view, const Kind& area, const Eigen::Vector3i& brick) {
  if (!kIsDistance<Kind>) return false;
  const Vec3 middle = (kBrickEdge * brick).cast<double>() + Vec3::Constant(kBrickEdge / 2);
  constexpr double kReach = 1 + kBrickEdge / 2 * 1.7321;
  return depthOf(area, view.inTool(middle)) < -kReach * view.field->voxelSize;
}

View viewOf(const BaseVectorField& workpiece, const Pose& workpiecePose, const Detection& tool,
            const Pose& toolPose) {
  const auto finite = [](const Pose& p) {
    return p.position.allFinite() && p.orientation.coeffs().allFinite();
  };
  if (!finite(workpiecePose) || !finite(toolPose))
    throw std::invalid_argument("a collision's poses must be finite");
  requireArea(tool.area);
  for (const CuttingPart& part : tool.parts) requireArea(part.area);
  View view{&workpiece.bricks(), &tool, toolPose.inverse() * workpiecePose, {}, 1};
  view.turn = view.toTool.orientation.toRotationMatrix();
  if (view.field->tissues[0].hardness > 0) view.hardest = view.field->tissues[0].hardness;
  return view;
}

}  // namespace

struct CollisionFinder::Scratch {
  int threads = 1;
  Collision collision;
  std::vector<BrickPart> parts;  // the first `used` are this call's
  std::size_t used = 0;

  BrickPart& part(const Eigen::Vector3i& brick, std::int32_t block) {
    if (used == parts.size()) parts.emplace_back();
    BrickPart& part = parts[used++];
    part.brick = brick;
    part.block = block;
    part.sums = {};
    part.voxels.clear();
    return part;
  }
  template <typename Kind>
  void chooseBricks(const View& view, const Kind& area);
  void sumUp(const View& view, const Pose& workpiecePose);
};

template <typename Kind>
void CollisionFinder::Scratch::chooseBricks(const View& view, const Kind& area) {
  const Bricks& f = *view.field;
  const Eigen::AlignedBox3d bounds = areaBounds(area);
  Eigen::AlignedBox3d box;
  for (int k = 0; k < 8; ++k)
    box.extend(view.toTool.toLocal(bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))));
  const Vec3 top = (kBrickEdge * f.bricks).cast<double>();
  const Vec3 low = (box.min() - f.origin) / f.voxelSize - Vec3::Ones();
  const Vec3 high = (box.max() - f.origin) / f.voxelSize + Vec3::Ones();
  if ((high.array() < 0).any() || (low.array() > top.array()).any()) return;
  const auto brickOf = [&](const Vec3& x) -> Eigen::Vector3i {
    return x.cwiseMax(0.0).cwiseMin(top - Vec3::Ones()).cast<int>() / kBrickEdge;
  };
  const Eigen::Vector3i first = brickOf(low), last = brickOf(high);
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const std::int32_t block = f.entry(x, y, z);
        if (block != kNoBlock && !far(view, area, {x, y, z})) part({x, y, z}, block);
      }
}

void CollisionFinder::Scratch::sumUp(const View& view, const Pose& workpiecePose) {
  const Bricks& f = *view.field;
  Collision& c = collision;
  c.voxels.clear();
  c.tissueCount.assign(f.tissues.size(), 0.0);
  BrickSums sums;
  for (std::size_t k = 0; k < used; ++k) {
    sums.add(parts[k].sums);
    c.voxels.insert(c.voxels.end(), parts[k].voxels.begin(), parts[k].voxels.end());
    for (const CollisionVoxel& v : parts[k].voxels)
      c.tissueCount[v.tissue] += static_cast<double>(v.share);
  }
  c.count = sums.count;
  c.mean = c.center = Vec3::Zero();
  c.facing.setZero();
  c.stiffness = c.damping = c.depth = 0;
  c.volume = sums.volume * f.voxelSize * f.voxelSize * f.voxelSize;
  if (!(sums.count > 0)) return;
  c.mean = workpiecePose.orientation * Vec3(f.voxelSize / sums.count * sums.mean);
  for (std::size_t t = 0; t < f.tissues.size(); ++t) {
    c.stiffness += c.tissueCount[t] * f.tissues[t].stiffness / sums.count;
    c.damping += c.tissueCount[t] * f.tissues[t].damping / sums.count;
  }
  c.depth = f.voxelSize * deepestByMoments(sums.moments);
  const Eigen::Matrix3d turn = workpiecePose.orientation.toRotationMatrix();
  if (sums.wet > 0) c.facing = turn * (sums.facing / sums.wet) * turn.transpose();
  if (sums.moments[0] > 0)
    c.center = workpiecePose.toWorld(f.origin + f.voxelSize / sums.moments[0] * sums.center);
}

CollisionFinder::CollisionFinder(int threads) : scratch_(std::make_unique<Scratch>()) {
  scratch_->threads = threads;
}
CollisionFinder::~CollisionFinder() = default;
CollisionFinder::CollisionFinder(CollisionFinder&&) noexcept = default;
CollisionFinder& CollisionFinder::operator=(CollisionFinder&&) noexcept = default;

const Collision& CollisionFinder::find(const BaseVectorField& workpiece, const Pose& workpiecePose,
                                       const Detection& tool, const Pose& toolPose) {
  const View view = viewOf(workpiece, workpiecePose, tool, toolPose);
  Scratch& s = *scratch_;
  s.used = 0;
  std::visit(
      [&](const auto& area) {
        s.chooseBricks(view, area);
        parallelFor(s.used, s.threads,
                    [&](std::size_t k, int) { searchBrick(view, area, s.parts[k]); });
      },
      tool.area);
  s.sumUp(view, workpiecePose);
  return s.collision;
}

const Collision& CollisionFinder::gather(const BaseVectorField& workpiece,
                                         const Pose& workpiecePose, const Detection& tool,
                                         const Pose& toolPose, std::span<const VoxelIndex> voxels) {
  const View view = viewOf(workpiece, workpiecePose, tool, toolPose);
  Scratch& s = *scratch_;
  s.used = 0;
  BrickPart& part = s.part(Eigen::Vector3i::Zero(), kNoBlock);
  for (const VoxelIndex& v : voxels) {
    const FieldBlock* const block = view.field->blockOf(v);
    const int cell = Bricks::cell(v.x(), v.y(), v.z());
    if (!block || block->coverage[static_cast<std::size_t>(cell)] == 0) continue;
    const Bricks::Weighed weighed = view.field->weigh(*block, cell);
    const Vec3 center = v.cast<double>() + Vec3::Constant(0.5);
    std::visit([&](const auto& area) { addSurface(view, area, weighed, center, part.sums); },
               tool.area);
    addVoxel(view, *block, cell, v, 1, weighed, view.inTool(center), part);
  }
  s.sumUp(view, workpiecePose);
  return s.collision;
}

void CollisionFinder::reserve(std::size_t voxels, std::size_t tissues) {
  scratch_->collision.voxels.reserve(voxels);
  scratch_->collision.tissueCount.reserve(tissues);
  const std::size_t bricks = 27 + voxels / 64;
  while (scratch_->parts.size() < bricks) scratch_->parts.emplace_back();
  for (BrickPart& part : scratch_->parts) part.voxels.reserve(kBrickVoxels);
}

}  // namespace cloudcontact
