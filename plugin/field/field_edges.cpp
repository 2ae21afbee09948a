// The passes of the edge search over a field's draft. A pass reads the results of earlier passes
// only, never its own. It may therefore visit voxels in any order, and a renewal may visit few of
// them as long as each sees its neighbors as they were at that pass (VoxelStep).
#include "field/field_edges.h"

#include "base/parallel.h"
#include "field/edge_search.h"
#include "field/field_fit.h"
#include "field/near_faces.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// Blocks that the quadric explains this well keep it: shallow edges, small radii. At 0.004, blocks
// beside an edge keep a bend of 2 deg.
constexpr float kEnough = 0.0025f;
// An edge must explain the block this well, and better than the quadric by this factor. The first
// pass accepts good edges only, so that a corner is not explained by half its faces before its
// neighbors show them all.
constexpr float kEdgeResidual = 0.03f;
constexpr float kEdgeGain = 0.75f;
// A quadric that bends as sharply as this [1/voxel] imitates an edge: on the crest of a thread its
// residual is 0.007 with samples 0.6 voxel off. An edge replaces it if it is about as good.
constexpr float kSharp = 0.15f, kSharpGain = 1.2f;
// One that bends as this may explain an edge well enough by chance: on an edge of a box whose faces
// lie 1/6 or 0.12 into their voxels it leaves 0.002 and is 0.28 voxel off. It is searched in any
// case, and keeps its block where no edge explains it better by kEdgeGain.
constexpr float kDoubtful = 0.2f;
// Above this a voxel counts as unexplained and is retried when its neighbors have improved.
constexpr float kLost = 0.01f;
// What a quadric explains this well is not searched again in a later plain pass: one of fifty such
// searches finds an edge.
constexpr float kRetried[] = {0, 0, 0.0035f, kGoodEdge};
constexpr int kPlainPasses = 3;  // faces found beside an edge serve their neighbors in the next
constexpr int kClimbs = 8;       // at most so many further passes, up a tip
// Where a budget limits the searches, voxels wait until this many renewals have left their
// surroundings alone: what a tool is about to cut again is not searched.
constexpr int kRest = 3;

CcSurface planeSurface(const Face& f, float residual) {
  CcSurface s{};
  for (int i = 0; i < 3; ++i) s.n[i] = f.n[i];
  ccTangents(s.n, s.t1, s.t2);
  s.s = f.s;
  const Eigen::Map<const Eigen::Vector3f> t1(s.t1), t2(s.t2);
  s.k11 = t1.dot(f.curvature * t1);
  s.k12 = t1.dot(f.curvature * t2);
  s.k22 = t2.dot(f.curvature * t2);
  s.residual = residual;
  s.weight = 1;
  return s;
}

// The residual that an edge must beat to replace a voxel's pieces.
float boundOf(const VoxelState& v, float most) {
  const CcSurface& own = v.pieces[0].surface;
  if (v.rule() != PieceRule::Smooth) return own.residual;
  const bool imitates = sharpest(own) > kSharp && own.residual > kEnough;
  return std::min(most, (imitates ? kSharpGain : kEdgeGain) * own.residual);
}

// The first pass accepts only good edges; the last ones climb tips.
struct Pass {
  int number;
  float most;  // largest residual of an accepted edge
  TipsTried tips;

  explicit Pass(int which)
      : number(which),
        most(which == 1 ? kGoodEdge : kEdgeResidual),
        tips(climbs() ? TipsTried::Soon : TipsTried::Last) {}
  bool climbs() const { return number > kPlainPasses; }
};

// An edge that a pass found.
struct Found {
  std::int32_t brick;
  std::int16_t cell;
  Hypothesis edge;
};

bool isCandidate(const VoxelState& v) {
  const CcSurface& own = v.pieces[0].surface;
  if (v.rule() != PieceRule::Smooth) return own.residual > kGoodEdge;
  return own.residual > kEnough || sharpest(own) > kDoubtful;
}

