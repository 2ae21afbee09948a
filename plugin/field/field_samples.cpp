// Cuts the surface into samples, finer ones beside edges and tips, and gives slivers to neighbors.
#include "field/field_samples.h"

#include "base/parallel.h"
#include "field/piece_cut.h"
#include "kernels/contact/field_voxel.h"
#include "voxels/brick_grid.h"

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;
using V3i = Eigen::Vector3i;

// Part of a voxel's volume: rounding of coverage to 1/255 and its noise.
constexpr float kSliverShare = 0.004f;
constexpr float kSound = 0.004f;      // largest residual of a quadric that extends to its neighbors
constexpr float kSureEdge = 0.01f;    // largest residual of an edge whose slivers become samples
constexpr float kOwnSliver = 0.01f;   // [voxel^2] smaller slivers are merged into a sample
constexpr float kEdgeSliver = 0.12f;  // [voxel^2] largest area of an edge's or corner's sliver
constexpr float kSmallest = 0.5f;     // edge of the smallest box that a piece is cut into
// The same where more than three faces meet in a voxel, as slivers that run to a tip. With half a
// voxel the center of the last one lies 0.33 voxel from the tip, which is felt that late. At the
// tip itself: with a quarter, a tip of 19 deg that is 0.2 voxel deep in a face reads 0.06, with an
// eighth 0.14. Everywhere, an eighth makes a nut gain 1.1 % of energy on its way down its bolt.
constexpr float kSmallestOfMany = 0.25f, kSmallestAtTip = 0.125f;
constexpr float kTipWithin = 0.75f, kTipOff = 0.15f;  // [voxels] from the middle; of any face
constexpr float kTipVolume = 0.1f;                    // of three normals

// What a sample costs, the voxels around one looked at for slivers, and a sliver [us].
constexpr double kSampleCost = 0.8, kLookCost = 0.3, kSliverCost = 0.3;

// Calls visit(index, state) for the surface voxels of a brick, or those in `scope`.
template <typename Visit>
void forEachVoxel(const FieldDraft& draft, std::int32_t brick, const VoxelSet* scope,
                  Visit&& visit) {
  const SurfaceBrick* const b = draft.brick(static_cast<std::size_t>(brick));
  if (!b) return;
  for (const SurfaceVoxel& v : b->voxels)
    if (!scope || scope->has(brick, v.cell))
      visit(draft.voxelAt(brick, v.cell), b->stateAt(v.last));
}

// True if an edge runs through the voxel or one beside it, and the voxel's own surface fits well;
// otherwise finer samples would only resolve its errors. Samples there are half a voxel wide. Wider
// ones reach under a wall's edge from a voxel away, and a loop over the edge does not close: 1.3 %
// of its work, against 0.3 %.
bool besideEdge(const FieldDraft& draft, const DraftVoxel& at, const VoxelState& v) {
  if (v.pieces[0].surface.residual > kSureEdge) return false;
  for (int k = 0; k < 27; ++k) {
    const VoxelState other = draft.at(at.x + k % 3 - 1, at.y + k / 3 % 3 - 1, at.z + k / 9 - 1);
    if (other && other.count() > 1) return true;
  }
  return false;
}

// Whether all of more than three faces meet in a point in or beside the voxel.
bool hasTip(const VoxelState& v) {
  if (v.count() <= 3 || v.rule() == PieceRule::Concave) return false;
  const auto normal = [&v](int k) { return V3(Eigen::Map<const V3>(v.pieces[k].surface.n)); };
  for (int i = 0; i < v.count(); ++i)
    for (int j = i + 1; j < v.count(); ++j)
      for (int k = j + 1; k < v.count(); ++k) {
        Eigen::Matrix3f rows;
        rows << normal(i).transpose(), normal(j).transpose(), normal(k).transpose();
        if (std::abs(rows.determinant()) < kTipVolume) continue;
        const V3 tip = rows.inverse() *
                       V3(v.pieces[i].surface.s, v.pieces[j].surface.s, v.pieces[k].surface.s);
        bool all = tip.lpNorm<Eigen::Infinity>() < kTipWithin;
        for (int f = 0; all && f < v.count(); ++f)
          all = std::abs(normal(f).dot(tip) - v.pieces[f].surface.s) < kTipOff;
        if (all) return true;
      }
  return false;
}

float smallestOf(const VoxelState& v) {
  return hasTip(v) ? kSmallestAtTip : v.count() > 3 ? kSmallestOfMany : kSmallest;
}

