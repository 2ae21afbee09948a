// Finds the collision voxels and sums over them. The bounds of D select bricks of the workpiece.
// Each brick has its own sums, which are added in the order of the bricks, so the number of threads
// does not change the result.
//
// The depth d is measured on the workpiece's surface: each voxel near it has a depth and a
// direction, hence a point of the surface (its foot). Voxels share the surface by 1 - |depth|,
// which adds up to one along the grid. How far D reaches below the feet along the digital normal is
// d (embedding_along.h).
#include <cloudcontact/workpiece/collision_finder.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/parallel.h"
#include "field/base_vector_bricks.h"
#include "kernels/contact/contact_depth.h"
#include "kernels/contact/sample.h"
#include "kernels/cut/digital_normal.h"
#include "workpiece/embedding_along.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

// Sums over the voxels of a brick, in the workpiece's grid [voxels]. Plain numbers rather than
// Vec3: sums of vectors in memory are stored by twos and read by ones, and that wait took half the
// time of a search.
struct BrickSums {
  CcNormalSum normal = ccNoVectors();
  double matter = 0;                      // sum of the shares times the coverage
  double push = 0;                        // of the depth over the touched surface
  double powers[2] = {0, 0};              // likewise of its square and cube
  double center[3] = {0, 0, 0};           // of the touched surface, times `push`
  double wet = 0;                         // area of the touched surface
  double facing[6] = {0, 0, 0, 0, 0, 0};  // times `wet`: xx yy zz xy yz zx

  void add(const BrickSums& other) {
    ccAddLane(&normal, other.normal);
    matter += other.matter;
    wet += other.wet, push += other.push;
    powers[0] += other.powers[0], powers[1] += other.powers[1];
    for (int k = 0; k < 3; ++k) {
      center[k] += other.center[k];
      facing[k] += other.facing[k], facing[k + 3] += other.facing[k + 3];
    }
  }
};

// A voxel in D or at most one voxel outside.
struct NearVoxel {
  int cell;
  double depth;  // of its center in D [voxels]
};

// A piece of the workpiece's surface next to a voxel, in the grid's frame [voxels].
struct Foot {
  double at[3], outward[3];
  double weight;  // the voxel's share of the surface
};

// Half the diagonal of a voxel: D reaches into no voxel whose center is farther away.
constexpr double kInVoxel = 0.866;

struct BrickPart {
  Eigen::Vector3i brick;
  std::int32_t block = kNoBlock;
  Eigen::Vector3i low, high;  // its voxels inside the bounds of D
  BrickSums sums;
  std::vector<CollisionVoxel> voxels;
  std::vector<NearVoxel> near;
  std::vector<Foot> feet;
  std::vector<PlanePiece> pieces;  // the feet near D, in the tool's frame
};

// The query of a find().
struct View {
  const Bricks* field;
  const Detection* tool;
  const double* hardness;  // h of each tissue in (5'), or 1
  Pose toTool;             // from the workpiece's frame
  Eigen::Matrix3d turn;    // its orientation
  Vec3 inTool(const Vec3& grid) const {
    return turn * (field->origin + field->voxelSize * grid) + toTool.position;
  }
  // Coverage of the voxel at a point of the tool's frame.
  double matter(const Vec3& inTool) const {
    const Vec3 grid =
        (turn.transpose() * (inTool - toTool.position) - field->origin) / field->voxelSize;
    const VoxelIndex v = grid.array().floor().cast<int>();
    const FieldBlock* const block = field->blockOf(v);
    return block ? block->coverage[static_cast<std::size_t>(cellIndex(v))] / 255.0 : 0;
  }
};