// True if a brick within reach may hold a step of this pass.
bool anyStep(const FieldDraft& draft, const DraftVoxel& at, int pass) {
  for (int k = 0; k < 8; ++k) {
    const auto corner = [&](int v, int side) { return v + (side ? kReach : -kReach); };
    const SurfaceBrick* const b =
        draft.brickOf(corner(at.x, k & 1), corner(at.y, k & 2), corner(at.z, k & 4));
    if (b && b->passes >> pass & 1) return true;
  }
  return false;
}

// True if the previous pass changed a voxel within reach and counts(now, before).
template <typename Counts>
bool besideChange(const FieldDraft& draft, const DraftVoxel& at, int pass, Counts&& counts) {
  if (!anyStep(draft, at, pass - 1)) return false;
  return anyNear(draft, at, [&](const SurfaceBrick& brick, int cell, const Eigen::Vector3f&) {
    const VoxelState now = brick.state(cell, pass);
    return now && now.step->pass == pass - 1 && counts(now, brick.state(cell, pass - 1));
  });
}

// True if the previous pass changed a face that a voxel's search sees.
bool besideNewFace(const FieldDraft& draft, const DraftVoxel& at, int pass) {
  return besideChange(draft, at, pass, [](const VoxelState& now, const VoxelState& before) {
    return shows(now) || shows(before);
  });
}

// True if a pass may find something for a voxel that earlier passes did not. The last plain pass
// searches like the one before it, so it only visits voxels that see another face.
//
// A tip as slender as 8 deg is explained from its base up, a few voxels per pass, since each pass
// needs the faces of the one before. Climbing passes therefore visit voxels beside a good new edge:
// unexplained voxels beside any, nearly explained ones only beside a tip (more than three faces).
// The last voxel of a tip, one percent full, is nearly explained: its quadric leaves 0.008 and ends
// a voxel below the tip.
bool mayFind(const FieldDraft& draft, const DraftVoxel& at, const VoxelState& v, const Pass& pass) {
  if (!isCandidate(v)) return false;
  const float residual = v.pieces[0].surface.residual;
  if (!pass.climbs() && residual <= kRetried[pass.number]) return false;
  if (pass.number < kPlainPasses) return true;
  if (pass.number == kPlainPasses) return besideNewFace(draft, at, pass.number);
  const bool lost = residual > kLost;
  return besideChange(draft, at, pass.number, [lost](const VoxelState& other, const VoxelState&) {
    return other.pieces[0].surface.residual <= kGoodEdge && (lost || other.count() > kFewFaces);
  });
}

// The edge that explains a voxel's block best. For voxels of which mayFind() is true. One that no
// pass would accept may have a larger residual than the best, or none.
Hypothesis edgeNear(const FieldDraft& draft, const DraftVoxel& at, const Pass& pass,
                    EdgeSearch& search) {
  const SurfaceBrick& brick = *draft.brick(static_cast<std::size_t>(at.brick));
  float block[CC_WINDOW_VOXELS];
  gatherBlock(draft.cloud, at.x, at.y, at.z, block);
  const Eigen::Vector3f mean =
      Eigen::Map<const Eigen::Vector3f>(brick.state(at.cell, 1).pieces[0].surface.n);
  // Many faces only for tips: always taking them makes a thread's field 9 % slower.
  const std::size_t faces = pass.climbs() ? kMostAround : kMostNear;
  return search.run(block, facesNear(draft, at, pass.number, faces), mean, pass.tips,
                    boundOf(brick.state(at.cell, pass.number), kEdgeResidual));
}

// The same if it explains the voxel better than its present pieces and well enough for the pass.
// Its count is 0 if there is none.
Hypothesis edgeOf(const FieldDraft& draft, const DraftVoxel& at, const Pass& pass,
                  EdgeSearch& search) {
  const VoxelState own =
      draft.brick(static_cast<std::size_t>(at.brick))->state(at.cell, pass.number);
  const Hypothesis best = edgeNear(draft, at, pass, search);
  return best.residual < boundOf(own, pass.most) ? best : Hypothesis{};
}

