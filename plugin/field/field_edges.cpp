// The second step of the field: edges and corners. A window across an edge sees a blunt surface
// (30 deg at half a voxel from a right angle). Where a block's quadric does not explain its
// coverage, the flat or gently curved faces found beside it are continued into the block, and the
// intersection (a convex edge) or union (a concave one) of two or three of them, of four to six at
// a tip, that reproduces the coverage best is kept, if it does so well enough. Where a face is too
// narrow to be seen on its own (the crest of a thin thread), the plane midway between two others is
// tried, put where the mass wants it.
//
// A pass reads what the passes before it found, never its own: so it may go over the voxels in any
// order, and a renewal may go over few of them, as long as each sees its neighbours as they stood
// then (VoxelStep).
#include "base/parallel.h"
#include "field/edge_search.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// Residuals of coverage, see kernels/surface_fit.h: smooth surfaces leave 0.001, at most 0.003 at a
// radius of 10 voxels; an edge of 20 deg leaves 0.006.
constexpr float kSmoothResidual = 0.004f;
// Blocks that the quadric explains this well keep it: shallow edges, small radii. At 0.004 those
// beside an edge kept a bend of 2 deg, and loops over a table's edge did 2.6 % of their work for
// nothing instead of 1.4 %.
constexpr float kEnough = 0.0025f;
// An edge must explain the block this well, and better than the quadric by this factor. At first
// only good ones are taken, so that a corner's tip is not explained by half its faces before its
// neighbours show them all.
constexpr float kEdgeResidual = 0.03f, kGoodEdge = 0.005f;
constexpr float kEdgeGain = 0.75f;
// A quadric that bends as sharply as this [1/voxel] imitates an edge: it explains the crest of a
// thread to 0.007 and puts samples 0.6 voxel off. Against it an edge need only do about as well.
constexpr float kSharp = 0.15f, kSharpGain = 1.2f;
// A quadric beside an edge bends towards it and still explains its block to the bound above: what a
// face says counts by how well it explains its own.
constexpr float kTypical = 0.0005f;
// Above this a voxel counts as unexplained, and is tried again when its neighbours know more.
constexpr float kLost = 0.01f;
constexpr int kPlainPasses = 3;  // faces found beside an edge serve their neighbours in the next
constexpr int kClimbs = 8;       // passes, at most, up a tip
constexpr int kReach = 3;        // faces are sought this far from the block's middle
constexpr float kFlat = 0.012f;  // curvatures below this are noise and are not continued
constexpr float kSameNormal = 0.97f;  // cosine: faces within 14 deg that also meet are one face
constexpr float kSameOffset = 0.25f;

float sharpest(const CcSurface& f) {
  return std::max({std::abs(f.k11), std::abs(f.k12), std::abs(f.k22)});
}

// The neighbour's surface about the block's middle, which lies at `r` from the neighbour's own.
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

// Where a voxel is.
struct Spot {
  std::int32_t brick;
  std::int16_t cell;
  int x, y, z;
};

Spot spotOf(const FieldDraft& draft, std::int32_t brick, int cell) {
  const Eigen::Vector3i low = draft.cornerOf(static_cast<std::size_t>(brick));
  return {brick, static_cast<std::int16_t>(cell), low.x() + (cell & 7), low.y() + (cell >> 3 & 7),
          low.z() + (cell >> 6)};
}