// The voxels with material in D or at most a voxel outside.
void findNear(const View& view, BrickPart& part) {
  const PlacedSolid& area = view.tool->area;
  const bool distance = isDistance(area.solid);
  const Bricks& f = *view.field;
  const FieldBlock& block = f.blocks[static_cast<std::size_t>(part.block)];
  const Vec3 step = f.voxelSize * view.turn.col(0);
  const double perVoxel = 1 / f.voxelSize;
  const int count = part.high.x() - part.low.x() + 1;
  for (int z = part.low.z(); z <= part.high.z(); ++z)
    for (int y = part.low.y(); y <= part.high.y(); ++y) {
      const VoxelIndex first = kBrickEdge * part.brick + VoxelIndex(part.low.x(), y, z);
      const Vec3 start = view.inTool(first.cast<double>() + Vec3::Constant(0.5));
      const Vec3 middle = start + 0.5 * (count - 1) * step;
      if (distance && depthOf(area, middle) < -(0.5 * (count - 1) + 1) * f.voxelSize) continue;
      double depth[kBrickEdge];
      depthsAlong(area, start, step, count, depth);
      for (int i = 0; i < count; ++i) depth[i] = perVoxel * depth[i];
      for (int i = 0; i < count; ++i) {
        const int cell = cellIndex(part.low.x() + i, y, z);
        if (depth[i] > -1 && block.coverage[static_cast<std::size_t>(cell)] > 0)
          part.near.push_back({cell, depth[i]});
      }
    }
}

// Adds the voxel's piece of the surface, if it is near.
void addFoot(const Bricks& f, const double* gravity, double fraction, const double* center,
             std::vector<Foot>& feet) {
  if (fraction <= f.depths.least() || fraction >= f.depths.most()) return;
  double n[3] = {f.windowCenter.x() - gravity[0], f.windowCenter.y() - gravity[1],
                 f.windowCenter.z() - gravity[2]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0)) return;
  for (double& x : n) x *= 1 / length;
  const double below = f.depths.at(n[0], n[1], n[2], fraction), weight = 1 - std::abs(below);
  if (!(weight > 0)) return;
  feet.push_back({{center[0] + below * n[0], center[1] + below * n[1], center[2] + below * n[2]},
                  {n[0], n[1], n[2]},
                  weight});
}

enum class Counting {
  Center,  // all of a voxel whose center is in D
  Part,    // what is inside D, by the depth of its center
  Touch,   // little of all voxels that a thin D may reach into between their centers
  All
};

double shareOf(Counting counting, double depth, double coverage) {
  switch (counting) {
    case Counting::Center:
      return depth >= 0 ? 1 : 0;
    case Counting::Part:
      return std::clamp(depth + 0.5, 0.0, 1.0) * coverage;
    case Counting::Touch:
      return std::max(depth + kInVoxel, 0.0) * coverage;
    default:
      return 1;
  }
}

void addVoxels(const View& view, BrickPart& part, Counting counting) {
  const Bricks& f = *view.field;
  const FieldBlock& block = f.blocks[static_cast<std::size_t>(part.block)];
  const Detection& tool = *view.tool;
  const bool whole = counting == Counting::Center || counting == Counting::All;
  const VoxelIndex corner = kBrickEdge * part.brick;
  const double gr[3] = {f.window.representative.x(), f.window.representative.y(),
                        f.window.representative.z()};
  BrickSums sums;
  for (const NearVoxel& near : part.near) {
    const auto at = static_cast<std::size_t>(near.cell);
    const CcMoments& m = block.moments[at];
    double vector[3];
    ccBaseVector(&m, gr, vector);
    const double gc[3] = {gr[0] - vector[0], gr[1] - vector[1], gr[2] - vector[2]};
    const VoxelIndex v = corner + cellOffset(near.cell);
    const double center[3] = {v.x() + 0.5, v.y() + 0.5, v.z() + 0.5};
    addFoot(f, gc, block.volume[at] * f.perFull, center, part.feet);
    const double coverage = block.coverage[at] / 255.0;
    const double share = shareOf(counting, near.depth, coverage);
    if (!(share > 0)) continue;
    const std::uint8_t tissue = block.tissue[at];
    const double ability = tool.parts.empty()
                               ? tool.ability
                               : abilityAt(tool.ability, tool.parts,
                                           view.inTool(Vec3(center[0], center[1], center[2])));
    ccAddVector(&sums.normal, vector, share, ccWeightOf(share, view.hardness[tissue], ability));
    sums.matter += whole ? share * coverage : share;
    part.voxels.push_back({v, static_cast<float>(share), static_cast<float>(ability), tissue});
  }
  part.sums.add(sums);
}