// Samples of a piece inside a box: one, or those of the box's octants if `fine` or if another piece
// bounds it there. So samples are small beside an edge only.
void cutBox(const V3& center, const VoxelState& v, int own, const V3& low, float edge, bool fine,
            float smallest, std::vector<SurfaceSample>& samples) {
  const CutPart part = cutPiece(v, own, low, edge);
  if (part.area == 0) return;
  if ((!part.bounded && !fine) || edge < 1.5f * smallest) {
    samples.push_back(sampleOf(v.pieces[own].surface, part, center));
    return;
  }
  const float half = 0.5f * edge;
  for (int k = 0; k < 8; ++k)
    cutBox(center, v, own, low + half * V3(float(k & 1), float(k >> 1 & 1), float(k >> 2)), half,
           fine, smallest, samples);
}

// Appends the samples of a piece and stores its area and centroid.
SampleRun cutOnePiece(const V3& center, const VoxelState& v, int own, bool fine,
                      std::vector<SurfaceSample>& samples, SurfacePiece& piece) {
  const std::size_t begin = samples.size();
  cutBox(center, v, own, V3::Constant(-0.5f), 1.0f, fine, smallestOf(v), samples);
  float area = 0;
  V3 sum = V3::Zero();
  for (std::size_t i = begin; i < samples.size(); ++i) {
    area += samples[i].area;
    sum += samples[i].area * Eigen::Map<const V3>(samples[i].position);
  }
  // A plane that has no piece inside the voxel is placed at its point nearest to the center.
  const Eigen::Map<const V3> n(v.pieces[own].surface.n);
  const V3 at = area > 0 ? V3(sum / area) : V3(center + n * v.pieces[own].surface.s);
  piece.area = area;
  for (int i = 0; i < 3; ++i) piece.centroid[i] = at[i];
  return {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(samples.size() - begin)};
}

struct BrickCut {
  std::vector<SurfaceSample> samples;
  std::vector<SampleOrigin> origins;
  std::vector<SampleRun> runs;  // samples of each of the brick's pieces
};

// The brick, to be written to, or null if it has no voxels in `scope`. The draft's first write to a
// brick that it shares replaces it; call this before others read the brick.
SurfaceBrick* ownBrick(FieldDraft& draft, std::int32_t t, const VoxelSet* scope) {
  bool any = false;
  forEachVoxel(draft, t, scope, [&](const DraftVoxel&, const VoxelState&) { any = true; });
  return any ? &draft.write(static_cast<std::size_t>(t)) : nullptr;
}

void cutBrick(const FieldDraft& draft, std::int32_t t, const VoxelSet* scope, SurfaceBrick& brick,
              BrickCut& cut) {
  cut.runs.resize(brick.pieces.size());
  forEachVoxel(draft, t, scope, [&](const DraftVoxel& at, const VoxelState& v) {
    const bool fine = besideEdge(draft, at, v);
    const std::size_t begin = cut.samples.size();
    for (int own = 0; own < v.count(); ++own) {
      const std::size_t piece = v.step->first + static_cast<std::size_t>(own);
      cut.runs[piece] = cutOnePiece(at.center(), v, own, fine, cut.samples, brick.pieces[piece]);
    }
    for (std::size_t i = begin; i < cut.samples.size(); ++i)
      cut.origins.push_back(SampleOrigin::ofVoxel(t, at.cell, static_cast<int>(i - begin)));
  });
}

// Slivers. A voxel that the surface cuts by less than 1/510 counts as full or empty and has no
// pieces. But the surface inside such voxels is 1.3 % of an oblique surface; an edge reaches 0.05
// voxel into one (a wall pressed in by half a voxel would push 20 % too little), a corner 0.23.
// Each such voxel is therefore assigned to the neighbor whose surface runs nearest to it. The
// pieces inside it become separate samples at an edge, and are merged into the neighbor's samples
// elsewhere.
class SliverCutter {
 public:
  // `scope`: the voxels whose samples were cut; null: all. `slots`: index of each brick in `cuts`.
  SliverCutter(const FieldDraft& draft, const VoxelSet* scope,
               const std::vector<std::int32_t>& slots, std::vector<BrickCut>& cuts)
      : draft_(draft), scope_(scope), slots_(slots), cuts_(cuts), seen_(draft.cloud.bricks(), 0) {}