// What passes over a brick found.
struct BrickFinds {
  std::vector<Found> now;    // accepted in this pass
  std::vector<Found> later;  // found in the first pass, good enough for the second alone
};

// Where nothing has changed nearby, the second pass would repeat the search of the first.
bool repeats(const FieldDraft& draft, const DraftVoxel& at, const Pass& pass) {
  return pass.number == 2 && !besideNewFace(draft, at, pass.number);
}

void searchBrick(const FieldDraft& draft, const Pass& pass, std::int32_t number, EdgeSearch& search,
                 BrickFinds& finds) {
  const SurfaceBrick& brick = *draft.brick(static_cast<std::size_t>(number));
  std::vector<Found> later;
  later.swap(finds.later);
  finds.now.clear();
  auto known = later.begin();
  for (const SurfaceVoxel& v : brick.voxels) {
    while (known != later.end() && known->cell < v.cell) ++known;
    const DraftVoxel at = draft.voxelAt(number, v.cell);
    const VoxelState own = brick.state(v.cell, pass.number);
    if (!mayFind(draft, at, own, pass)) continue;
    if (repeats(draft, at, pass)) {
      if (known != later.end() && known->cell == v.cell) finds.now.push_back(*known);
      continue;
    }
    const Found found{number, v.cell, edgeNear(draft, at, pass, search)};
    if (found.edge.residual < boundOf(own, pass.most))
      finds.now.push_back(found);
    else if (pass.number == 1 && found.edge.residual < boundOf(own, kEdgeResidual))
      finds.later.push_back(found);
  }
}

// One pass over the surface voxels of these bricks.
void runPass(const FieldDraft& draft, const Pass& pass, const std::vector<std::int32_t>& bricks,
             std::vector<BrickFinds>& finds) {
  const int threads = threadCount(draft.threads);
  std::vector<EdgeSearch> searches(static_cast<std::size_t>(threads));
  parallelFor(bricks.size(), threads, [&](std::size_t i, int worker) {
    searchBrick(draft, pass, bricks[i], searches[static_cast<std::size_t>(worker)], finds[i]);
  });
}

VoxelStep stepOf(const Hypothesis& h, int pass, int earlier) {
  return {0, static_cast<std::int16_t>(earlier), static_cast<std::uint8_t>(h.count),
          static_cast<std::uint8_t>(pass), h.concave ? PieceRule::Concave : PieceRule::Convex};
}

SurfacePiece pieceOf(const Hypothesis& h, int k) {
  return {planeSurface(h.faces[k], h.residual), {0, 0, 0}, 0};
}

// Appends the edge's step and returns its index.
std::int16_t addEdge(SurfaceBrick& brick, int earlier, int pass, const Hypothesis& h) {
  const std::int16_t step = brick.addStep(stepOf(h, pass, earlier));
  SurfacePiece* const pieces = brick.pieces.data() + brick.steps.back().first;
  for (int k = 0; k < h.count; ++k) pieces[k] = pieceOf(h, k);
  return step;
}

// Index of a voxel's first step after a pass; -1: none.
int stepAfter(const SurfaceBrick& brick, int voxel, int pass) {
  int after = -1;
  for (int s = brick.voxels[static_cast<std::size_t>(voxel)].last;
       s >= 0 && brick.steps[static_cast<std::size_t>(s)].pass > pass;
       s = brick.steps[static_cast<std::size_t>(s)].earlier)
    after = s;
  return after;
}

constexpr int kPasses = kPlainPasses + kClimbs;

int bitsOf(int firstPass, int lastPass) {
  return ((1 << (lastPass + 1)) - 1) & ~((1 << firstPass) - 1);
}

// Works through a queue of searches. Its order is fixed, and so is what a budget leaves.
class EdgeRenewal {
 public:
  EdgeRenewal(FieldDraft& draft, EdgeQueue& queue, int most)
      : draft_(draft),
        queue_(queue),
        left_(std::int64_t{most} * kSearch),
        visited_(draft.cloud.bricks()),
        searches_(static_cast<std::size_t>(threadCount(draft.threads))) {}