// Adds the sums over the feet in D, and keeps those for the depth.
void addSurface(const View& view, BrickPart& part) {
  const PlacedSolid& area = view.tool->area;
  const double perVoxel = 1 / view.field->voxelSize;
  BrickSums sums;
  for (const Foot& foot : part.feet) {
    const Vec3 at = view.inTool(Vec3(foot.at[0], foot.at[1], foot.at[2]));
    const SolidPoint near = pointOf(area, at);
    const double depth = perVoxel * near.depth;
    if (depth <= -EmbeddingAlong::kReach) continue;
    const Vec3 outward = view.turn * Vec3(foot.outward[0], foot.outward[1], foot.outward[2]);
    if (view.tool->depth == DepthTo::Tip) part.pieces.push_back({at, outward, foot.weight});
    if (depth <= -0.5) continue;  // no part of a voxel's width is inside
    const double facing = outward.dot(near.normal);
    const double spread = 0.5 * std::sqrt(std::max(1 - facing * facing, 0.0));
    const CcWet wet = ccWet(static_cast<float>(depth), static_cast<float>(spread));
    const double first = foot.weight * static_cast<double>(wet.depth1);
    const double area2 = foot.weight * static_cast<double>(wet.share);
    sums.push += first;
    sums.powers[0] += foot.weight * static_cast<double>(wet.depth2);
    sums.powers[1] += foot.weight * static_cast<double>(wet.depth3);
    sums.wet += area2;
    for (int k = 0; k < 3; ++k) {
      sums.center[k] += first * foot.at[k];
      sums.facing[k] += area2 * foot.outward[k] * foot.outward[k];
      sums.facing[k + 3] += area2 * foot.outward[k] * foot.outward[(k + 1) % 3];
    }
  }
  part.sums.add(sums);
}

void searchBrick(const View& view, BrickPart& part) {
  findNear(view, part);
  const bool whole = view.tool->membership == Membership::Whole;
  addVoxels(view, part, whole ? Counting::Center : Counting::Part);
  addSurface(view, part);
}

Vec3 outwardOf(const BrickSums& sums) {
  const double* const v = ccIsPlain(&sums.normal) ? sums.normal.plain : sums.normal.vector;
  return {v[0], v[1], v[2]};
}

// Whether the whole brick is more than a voxel outside D.
bool far(const View& view, const Eigen::Vector3i& brick) {
  const PlacedSolid& area = view.tool->area;
  if (!isDistance(area.solid)) return false;
  const Vec3 middle = (kBrickEdge * brick).cast<double>() + Vec3::Constant(kBrickEdge / 2);
  constexpr double kReach = 1 + kBrickEdge / 2 * 1.7321;
  return depthOf(area, view.inTool(middle)) < -kReach * view.field->voxelSize;
}

View viewOf(const BaseVectorField& workpiece, const Pose& workpiecePose, const Detection& tool,
            const Pose& toolPose, std::vector<double>& hardness) {
  const auto finite = [](const Pose& p) {
    return p.position.allFinite() && p.orientation.coeffs().allFinite();
  };
  if (!finite(workpiecePose) || !finite(toolPose))
    throw std::invalid_argument("a collision's poses must be finite");
  validate(tool.area);
  for (const CuttingPart& part : tool.parts) validate(part.area);
  hardnessOf(workpiece.tissues(), tool.hardness, hardness);
  View view{&workpiece.bricks(), &tool, hardness.data(), toolPose.inverse() * workpiecePose, {}};
  view.turn = view.toTool.orientation.toRotationMatrix();
  return view;
}

}  // namespace

struct CollisionFinder::State {
  int threads = 1;
  Collision collision;
  std::vector<BrickPart> parts;  // the first `used` are this call's
  std::size_t used = 0;
  std::vector<double> hardness;
  std::vector<PlanePiece> pieces;
  EmbeddingAlong embedding;

  BrickPart& part(const Eigen::Vector3i& brick, std::int32_t block) {
    if (used == parts.size()) parts.emplace_back();
    BrickPart& part = parts[used++];
    part.brick = brick;
    part.block = block;
    part.sums = {};
    part.voxels.clear();
    part.near.clear();
    part.feet.clear();
    part.pieces.clear();
    return part;
  }
  void chooseBricks(const View& view);
  BrickSums sumOfParts() const;
  void listVoxels(const TissueTable& tissues);
  void touch(const View& view);
  void sumUp(const View& view, const Pose& workpiecePose);
  double depth(const View& view, const Vec3& outward);
};