// The distinct faces that a pass finds near a voxel, each the mean of what its neighbours say;
// first those that are near and explain their own blocks well.
std::vector<Face> facesNear(const FieldDraft& draft, const Spot& spot, int pass, std::size_t most) {
  std::vector<Face> all;
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const VoxelState from = draft.at(spot.x + dx, spot.y + dy, spot.z + dz, pass);
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

// What an edge of this residual must beat to be taken for a voxel.
float boundOf(const VoxelState& v, float most) {
  const CcSurface& own = v.pieces[0].surface;
  if (v.rule() != PieceRule::Smooth) return own.residual;
  return std::min(most, (sharpest(own) > kSharp ? kSharpGain : kEdgeGain) * own.residual);
}

// At first only good edges are taken; then tips are climbed.
struct Pass {
  int number;
  float most;  // that an edge may leave
  TipsTried tips;

  explicit Pass(int which)
      : number(which),
        most(which == 1 ? kGoodEdge : kEdgeResidual),
        tips(climbs() ? TipsTried::Soon : TipsTried::Last) {}
  bool climbs() const { return number > kPlainPasses; }
};

// What a pass found.
struct Found {
  std::int32_t brick;
  std::int16_t cell;
  Hypothesis edge;
};

bool worthATry(const VoxelState& v) {
  return v.pieces[0].surface.residual > (v.rule() == PieceRule::Smooth ? kEnough : kGoodEdge);
}

// Whether the last pass changed something within reach that `counts`.
template <typename Counts>
bool besideNews(const FieldDraft& draft, const Spot& spot, int pass, Counts&& counts) {
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const VoxelState other = draft.at(spot.x + dx, spot.y + dy, spot.z + dz, pass);
        if (other && other.step->pass == pass - 1 && counts(other)) return true;
      }
  return false;
}

// Whether a pass may find for a voxel what the ones before did not. The last plain pass asks what
// the one before it asked: nothing new comes of it where nothing is new.
//
// A tip as slender as 8 deg is explained from below, a few voxels of its height a pass: only the
// faces that one found tell the next. So further passes go where the last one found something good:
// any change serves a voxel that nothing explains, what falls a little short is looked at again
// beside a tip (of more faces than three) alone. A tip's last voxel, a hundredth full, is such: its
// quadric leaves 0.008, and ends a voxel from the tip.
bool mayFind(const FieldDraft& draft, const Spot& spot, const VoxelState& v, const Pass& pass) {
  if (!worthATry(v)) return false;
  if (pass.number < kPlainPasses) return true;
  if (pass.number == kPlainPasses)
    return besideNews(draft, spot, pass.number, [](const VoxelState&) { return true; });
  const bool lost = v.pieces[0].surface.residual > kLost;
  return besideNews(draft, spot, pass.number, [lost](const VoxelState& other) {
    return other.pieces[0].surface.residual <= kGoodEdge && (lost || other.count() > kFewFaces);
  });
}

// What explains a voxel better than what it has, and leaves no more than the pass allows; count 0:
// nothing does.
Hypothesis edgeOf(const FieldDraft& draft, const Spot& spot, const Pass& pass, EdgeSearch& search) {
  const SurfaceBrick& brick = *draft.brick(static_cast<std::size_t>(spot.brick));
  const VoxelState own = brick.state(spot.cell, pass.number);
  if (!mayFind(draft, spot, own, pass)) return {};
  float block[CC_WINDOW_VOXELS];
  gatherBlock(draft.cloud, spot.x, spot.y, spot.z, block);
  const Eigen::Vector3f mean =
      Eigen::Map<const Eigen::Vector3f>(brick.state(spot.cell, 1).pieces[0].surface.n);
  // Many faces only where a tip is sought: they cost a thread's field 9 % more if looked at always.
  const std::size_t faces = pass.climbs() ? kMostAround : kMostNear;
  const Hypothesis best =
      search.run(block, facesNear(draft, spot, pass.number, faces), mean, pass.tips);
  return best.residual < boundOf(own, pass.most) ? best : Hypothesis{};
}