  // Visits the surface voxels of these bricks, or those in `by`, in their order. A sliver's rank is
  // that of the first surface voxel beside it, and so does not depend on the scope. Only slivers in
  // `in`, if given.
  std::vector<CutSample> run(const std::vector<std::int32_t>& bricks, const VoxelSet* by,
                             const VoxelSet* in) {
    in_ = in;
    for (const std::int32_t t : bricks) {
      int voxels = 0;
      forEachVoxel(draft_, t, by, [&](const DraftVoxel& at, const VoxelState&) {
        for (int k = 0; k < 27; ++k)
          visit(at, k, at.x + k % 3 - 1, at.y + k / 3 % 3 - 1, at.z + k / 9 - 1);
        ++voxels;
      });
      draft_.spend(kLookCost * voxels);
    }
    // Found in parallel, some at a time to limit memory, and assigned in order.
    std::vector<Sliver> found;
    const std::size_t atOnce = draft_.partsAtOnce(256, kAtOnce);
    for (std::size_t first = 0; first < candidates_.size(); first += atOnce) {
      found.resize(std::min(atOnce, candidates_.size() - first));
      parallelFor((found.size() + kTask - 1) / kTask, draft_.threads, [&](std::size_t task, int) {
        const std::size_t end = std::min(found.size(), (task + 1) * kTask);
        for (std::size_t i = task * kTask; i < end; ++i) found[i] = find(candidates_[first + i]);
      });
      for (std::size_t i = 0; i < found.size(); ++i) assign(candidates_[first + i], found[i]);
      draft_.spend(kSliverCost * static_cast<double>(found.size()));
    }
    return std::move(extra_);
  }

 private:
  struct Sliver {
    DraftVoxel at{};  // of the owner, the neighbor that it is assigned to
    VoxelState owner;
    int pieces = 0;
    int own[CC_MAX_PLANES] = {};
    CutPart part[CC_MAX_PLANES];
  };

  // A voxel that may be a sliver, and the first surface voxel beside it.
  struct Candidate {
    std::int32_t brick;
    std::int16_t cell, side;  // side: index of the sliver among the 27 voxels around that voxel
    int x, y, z;
  };
  static constexpr std::size_t kAtOnce = 8192, kTask = 64;
  // The voxels around one: beside faces, beside edges, beside corners.
  static constexpr int kNearestFirst[26] = {4,  10, 12, 14, 16, 22, 1, 3, 5, 7,  9,  11, 15,
                                            17, 19, 21, 23, 25, 0,  2, 6, 8, 18, 20, 24, 26};

  void visit(const DraftVoxel& from, int k, int x, int y, int z) {
    if (!seen_.contains(x, y, z) || (in_ && !in_->has(x, y, z))) return;
    std::uint8_t& seen = seen_.make(x, y, z);
    if (seen) return;
    seen = 1;
    if (draft_.at(x, y, z)) return;
    candidates_.push_back({from.brick, from.cell, static_cast<std::int16_t>(k), x, y, z});
  }

  void assign(const Candidate& c, const Sliver& sliver) {
    if (sliver.pieces == 0 || (scope_ && !scope_->has(sliver.at.brick, sliver.at.cell))) return;
    for (int i = 0; i < sliver.pieces; ++i)
      assign(sliver, i, SampleOrigin::ofSliver(c.brick, c.cell, 8 * c.side + sliver.own[i]));
  }