void CollisionFinder::State::chooseBricks(const View& view) {
  const Bricks& f = *view.field;
  const Eigen::AlignedBox3d bounds = boundsOf(view.tool->area);
  Eigen::AlignedBox3d box;
  for (int k = 0; k < 8; ++k)
    box.extend(view.toTool.toLocal(bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))));
  const Vec3 top = (kBrickEdge * f.bricks).cast<double>();
  const Vec3 low = (box.min() - f.origin) / f.voxelSize - Vec3::Ones();
  const Vec3 high = (box.max() - f.origin) / f.voxelSize + Vec3::Ones();
  if ((high.array() < 0).any() || (low.array() > top.array()).any()) return;
  const auto voxelOf = [&](const Vec3& x) -> Eigen::Vector3i {
    return x.cwiseMax(0.0).cwiseMin(top - Vec3::Ones()).cast<int>();
  };
  const Eigen::Vector3i from = voxelOf(low), to = voxelOf(high);
  const Eigen::Vector3i first = from / kBrickEdge, last = to / kBrickEdge;
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const std::int32_t block = f.entry(x, y, z);
        const Eigen::Vector3i brick(x, y, z);
        if (block == kNoBlock || far(view, brick)) continue;
        BrickPart& here = part(brick, block);
        here.low = (from - kBrickEdge * brick).cwiseMax(0);
        here.high = (to - kBrickEdge * brick).cwiseMin(kBrickEdge - 1);
      }
}

// Of the tool along `outward`, which is in the grid's frame and of any length.
double CollisionFinder::State::depth(const View& view, const Vec3& outward) {
  pieces.clear();
  for (std::size_t k = 0; k < used; ++k)
    pieces.insert(pieces.end(), parts[k].pieces.begin(), parts[k].pieces.end());
  const double length = outward.norm();
  const Vec3 n = length > 0 ? Vec3(view.turn * outward / length) : Vec3::Zero();
  const auto matter = [&view](const Vec3& inTool) { return view.matter(inTool); };
  return embedding.find({&view.tool->area, n, view.field->voxelSize, matter, threads}, pieces);
}

BrickSums CollisionFinder::State::sumOfParts() const {
  BrickSums sums;
  for (std::size_t k = 0; k < used; ++k) sums.add(parts[k].sums);
  return sums;
}

// A tool thinner than a voxel may pass between the centers, and no voxel has a share in it.
void CollisionFinder::State::touch(const View& view) {
  const Detection& tool = *view.tool;
  if (tool.membership == Membership::Whole || tool.depth == DepthTo::Nearest) return;
  if (sumOfParts().normal.count > 0) return;
  for (std::size_t k = 0; k < used; ++k) addVoxels(view, parts[k], Counting::Touch);
  const BrickSums sums = sumOfParts();
  if (sums.normal.count > 0 && depth(view, outwardOf(sums)) > 0) return;
  for (std::size_t k = 0; k < used; ++k) parts[k].sums = {}, parts[k].voxels.clear();
}

void CollisionFinder::State::listVoxels(const TissueTable& tissues) {
  Collision& c = collision;
  c.voxels.clear();
  c.tissueCount.assign(tissues.size(), 0.0);
  c.stiffness = c.damping = 0;
  for (std::size_t k = 0; k < used; ++k) {
    c.voxels.insert(c.voxels.end(), parts[k].voxels.begin(), parts[k].voxels.end());
    for (const CollisionVoxel& v : parts[k].voxels)
      c.tissueCount[v.tissue] += static_cast<double>(v.share);
  }
  if (!(c.count > 0)) return;
  CcTissueSum sum{};
  for (std::size_t t = 0; t < tissues.size(); ++t)
    ccAddTissue(&sum, c.tissueCount[t], tissues[t].stiffness, tissues[t].damping);
  c.stiffness = sum.stiffness / sum.count;
  c.damping = sum.damping / sum.count;
}

