// The passes of the edge search over a field's draft. A pass reads the results of earlier passes
// only, never its own. It may therefore visit voxels in any order, and a renewal may visit few of
// them as long as each sees its neighbors as they were at that pass (VoxelStep).
#include "field/field_edges.h"

#include "base/parallel.h"
#include "field/edge_search.h"
#include "field/field_fit.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// Residuals of coverage (kernels/contact/surface_fit.h): smooth surfaces leave 0.001, or 0.003 at a
// radius of 10 voxels; an edge of 20 deg leaves 0.006.
constexpr float kSmoothResidual = 0.004f;
// Blocks that the quadric explains this well keep it: shallow edges, small radii. At 0.004, blocks
// beside an edge keep a bend of 2 deg.
constexpr float kEnough = 0.0025f;
// An edge must explain the block this well, and better than the quadric by this factor. The first
// pass accepts good edges only, so that a corner is not explained by half its faces before its
// neighbors show them all.
constexpr float kEdgeResidual = 0.03f, kGoodEdge = 0.005f;
constexpr float kEdgeGain = 0.75f;
// A quadric that bends as sharply as this [1/voxel] imitates an edge: on the crest of a thread its
// residual is 0.007 with samples 0.6 voxel off. An edge replaces it if it is about as good.
constexpr float kSharp = 0.15f, kSharpGain = 1.2f;
// A quadric beside an edge bends toward it and still explains its block to the bound above.
// Residuals above this therefore lower a face's weight.
constexpr float kTypical = 0.0005f;
// Above this a voxel counts as unexplained and is retried when its neighbors have improved.
constexpr float kLost = 0.01f;
constexpr int kPlainPasses = 3;  // faces found beside an edge serve their neighbors in the next
constexpr int kClimbs = 8;       // at most so many further passes, up a tip
constexpr int kReach = 3;        // faces are collected this far from the block's center
constexpr float kFlat = 0.012f;  // curvatures below this are noise and are not continued
constexpr float kSameNormal = 0.97f;  // cosine: faces within 14 deg that also coincide are one
constexpr float kSameOffset = 0.25f;

float sharpest(const CcSurface& f) {
  return std::max({std::abs(f.k11), std::abs(f.k12), std::abs(f.k22)});
}

// A neighbor's surface relative to the block's center, which lies at `r` from the neighbor's.
Face continued(const CcSurface& f, const Eigen::Vector3f& r) {
  const Eigen::Map<const Eigen::Vector3f> n(f.n), t1(f.t1), t2(f.t2);
  Face face;
  const float off = f.residual / kTypical;
  face.weight = 1.0f / ((0.5f + r.squaredNorm()) * (1.0f + off * off));
  const bool flat = sharpest(f) < kFlat;
  if (!flat)
    face.curvature = f.k11 * t1 * t1.transpose() + f.k22 * t2 * t2.transpose() +
                     f.k12 * (t1 * t2.transpose() + t2 * t1.transpose());
  const Eigen::Vector3f bent = face.curvature * r, m = n + bent;
  const float length = m.norm();
  face.n = m / length;
  face.s = (f.s - n.dot(r) - 0.5f * r.dot(bent)) / length;
  return face;
}

// The distinct faces near a voxel, as known before a pass. Each is the weighted mean over the
// neighbors that show it; near ones with small residuals come first.
std::vector<Face> facesNear(const FieldDraft& draft, const DraftVoxel& at, int pass,
                            std::size_t most) {
  std::vector<Face> all;
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const VoxelState from = draft.at(at.x + dx, at.y + dy, at.z + dz, pass);
        if (!from) continue;
        for (int k = 0; k < from.count(); ++k) {
          const CcSurface& f = from.pieces[k].surface;
          if (f.residual > (from.rule() == PieceRule::Smooth ? kSmoothResidual : kGoodEdge))
            continue;
          all.push_back(continued(f, {float(-dx), float(-dy), float(-dz)}));
        }
      }
  std::stable_sort(all.begin(), all.end(),
                   [](const Face& a, const Face& b) { return a.weight > b.weight; });
  std::vector<Face> faces, sums;
  for (const Face& f : all) {
    std::size_t k = 0;
    while (k < faces.size() &&
           !(faces[k].n.dot(f.n) > kSameNormal && std::abs(faces[k].s - f.s) < kSameOffset))
      ++k;
    if (k == faces.size()) {
      if (k == most) continue;
      faces.push_back(f);
      sums.emplace_back();
    }
    sums[k].n += f.weight * f.n;
    sums[k].s += f.weight * f.s;
    sums[k].curvature += f.weight * f.curvature;
    sums[k].weight += f.weight;
  }
  for (Face& f : sums) {
    f.s /= f.weight;
    f.curvature /= f.weight;
    if (f.curvature.cwiseAbs().maxCoeff() < kFlat) f.curvature.setZero();
    f.n.normalize();
  }
  return sums;
}

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
  return std::min(most, (sharpest(own) > kSharp ? kSharpGain : kEdgeGain) * own.residual);
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
  return v.pieces[0].surface.residual > (v.rule() == PieceRule::Smooth ? kEnough : kGoodEdge);
}