// One pass over the surface voxels of these bricks, or those of them in `scope`; in their order.
std::vector<Found> runPass(const FieldDraft& draft, const Pass& pass,
                           const std::vector<std::int32_t>& bricks, const VoxelSet* scope) {
  const int threads = threadCount(draft.settings.threads);
  std::vector<EdgeSearch> searches(static_cast<std::size_t>(threads));
  std::vector<std::vector<Found>> parts(bricks.size());
  parallelFor(bricks.size(), threads, [&](std::size_t i, int worker) {
    EdgeSearch& search = searches[static_cast<std::size_t>(worker)];
    const SurfaceBrick* const brick = draft.brick(static_cast<std::size_t>(bricks[i]));
    if (!brick) return;
    for (const SurfaceVoxel& v : brick->voxels) {
      if (scope && !scope->has(bricks[i], v.cell)) continue;
      const Hypothesis edge = edgeOf(draft, spotOf(draft, bricks[i], v.cell), pass, search);
      if (edge.count > 0) parts[i].push_back({bricks[i], v.cell, edge});
    }
  });
  std::vector<Found> found;
  for (const std::vector<Found>& part : parts) found.insert(found.end(), part.begin(), part.end());
  return found;
}

// The edge becomes the voxel's latest step, after `earlier`.
void take(SurfaceBrick& brick, int voxel, int earlier, int pass, const Hypothesis& h) {
  const std::int16_t step = brick.addStep(
      {0, static_cast<std::int16_t>(earlier), static_cast<std::uint8_t>(h.count),
       static_cast<std::uint8_t>(pass), h.concave ? PieceRule::Concave : PieceRule::Convex});
  SurfacePiece* const pieces = brick.pieces.data() + brick.steps.back().first;
  for (int k = 0; k < h.count; ++k)
    pieces[k] = {planeSurface(h.faces[k], h.residual), {0, 0, 0}, 0};
  brick.voxels[static_cast<std::size_t>(voxel)].last = step;
}

// From this step on, the voxel's later steps are those that it had before the cut.
void takeUp(SurfaceBrick& brick, int voxel, int step, const SurfaceBrick& before, int voxelBefore,
            int pass) {
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

// Writes down what a pass found in its scope. Where a voxel then stands as it stood before the cut,
// its later steps are as they were, unless a later pass comes by again. Returns where one does not.
VoxelSet settle(FieldDraft& draft, const SurfaceBricks& before, const VoxelSet& scope, int pass,
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
      take(brick, voxel, step, pass, next->edge);
      step = brick.voxels[static_cast<std::size_t>(voxel)].last;
      ++next;
    }
    if (voxelBefore < 0 || !same(brick.stateAt(step), old->state(cell, pass + 1)))
      changed.add(x, y, z);
    else
      takeUp(brick, voxel, step, *old, voxelBefore, pass);
  });
  return changed;
}

}  // namespace

void resolveEdges(FieldDraft& draft) {
  const std::vector<std::int32_t> bricks = draft.surfaceBricks();
  for (int number = 1; number <= kPlainPasses + kClimbs; ++number) {
    const std::vector<Found> found = runPass(draft, Pass(number), bricks, nullptr);
    for (const Found& f : found) {
      SurfaceBrick& brick = draft.write(static_cast<std::size_t>(f.brick));
      const int voxel = brick.place[static_cast<std::size_t>(f.cell)];
      take(brick, voxel, brick.voxels[static_cast<std::size_t>(voxel)].last, number, f.edge);
    }
    if (found.empty() && number >= kPlainPasses) return;
  }
}

// Each pass goes over the voxels whose block was cut, and over those that see another that no
// longer is what it was. What a cut changes mostly dies out after a pass or two.
VoxelSet resolveEdgesAgain(FieldDraft& draft, const SurfaceBricks& before, const VoxelSet& refitted,
                           VoxelSet changed) {
  for (int number = 1; number <= kPlainPasses + kClimbs; ++number) {
    VoxelSet scope = changed.dilated(kReach);
    scope.add(refitted);
    const std::vector<Found> found = runPass(draft, Pass(number), scope.bricks(), &scope);
    changed = settle(draft, before, scope, number, found);
  }
  return changed;
}

}  // namespace cloudcontact