  Sliver find(const Candidate& c) const {
    const int x = c.x, y = c.y, z = c.z;
    const float filled = draft_.cloud.coverage(x, y, z) > 127 ? 1.0f : 0.0f;
    Sliver best;
    int nearest = 4;  // squared distance to the owner's center [voxel^2]
    for (const int k : kNearestFirst) {
      const V3i by(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (by.squaredNorm() >= nearest) break;
      const V3i at = V3i(x, y, z) + by;
      const VoxelState other = draft_.at(at.x(), at.y(), at.z());
      if (!other) continue;
      const Sliver found = sliverOf(other, -by.cast<float>(), filled);
      if (found.pieces == 0) continue;
      nearest = by.squaredNorm();
      best = found;
      best.at = draft_.voxelAt(at.x(), at.y(), at.z());
    }
    return best;
  }

  // True if a piece's plane runs through the voxel at `offset` from its own, or just beside.
  static bool crosses(const SurfacePiece& piece, const V3& offset) {
    const Eigen::Map<const V3> n(piece.surface.n);
    const float off = std::abs(n.dot(offset) - piece.surface.s);
    return piece.area > 0 && off <= 0.5f * n.lpNorm<1>() + kMostJitter;
  }

  static bool crossesAny(const VoxelState& v, const V3& offset) {
    return std::any_of(v.pieces, v.pieces + v.count(),
                       [&](const SurfacePiece& piece) { return crosses(piece, offset); });
  }

  // The voxel's pieces inside the one at `offset` from it. None if they would cut off too much:
  // then the surface has bent away or ended.
  static Sliver sliverOf(const VoxelState& v, const V3& offset, float filled) {
    Sliver sliver;
    if (!crossesAny(v, offset)) return sliver;
    sliver.owner = v;
    // A quadric that does not explain its own block does not extend to the next voxel.
    if (v.count() == 1 && v.pieces[0].surface.residual > kSound) return sliver;
    float all = 0;
    // The pieces must leave the voxel full or empty, as it is. For an empty voxel of an
    // intersection and a full voxel of a union, one face suffices; otherwise all must.
    const bool one = (v.rule() == PieceRule::Concave) == (filled > 0);
    bool thin = !one;
    for (int own = 0; own < v.count(); ++own) {
      const SurfacePiece& piece = v.pieces[own];
      const CcSurface& f = piece.surface;
      const bool agrees = ccAbs(ccPredict(&f, offset.data()).volume - filled) < kSliverShare;
      thin = one ? thin || agrees : thin && agrees;
      if (!crosses(piece, offset)) continue;
      const CutPart part = cutPiece(v, own, offset - V3::Constant(0.5f), 1.0f);
      if (part.area == 0) continue;
      all += part.area;
      sliver.part[sliver.pieces] = part;
      sliver.own[sliver.pieces++] = own;
    }
    if (!thin && (v.count() == 1 || all > kEdgeSliver)) sliver.pieces = 0;
    return sliver;
  }

  void assign(const Sliver& sliver, int k, SampleOrigin origin) {
    const int own = sliver.own[k];
    const SurfacePiece& piece = sliver.owner.pieces[own];
    const SurfaceSample more = sampleOf(piece.surface, sliver.part[k], sliver.at.center());
    // A separate sample at an edge. Merged, it would lie too far from the edge, and a wall pressed
    // in by half a voxel would push 2.5 % too little.
    if (sliver.owner.count() > 1 && more.area > kOwnSliver && piece.surface.residual < kSureEdge) {
      origin.brick = sliver.at.brick;
      origin.cell = sliver.at.cell;
      extra_.push_back({more, origin});
      return;
    }
    BrickCut& cut =
        cuts_[static_cast<std::size_t>(slots_[static_cast<std::size_t>(sliver.at.brick)])];
    const SampleRun& run = cut.runs[sliver.owner.step->first + static_cast<std::size_t>(own)];
    SurfaceSample* into = &cut.samples[run.first];
    // Merged into the nearest sample, so that it stays at the edge.
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i)
      if (distance2(cut.samples[i], more) < distance2(*into, more)) into = &cut.samples[i];
    const float share = more.area / (more.area + into->area);
    for (int i = 0; i < 3; ++i) into->position[i] += share * (more.position[i] - into->position[i]);
    into->area += more.area;
  }

  static float distance2(const SurfaceSample& a, const SurfaceSample& b) {
    return (Eigen::Map<const V3>(a.position) - Eigen::Map<const V3>(b.position)).squaredNorm();
  }
  const FieldDraft& draft_;
  const VoxelSet* scope_;
  const VoxelSet* in_ = nullptr;
  const std::vector<std::int32_t>& slots_;
  std::vector<BrickCut>& cuts_;
  std::vector<Candidate> candidates_;
  std::vector<CutSample> extra_;
  BrickGrid<std::uint8_t> seen_;
};

}  // namespace

std::vector<CutSample> cutSamples(FieldDraft& draft, const VoxelSet* scope) {
  const std::vector<std::int32_t> bricks = scope ? scope->bricks() : draft.surfaceBricks();
  std::vector<std::int32_t> slots(draft.bricks().size(), -1);
  std::vector<BrickCut> cuts(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i)
    slots[static_cast<std::size_t>(bricks[i])] = static_cast<std::int32_t>(i);
  const std::size_t atOnce = draft.partsAtOnce(8, bricks.size());
  std::vector<SurfaceBrick*> own(atOnce);
  for (std::size_t first = 0; first < bricks.size(); first += atOnce) {
    const std::size_t count = std::min(atOnce, bricks.size() - first);
    std::atomic<int> made{0};
    for (std::size_t i = 0; i < count; ++i) own[i] = ownBrick(draft, bricks[first + i], scope);
    parallelFor(count, draft.threads, [&](std::size_t i, int) {
      const std::size_t k = first + i;
      if (own[i]) cutBrick(draft, bricks[k], scope, *own[i], cuts[k]);
      made += static_cast<int>(cuts[k].samples.size());
    });
    draft.spend(kSampleCost * made);
  }
  SliverCutter slivers(draft, scope, slots, cuts);
  // A voxel's slivers lie beside it, and the voxels that rank them beside the slivers.
  std::vector<CutSample> extra;
  if (scope) {
    const VoxelSet in = scope->dilated(1), by = scope->dilated(2);
    extra = slivers.run(by.bricks(), &by, &in);
  } else {
    extra = slivers.run(bricks, nullptr, nullptr);
  }
  std::vector<CutSample> samples;
  for (const BrickCut& cut : cuts)
    for (std::size_t i = 0; i < cut.samples.size(); ++i)
      samples.push_back({cut.samples[i], cut.origins[i]});
  samples.insert(samples.end(), extra.begin(), extra.end());
  return samples;
}

}  // namespace cloudcontact