// True if the previous pass changed a voxel within reach that satisfies `counts`.
template <typename Counts>
bool besideChange(const FieldDraft& draft, const DraftVoxel& at, int pass, Counts&& counts) {
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const VoxelState other = draft.at(at.x + dx, at.y + dy, at.z + dz, pass);
        if (other && other.step->pass == pass - 1 && counts(other)) return true;
      }
  return false;
}

// True if a pass may find something for a voxel that earlier passes did not. The last plain pass
// searches like the one before it, so it only visits voxels beside a change.
//
// A tip as slender as 8 deg is explained from its base up, a few voxels per pass, since each pass
// needs the faces of the one before. Climbing passes therefore visit voxels beside a good new edge:
// unexplained voxels beside any, nearly explained ones only beside a tip (more than three faces).
// The last voxel of a tip, one percent full, is nearly explained: its quadric leaves 0.008 and ends
// a voxel below the tip.
bool mayFind(const FieldDraft& draft, const DraftVoxel& at, const VoxelState& v, const Pass& pass) {
  if (!isCandidate(v)) return false;
  if (pass.number < kPlainPasses) return true;
  if (pass.number == kPlainPasses)
    return besideChange(draft, at, pass.number, [](const VoxelState&) { return true; });
  const bool lost = v.pieces[0].surface.residual > kLost;
  return besideChange(draft, at, pass.number, [lost](const VoxelState& other) {
    return other.pieces[0].surface.residual <= kGoodEdge && (lost || other.count() > kFewFaces);
  });
}

// An edge that explains a voxel better than its present pieces and well enough for the pass. Its
// count is 0 if there is none.
Hypothesis edgeOf(const FieldDraft& draft, const DraftVoxel& at, const Pass& pass,
                  EdgeSearch& search) {
  const SurfaceBrick& brick = *draft.brick(static_cast<std::size_t>(at.brick));
  const VoxelState own = brick.state(at.cell, pass.number);
  if (!mayFind(draft, at, own, pass)) return {};
  float block[CC_WINDOW_VOXELS];
  gatherBlock(draft.cloud, at.x, at.y, at.z, block);
  const Eigen::Vector3f mean =
      Eigen::Map<const Eigen::Vector3f>(brick.state(at.cell, 1).pieces[0].surface.n);
  // Many faces only for tips: always taking them makes a thread's field 9 % slower.
  const std::size_t faces = pass.climbs() ? kMostAround : kMostNear;
  const Hypothesis best =
      search.run(block, facesNear(draft, at, pass.number, faces), mean, pass.tips);
  return best.residual < boundOf(own, pass.most) ? best : Hypothesis{};
}

// One pass over the surface voxels of these bricks, or those in `scope`. Results in that order.
std::vector<Found> runPass(const FieldDraft& draft, const Pass& pass,
                           const std::vector<std::int32_t>& bricks, const VoxelSet* scope) {
  const int threads = threadCount(draft.threads);
  std::vector<EdgeSearch> searches(static_cast<std::size_t>(threads));
  std::vector<std::vector<Found>> parts(bricks.size());
  parallelFor(bricks.size(), threads, [&](std::size_t i, int worker) {
    EdgeSearch& search = searches[static_cast<std::size_t>(worker)];
    const SurfaceBrick* const brick = draft.brick(static_cast<std::size_t>(bricks[i]));
    if (!brick) return;
    for (const SurfaceVoxel& v : brick->voxels) {
      if (scope && !scope->has(bricks[i], v.cell)) continue;
      const Hypothesis edge = edgeOf(draft, draft.voxelAt(bricks[i], v.cell), pass, search);
      if (edge.count > 0) parts[i].push_back({bricks[i], v.cell, edge});
    }
  });
  std::vector<Found> found;
  for (const std::vector<Found>& part : parts) found.insert(found.end(), part.begin(), part.end());
  return found;
}

