// The second step of the field: edges and corners. A window across an edge sees a blunt surface
// (30 deg at half a voxel from a right angle). Where a block's quadric does not explain its
// coverage, the flat or gently curved faces found beside it are continued into the block, and the
// intersection (a convex edge) or union (a concave one) of two or three of them, of four to six at
// a tip, that reproduces the coverage best is kept, if it does so well enough. Where a face is too
// narrow to be seen on its own (the crest of a thin thread), the plane midway between two others is
// tried, put where the mass wants it.
#include "../geometry/parallel.h"
#include "edge_search.h"

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
constexpr int kClimbs = 8;            // passes, at most, up a tip
constexpr int kReach = 3;             // faces are sought this far from the block's middle
constexpr float kFlat = 0.012f;       // curvatures below this are noise and are not continued
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

// The distinct faces near a voxel, each the mean of what its neighbours say; first those that are
// near and explain their own blocks well.
std::vector<Face> facesNear(const FieldDraft& draft, const SurfaceVoxel& voxel, std::size_t most) {
  std::vector<Face> all;
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const std::int32_t other = draft.index.at(voxel.x + dx, voxel.y + dy, voxel.z + dz);
        if (other < 0) continue;
        const SurfaceVoxel& from = draft.voxels[static_cast<std::size_t>(other)];
        for (std::uint32_t k = 0; k < from.count; ++k) {
          const CcSurface& f = draft.pieces[from.first + k].surface;
          if (f.residual > (from.rule == PieceRule::Smooth ? kSmoothResidual : kGoodEdge)) continue;
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
float boundOf(const SurfaceVoxel& v, const CcSurface& own, float most) {
  if (v.rule != PieceRule::Smooth) return own.residual;
  return std::min(most, (sharpest(own) > kSharp ? kSharpGain : kEdgeGain) * own.residual);
}

struct Pass {
  float most;  // that an edge may leave
  TipsTried tips = TipsTried::Last;
};

// What a pass found: voxels by their place in the draft, in rising order.
struct Found {
  std::size_t voxel;
  Hypothesis edge;
};

bool worthATry(const FieldDraft& draft, const SurfaceVoxel& v) {
  return draft.pieces[v.first].surface.residual >
         (v.rule == PieceRule::Smooth ? kEnough : kGoodEdge);
}

// What explains a voxel better than what it has, and leaves at most `most`; count 0: nothing does.
Hypothesis edgeOf(const FieldDraft& draft, const SurfaceVoxel& v, const Pass& pass,
                  EdgeSearch& search) {
  float block[CC_WINDOW_VOXELS];
  gatherBlock(draft.cloud, v.x, v.y, v.z, block);
  const Eigen::Vector3f mean = Eigen::Map<const Eigen::Vector3f>(draft.pieces[v.quadric].surface.n);
  // Many faces only where a tip is sought: they cost a thread's field 9 % more if looked at always.
  const std::size_t faces = pass.tips == TipsTried::Soon ? kMostAround : kMostNear;
  const Hypothesis best = search.run(block, facesNear(draft, v, faces), mean, pass.tips);
  return best.residual < boundOf(v, draft.pieces[v.first].surface, pass.most) ? best : Hypothesis{};
}

// One pass over the voxels for which `wanted` holds.
template <typename Wanted>
std::vector<Found> resolvePass(FieldDraft& draft, const Pass& pass, Wanted&& wanted) {
  const int threads = threadCount(draft.settings.threads);
  std::vector<EdgeSearch> searches(static_cast<std::size_t>(threads));
  std::vector<std::vector<Found>> parts((draft.voxels.size() + 255) / 256);
  parallelFor(parts.size(), threads, [&](std::size_t chunk, int worker) {
    EdgeSearch& search = searches[static_cast<std::size_t>(worker)];
    const std::size_t end = std::min(draft.voxels.size(), (chunk + 1) * 256);
    for (std::size_t i = chunk * 256; i < end; ++i) {
      if (!wanted(draft.voxels[i])) continue;
      const Hypothesis edge = edgeOf(draft, draft.voxels[i], pass, search);
      if (edge.count > 0) parts[chunk].push_back({i, edge});
    }
  });
  std::vector<Found> found;
  for (const std::vector<Found>& part : parts) found.insert(found.end(), part.begin(), part.end());
  for (const auto& [i, h] : found) {
    SurfaceVoxel& v = draft.voxels[i];
    v.rule = h.concave ? PieceRule::Concave : PieceRule::Convex;
    v.first = static_cast<std::uint32_t>(draft.pieces.size());
    v.count = static_cast<std::uint32_t>(h.count);
    for (int k = 0; k < h.count; ++k)
      draft.pieces.push_back({planeSurface(h.faces[k], h.residual), {0, 0, 0}, 0});
  }
  return found;
}

// Where the last pass found good edges, and of more faces than three.
class Changes {
 public:
  explicit Changes(const FieldDraft& draft) : draft_(draft), seen_(draft.cloud.bricks(), 0) {}

  void add(int pass, const std::vector<Found>& found) {
    for (const Found& f : found) {
      const SurfaceVoxel& v = draft_.voxels[f.voxel];
      if (f.edge.residual <= kGoodEdge)
        seen_.make(v.x, v.y, v.z) =
            static_cast<std::uint8_t>(2 * pass + (f.edge.count > kFewFaces ? 1 : 0));
    }
    least_ = static_cast<std::uint8_t>(2 * pass);
  }

  // True where the voxel may be explained better by what they say: any change serves one that
  // nothing explains, what falls a little short is looked at again beside a tip alone. A tip's last
  // voxel, a hundredth full, is such: its quadric leaves 0.008, and ends a voxel from the tip.
  bool concern(const SurfaceVoxel& v) const {
    const float residual = draft_.pieces[v.first].surface.residual;
    const bool lost = residual > kLost;
    if (!worthATry(draft_, v)) return false;
    for (int dz = -kReach; dz <= kReach; ++dz)
      for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx)
          if (seen_.at(v.x + dx, v.y + dy, v.z + dz) >= least_ + (lost ? 0 : 1)) return true;
    return false;
  }

 private:
  const FieldDraft& draft_;
  BrickGrid<std::uint8_t> seen_;
  std::uint8_t least_ = 0;
};

// A tip as slender as 8 deg is explained from below, a few voxels of its height a pass: only the
// faces that one found tell the next. So further passes go where the last one found something.
void climbTips(FieldDraft& draft, std::vector<Found> last) {
  Changes changes(draft);
  for (int pass = 1; pass <= kClimbs && !last.empty(); ++pass) {
    changes.add(pass, last);
    last = resolvePass(draft, {kEdgeResidual, TipsTried::Soon},
                       [&changes](const SurfaceVoxel& v) { return changes.concern(v); });
  }
}

}  // namespace

// Three times: faces that a pass found beside an edge serve their neighbours in the next.
void resolveEdges(FieldDraft& draft) {
  const auto bad = [&draft](const SurfaceVoxel& v) { return worthATry(draft, v); };
  resolvePass(draft, {kGoodEdge}, bad);
  resolvePass(draft, {kEdgeResidual}, bad);
  climbTips(draft, resolvePass(draft, {kEdgeResidual}, bad));
}

}  // namespace cloudcontact