void CollisionFinder::State::sumUp(const View& view, const Pose& workpiecePose) {
  const Bricks& f = *view.field;
  Collision& c = collision;
  const BrickSums sums = sumOfParts();
  c.count = sums.normal.count;
  c.volume = sums.matter * f.voxelSize * f.voxelSize * f.voxelSize;
  listVoxels(f.tissues);
  c.mean = c.center = Vec3::Zero();
  c.facing.setZero();
  c.depth = 0;
  if (!(sums.normal.count > 0)) return;
  const Vec3 outward = outwardOf(sums);
  c.mean = workpiecePose.orientation * (f.voxelSize / sums.normal.count * outward);
  const double moments[3] = {sums.push, sums.powers[0], sums.powers[1]};
  c.depth = view.tool->depth == DepthTo::Tip ? depth(view, outward)
                                             : f.voxelSize * ccDeepestByMoments(moments);
  const Eigen::Matrix3d turn = workpiecePose.orientation.toRotationMatrix();
  const double* const n = sums.facing;
  Eigen::Matrix3d facing;
  facing << n[0], n[3], n[5], n[3], n[1], n[4], n[5], n[4], n[2];
  if (sums.wet > 0) c.facing = turn * (facing / sums.wet) * turn.transpose();
  if (sums.push > 0)
    c.center = workpiecePose.toWorld(
        f.origin + f.voxelSize / sums.push * Vec3(sums.center[0], sums.center[1], sums.center[2]));
}

CollisionFinder::CollisionFinder(int threads) : state_(std::make_unique<State>()) {
  state_->threads = threads;
}
CollisionFinder::~CollisionFinder() = default;
CollisionFinder::CollisionFinder(CollisionFinder&&) noexcept = default;
CollisionFinder& CollisionFinder::operator=(CollisionFinder&&) noexcept = default;

const Collision& CollisionFinder::find(const BaseVectorField& workpiece, const Pose& workpiecePose,
                                       const Detection& tool, const Pose& toolPose) {
  const View view = viewOf(workpiece, workpiecePose, tool, toolPose, state_->hardness);
  State& s = *state_;
  s.used = 0;
  s.chooseBricks(view);
  parallelFor(s.used, s.threads, [&](std::size_t k, int) { searchBrick(view, s.parts[k]); });
  s.touch(view);
  s.sumUp(view, workpiecePose);
  return s.collision;
}

const Collision& CollisionFinder::gather(const BaseVectorField& workpiece,
                                         const Pose& workpiecePose, const Detection& tool,
                                         const Pose& toolPose, Span<const VoxelIndex> voxels) {
  const View view = viewOf(workpiece, workpiecePose, tool, toolPose, state_->hardness);
  State& s = *state_;
  s.used = 0;
  for (std::size_t k = 0; k < voxels.size();) {
    // A run of voxels in one brick.
    const FieldBlock* const block = view.field->blockOf(voxels[k]);
    const Eigen::Vector3i brick = voxels[k] / kBrickEdge;
    if (!block) {
      ++k;
      continue;
    }
    BrickPart& part = s.part(brick, static_cast<std::int32_t>(block - view.field->blocks.data()));
    for (; k < voxels.size() && view.field->blockOf(voxels[k]) == block; ++k) {
      const int cell = cellIndex(voxels[k]);
      if (block->coverage[static_cast<std::size_t>(cell)] > 0) part.near.push_back({cell, 0});
    }
    addVoxels(view, part, Counting::All);
    addSurface(view, part);
  }
  s.sumUp(view, workpiecePose);
  return s.collision;
}

void CollisionFinder::reserve(std::size_t voxels, std::size_t tissues) {
  state_->collision.voxels.reserve(voxels);
  state_->collision.tissueCount.reserve(tissues);
  const std::size_t bricks = 27 + voxels / 64;
  while (state_->parts.size() < bricks) state_->parts.emplace_back();
  for (BrickPart& part : state_->parts) {
    part.voxels.reserve(kBrickVoxels);
    part.near.reserve(kBrickVoxels);
    part.feet.reserve(kBrickVoxels);
    part.pieces.reserve(kBrickVoxels);
  }
  state_->pieces.reserve(voxels);
  state_->embedding.reserve(voxels);
}

}  // namespace cloudcontact