  // Marks what a cut reaches.
  void mark(const VoxelSet& refitted, const VoxelSet& changed) {
    queue_.nextRenewal();
    int marked = 0;
    const auto add = [&](std::int32_t t, int cell, int, int, int) {
      markFresh(draft_.voxelAt(t, cell));
      ++marked;
    };
    refitted.forEach(add);
    changed.dilated(kReach).forEach(add);
    draft_.spend(kLookCost * marked);
  }

  // Searches until the queue is dry or the budget spent. Returns the voxels searched.
  const VoxelSet& run(int rest) {
    for (;;) {
      if (left_ <= 0) return visited_;
      std::vector<DraftVoxel> next = queue_.waiting(draft_, rest);
      if (next.empty()) return visited_;
      if (rest > 0) chooseFirst(next);
      for (int pass = 1; pass <= kPasses && left_ > 0; ++pass) runPass(next, pass);
    }
  }

  static constexpr int kAll = 1 << 30;  // searches

 private:
  struct Outcome {
    bool tried = false;
    Hypothesis edge;
  };

  void markFresh(const DraftVoxel& v) {
    const VoxelState fit = draft_.at(v.x, v.y, v.z, 1);
    if (fit && isCandidate(fit))
      queue_.addFresh(v, bitsOf(1, kPasses));
    else
      queue_.done(v, bitsOf(0, kPasses));
  }

  // Those that the quadric explains worst come first: they are edges, the others noise.
  void chooseFirst(std::vector<DraftVoxel>& next) const {
    const auto lost = [&](const DraftVoxel& v) {
      return draft_.at(v.x, v.y, v.z, 1).pieces[0].surface.residual > kLost;
    };
    const auto end = std::stable_partition(next.begin(), next.end(), lost);
    if (end != next.begin()) next.erase(end, next.end());
    const std::size_t most = static_cast<std::size_t>(kChosen);
    if (next.size() > most) next.resize(most);
  }

  // Searches the voxels that wait for this pass, as far as the budget goes.
  void runPass(const std::vector<DraftVoxel>& among, int number) {
    const Pass pass(number);
    std::vector<DraftVoxel> next;
    for (const DraftVoxel& v : among)
      if (queue_.passes(v) >> number & 1) next.push_back(v);
    std::vector<Outcome> outcomes(next.size());
    parallelFor(next.size(), draft_.threads, [&](std::size_t i, int) {
      const VoxelState own = draft_.at(next[i].x, next[i].y, next[i].z, number);
      outcomes[i].tried = mayFind(draft_, next[i], own, pass);
    });
    const std::int64_t before = left_;
    std::size_t end = 0;
    for (; end < next.size() && left_ > 0; ++end)
      left_ -= !outcomes[end].tried ? kLook : pass.climbs() ? kTipSearch : kSearch;
    parallelFor(end, draft_.threads, [&](std::size_t i, int worker) {
      if (outcomes[i].tried)
        outcomes[i].edge =
            edgeOf(draft_, next[i], pass, searches_[static_cast<std::size_t>(worker)]);
    });
    draft_.spend(kShareCost * static_cast<double>(before - left_) +
                 kLookCost * static_cast<double>(next.size()));
    for (std::size_t i = 0; i < end; ++i) {
      queue_.done(next[i], 1 << number);
      store(next[i], number, outcomes[i].edge);
    }
  }