// Makes the edge the voxel's latest step, after `earlier`.
void addEdge(SurfaceBrick& brick, int voxel, int earlier, int pass, const Hypothesis& h) {
  const std::int16_t step = brick.addStep(
      {0, static_cast<std::int16_t>(earlier), static_cast<std::uint8_t>(h.count),
       static_cast<std::uint8_t>(pass), h.concave ? PieceRule::Concave : PieceRule::Convex});
  SurfacePiece* const pieces = brick.pieces.data() + brick.steps.back().first;
  for (int k = 0; k < h.count; ++k)
    pieces[k] = {planeSurface(h.faces[k], h.residual), {0, 0, 0}, 0};
  brick.voxels[static_cast<std::size_t>(voxel)].last = step;
}

// Appends the later steps that the voxel had before the cut.
void restoreLater(SurfaceBrick& brick, int voxel, int step, const SurfaceBrick& before,
                  int voxelBefore, int pass) {
  const std::int16_t last = before.voxels[static_cast<std::size_t>(voxelBefore)].last;
  brick.voxels[static_cast<std::size_t>(voxel)].last = static_cast<std::int16_t>(step);
  if (before.steps[static_cast<std::size_t>(last)].pass <= pass) return;
  int first = last;
  for (int earlier = before.steps[static_cast<std::size_t>(first)].earlier;
       earlier >= 0 && before.steps[static_cast<std::size_t>(earlier)].pass > pass;
       earlier = before.steps[static_cast<std::size_t>(first)].earlier)
    first = earlier;
  brick.steps[static_cast<std::size_t>(first)].earlier = static_cast<std::int16_t>(step);
  brick.voxels[static_cast<std::size_t>(voxel)].last = last;
}

// Stores the results of a pass in its scope. A voxel that then equals its state before the cut gets
// its old later steps back, which hold unless a later pass visits it again. Returns the other
// voxels.
VoxelSet storePass(FieldDraft& draft, const SurfaceBricks& before, const VoxelSet& scope, int pass,
                   const std::vector<Found>& found) {
  VoxelSet changed(draft.cloud.bricks());
  auto next = found.begin();
  scope.forEach([&](std::int32_t t, int cell, int x, int y, int z) {
    const std::size_t b = static_cast<std::size_t>(t);
    const SurfaceBrick* const old = before[b].get();
    const int voxelBefore = old ? old->place[static_cast<std::size_t>(cell)] : -1;
    const int voxel = draft.brick(b) ? draft.brick(b)->place[static_cast<std::size_t>(cell)] : -1;
    if (voxel < 0) {
      if (voxelBefore >= 0) changed.add(x, y, z);
      return;
    }
    SurfaceBrick& brick = draft.write(b);
    int step = brick.stepBefore(voxel, pass);
    brick.voxels[static_cast<std::size_t>(voxel)].last = static_cast<std::int16_t>(step);
    if (next != found.end() && next->brick == t && next->cell == cell) {
      addEdge(brick, voxel, step, pass, next->edge);
      step = brick.voxels[static_cast<std::size_t>(voxel)].last;
      ++next;
    }
    if (voxelBefore < 0 || !same(brick.stateAt(step), old->state(cell, pass + 1)))
      changed.add(x, y, z);
    else
      restoreLater(brick, voxel, step, *old, voxelBefore, pass);
  });
  return changed;
}

}  // namespace

void findEdges(FieldDraft& draft) {
  const std::vector<std::int32_t> bricks = draft.surfaceBricks();
  for (int number = 1; number <= kPlainPasses + kClimbs; ++number) {
    const std::vector<Found> found = runPass(draft, Pass(number), bricks, nullptr);
    for (const Found& f : found) {
      SurfaceBrick& brick = draft.write(static_cast<std::size_t>(f.brick));
      const int voxel = brick.place[static_cast<std::size_t>(f.cell)];
      addEdge(brick, voxel, brick.voxels[static_cast<std::size_t>(voxel)].last, number, f.edge);
    }
    if (found.empty() && number >= kPlainPasses) return;
  }
}

// Each pass visits the voxels whose block was cut and those within reach of a changed one. Changes
// mostly die out after a pass or two.
VoxelSet renewEdges(FieldDraft& draft, const SurfaceBricks& before, const VoxelSet& refitted,
                    VoxelSet changed) {
  for (int number = 1; number <= kPlainPasses + kClimbs; ++number) {
    VoxelSet scope = changed.dilated(kReach);
    scope.add(refitted);
    const std::vector<Found> found = runPass(draft, Pass(number), scope.bricks(), &scope);
    changed = storePass(draft, before, scope, number, found);
  }
  return changed;
}

}  // namespace cloudcontact