  // Makes the edge, or none, what the pass found for a voxel. If it found something else before,
  // marks the later searches that have read it.
  void store(const DraftVoxel& v, int pass, const Hypothesis& edge) {
    const std::size_t t = static_cast<std::size_t>(v.brick);
    const SurfaceBrick& known = *draft_.brick(t);
    const int voxel = known.place[static_cast<std::size_t>(v.cell)];
    const int after = stepAfter(known, voxel, pass), before = known.stepBefore(voxel, pass),
              own = known.stepBefore(voxel, pass + 1);
    if (own == before ? edge.count == 0 : equal(known.stateAt(own), edge)) return;
    SurfaceBrick& brick = draft_.write(t);
    const int now = edge.count > 0 ? addEdge(brick, before, pass, edge) : before;
    if (after >= 0)
      brick.steps[static_cast<std::size_t>(after)].earlier = static_cast<std::int16_t>(now);
    else
      brick.voxels[static_cast<std::size_t>(voxel)].last = static_cast<std::int16_t>(now);
    visited_.add(v.x, v.y, v.z);
    const int last = after >= 0 ? brick.steps[static_cast<std::size_t>(after)].pass : kPasses;
    // A search also reads what the last pass before its own replaced.
    if (pass < last) markReaders(v, bitsOf(pass + 1, std::min(last + 1, kPasses)));
  }

  static bool equal(const VoxelState& a, const Hypothesis& h) {
    const VoxelStep step = stepOf(h, a.step->pass, -1);
    std::array<SurfacePiece, kMostEdgeFaces> pieces;
    for (int k = 0; k < h.count; ++k) pieces[static_cast<std::size_t>(k)] = pieceOf(h, k);
    return same(a, {&step, pieces.data()});
  }

  void markReaders(const DraftVoxel& v, int passes) {
    for (int dz = -kReach; dz <= kReach; ++dz)
      for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx) {
          const int x = v.x + dx, y = v.y + dy, z = v.z + dz;
          const VoxelState fit = draft_.at(x, y, z, 1);
          if (fit && isCandidate(fit)) queue_.add(draft_.voxelAt(x, y, z), passes);
        }
  }

  // Voxels at a time if there is a budget: enough to see the passes in order.
  static constexpr int kChosen = 64;
  // Shares of the budget: a search, one among the faces of a tip, and a look that finds nothing to
  // search.
  static constexpr int kSearch = 32, kTipSearch = 96, kLook = 1;
  // What a share costs, and a look at a voxel's marks [us].
  static constexpr double kShareCost = 1.4, kLookCost = 0.03;

  FieldDraft& draft_;
  EdgeQueue& queue_;
  std::int64_t left_;  // of the budget
  VoxelSet visited_;
  std::vector<EdgeSearch> searches_;
};

}  // namespace

void findEdges(FieldDraft& draft) {
  const std::vector<std::int32_t> bricks = draft.surfaceBricks();
  std::vector<BrickFinds> finds(bricks.size());
  for (int number = 1; number <= kPasses; ++number) {
    runPass(draft, Pass(number), bricks, finds);
    bool any = false;
    for (const BrickFinds& in : finds)
      for (const Found& f : in.now) {
        SurfaceBrick& brick = draft.write(static_cast<std::size_t>(f.brick));
        SurfaceVoxel& voxel =
            brick.voxels[static_cast<std::size_t>(brick.place[static_cast<std::size_t>(f.cell)])];
        voxel.last = addEdge(brick, voxel.last, number, f.edge);
        any = true;
      }
    if (!any && number >= kPlainPasses) return;
  }
}

VoxelSet renewEdges(FieldDraft& draft, EdgeQueue& queue, const SurfaceBricks& before,
                    const VoxelSet& refitted, const VoxelSet& changed, std::optional<int> most) {
  EdgeRenewal renewal(draft, queue, most.value_or(EdgeRenewal::kAll));
  renewal.mark(refitted, changed);
  VoxelSet visited = renewal.run(most ? kRest : 0);
  visited.add(changed);
  VoxelSet different(draft.cloud.bricks());
  visited.forEach([&](std::int32_t t, int cell, int x, int y, int z) {
    const SurfaceBrick* const old = before[static_cast<std::size_t>(t)].get();
    if (!same(old ? old->state(cell) : VoxelState{}, draft.at(x, y, z))) different.add(x, y, z);
  });
  return different;
}

}  // namespace cloudcontact
