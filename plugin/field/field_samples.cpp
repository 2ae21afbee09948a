// The third step of the field: samples. Each piece of surface inside a voxel becomes a quadrature
// point at its centroid with its area, so that sums over samples integrate linear functions over
// flat faces exactly. A piece that lies in the face between two voxels must be counted once: the
// plane is cut at four offsets within an eighth of a voxel about its place and the areas
// averaged, so that each voxel has half of it however the fits' noise falls.
#include "base/parallel.h"
#include "field/field_builder.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

constexpr int kJitters = 4;
constexpr float kJitter[kJitters] = {-0.09375f, -0.03125f, 0.03125f, 0.09375f};
constexpr float kLeastArea =
    1e-3f;                          // [voxel^2] smaller pieces are dropped: 0.1 % of a voxel's face
constexpr float kSliver = 0.004f;   // of a voxel: what coverage in 1/255 rounds away, and its noise
constexpr float kSound = 0.004f;    // residual of a quadric that may give to its neighbours
constexpr float kSureEdge = 0.01f;  // residual of an edge whose slivers are worth their own samples
constexpr float kOwnSliver =
    0.01f;  // [voxel^2] a smaller one is lumped with its neighbour after all
constexpr float kEdgeSliver = 0.12f;  // [voxel^2] surface of an edge or corner in such a voxel
constexpr float kSmallest = 0.5f;     // edge of the smallest box that a piece is cut into
// The same at a tip of more than three faces, where pieces are slivers that run to the tip: in
// halves the last one's middle lies 0.33 voxel from the tip, and a spike was felt that late.
constexpr float kSmallestAtTip = 0.25f;

// A convex polygon of at most 16 corners.
struct Polygon {
  V3 corner[16];
  int count = 0;

  // Keeps what lies below the plane n.x < s.
  void clip(const V3& n, float s) {
    clipWhere([&](const V3& x) { return n.dot(x) - s; });
  }
  // Keeps what lies between low and high along an axis.
  void clip(int axis, float low, float high) {
    clipWhere([&](const V3& x) { return x[axis] - high; });
    clipWhere([&](const V3& x) { return low - x[axis]; });
  }

  // Keeps where beyond() is negative.
  template <typename Beyond>
  void clipWhere(Beyond&& beyond) {
    float far[16], most = -1;
    for (int i = 0; i < count; ++i) most = std::max(most, far[i] = beyond(corner[i]));
    if (most <= 0) return;
    V3 kept[16];
    int keep = 0;
    for (int i = 0; i < count; ++i) {
      const int next = i + 1 < count ? i + 1 : 0;
      const V3 &a = corner[i], &b = corner[next];
      const float da = far[i], db = far[next];
      if (da <= 0 && keep < 16) kept[keep++] = a;
      if ((da < 0 && db > 0) || (da > 0 && db < 0))
        if (keep < 16) kept[keep++] = a + (b - a) * (da / (da - db));
    }
    std::copy(kept, kept + keep, corner);
    count = keep;
  }

  // Adds area, area times centroid, and the integral of the squared distance from `n`'s line.
  void moments(const V3& n, float& area, V3& first, float& second) const {
    for (int i = 2; i < count; ++i) {
      const V3 &p = corner[0], &q = corner[i - 1], &r = corner[i];
      const float a = 0.5f * (q - p).cross(r - p).norm();
      const V3 sum = p + q + r;
      area += a;
      first += a * sum / 3;
      const auto square = [&n](const V3& v) { return v.squaredNorm() - n.dot(v) * n.dot(v); };
      second += a * (square(p) + square(q) + square(r) + square(sum)) / 12;
    }
  }
};

Polygon squareOn(const CcSurface& f, float offset) {
  const Eigen::Map<const V3> n(f.n), t1(f.t1), t2(f.t2);
  const V3 middle = n * (f.s + offset);
  Polygon p;
  p.count = 4;
  p.corner[0] = middle + 2 * t1 + 2 * t2;
  p.corner[1] = middle - 2 * t1 + 2 * t2;
  p.corner[2] = middle - 2 * t1 - 2 * t2;
  p.corner[3] = middle + 2 * t1 - 2 * t2;
  return p;
}

// The part of a piece inside a box.
struct CutPart {
  float area = 0;
  V3 centroid = V3::Zero();
  // Edge of the square that spreads as far (two voxels may share it), at most twice the way to the
  // nearest edge.
  float width = 0;
  bool met = false;  // another piece bounds it there
};

// How far a point of piece `own` lies from the nearest edge of the voxel, along the piece.
float toEdge(const VoxelState& v, int own, const V3& x) {
  const Eigen::Map<const V3> n(v.pieces[own].surface.n);
  float nearest = 1e9f;
  for (int k = 0; k < v.count(); ++k) {
    if (k == own) continue;
    const CcSurface& other = v.pieces[k].surface;
    const Eigen::Map<const V3> m(other.n);
    const float along = (m - n.dot(m) * n).norm();
    if (along > 1e-3f) nearest = std::min(nearest, std::abs(other.s - m.dot(x)) / along);
  }
  return nearest;
}

// The part of piece `own` inside the box of that edge, bounded by the voxel's other pieces.
CutPart cutPiece(const VoxelState& v, int own, const V3& low, float edge) {
  const CcSurface& f = v.pieces[own].surface;
  const Eigen::Map<const V3> n(f.n);
  const float off = n.dot(low + V3::Constant(0.5f * edge)) - f.s;
  if (std::abs(off) > 0.5f * edge * n.lpNorm<1>() + kJitter[kJitters - 1]) return {};
  float area = 0, second = 0, alone = 0, unused = 0;
  V3 first = V3::Zero(), nowhere = V3::Zero();
  for (float jitter : kJitter) {
    Polygon p = squareOn(f, jitter);
    for (int axis = 0; axis < 3; ++axis) p.clip(axis, low[axis], low[axis] + edge);
    if (v.count() > 1) p.moments(n, alone, nowhere, unused);
    for (int k = 0; k < v.count(); ++k) {
      if (k == own) continue;
      const CcSurface& other = v.pieces[k].surface;
      const Eigen::Map<const V3> m(other.n);
      const float sign = v.rule() == PieceRule::Concave ? -1.0f : 1.0f;
      p.clip(sign * m, sign * other.s);
    }
    p.moments(n, area, first, second);
  }
  if (area < kJitters * kLeastArea * edge * edge) return {};
  CutPart part{area / kJitters, first / area, 0, area < 0.999f * alone};
  const float across = n.dot(part.centroid);
  const float spread = second / area - part.centroid.squaredNorm() + across * across;
  part.width = std::sqrt(6 * std::max(spread, 0.0f));
  part.centroid += n * (f.s - n.dot(part.centroid));
  if (part.met) part.width = std::min(part.width, 2 * toEdge(v, own, part.centroid));
  return part;
}

// Where the curved surface runs over the piece: the mean over its own width, and the normal there.
SurfaceSample onSurface(const CcSurface& f, const CutPart& part, const V3& middle) {
  const Eigen::Map<const V3> n(f.n), t1(f.t1), t2(f.t2);
  const V3& flat = part.centroid;
  const float u = t1.dot(flat), v = t2.dot(flat), spread = part.width * part.width / 12;
  const float ku = f.k11 * u + f.k12 * v, kv = f.k12 * u + f.k22 * v;
  const float drop = 0.5f * (ku * u + kv * v + spread * (f.k11 + f.k22));
  const V3 at = middle + flat - drop * n, normal = (n + ku * t1 + kv * t2).normalized();
  SurfaceSample s;
  for (int i = 0; i < 3; ++i) {
    s.position[i] = at[i];
    s.normal[i] = normal[i];
  }
  s.area = part.area;
  s.width = part.width;
  return s;
}

// Where a voxel is: in its brick, and in the grid.
struct Spot {
  std::int32_t brick;
  std::int16_t cell;
  int x, y, z;

  V3 middle() const { return V3(float(x) + 0.5f, float(y) + 0.5f, float(z) + 0.5f); }
};

Spot spotOf(const FieldDraft& draft, std::int32_t brick, std::int16_t cell) {
  const Eigen::Vector3i low = draft.cornerOf(static_cast<std::size_t>(brick));
  return {brick, cell, low.x() + (cell & 7), low.y() + (cell >> 3 & 7), low.z() + (cell >> 6)};
}

// Calls visit(spot, state) for the surface voxels of a brick, or those of them in `of`.
template <typename Visit>
void forEachVoxel(const FieldDraft& draft, std::int32_t brick, const VoxelSet* of, Visit&& visit) {
  const SurfaceBrick* const b = draft.brick(static_cast<std::size_t>(brick));
  if (!b) return;
  for (const SurfaceVoxel& v : b->voxels)
    if (!of || of->has(brick, v.cell)) visit(spotOf(draft, brick, v.cell), b->stateAt(v.last));
}

// Whether an edge runs through the voxel or one beside it, and the voxel's own surface is a good
// fit: where it is not, finer samples would only tell its faults in more detail. Samples there are
// half a voxel wide: wider ones a voxel off reach under a wall's edge by their width alone, and a
// loop over a table's edge did up to 1.3 % of its work for nothing (0.3 % now).
bool besideEdge(const FieldDraft& draft, const Spot& at, const VoxelState& v) {
  if (v.pieces[0].surface.residual > kSureEdge) return false;
  for (int k = 0; k < 27; ++k) {
    const VoxelState other = draft.at(at.x + k % 3 - 1, at.y + k / 3 % 3 - 1, at.z + k / 9 - 1);
    if (other && other.count() > 1) return true;
  }
  return false;
}

// Samples of a piece inside a box: one, or, where it ends there at another or they shall be `fine`,
// those of the box's octants, so that samples are small beside an edge and nowhere else.
void cutBox(const V3& middle, const VoxelState& v, int own, const V3& low, float edge, bool fine,
            std::vector<SurfaceSample>& samples) {
  const CutPart part = cutPiece(v, own, low, edge);
  if (part.area == 0) return;
  if ((!part.met && !fine) || edge < 1.5f * (v.count() > 3 ? kSmallestAtTip : kSmallest)) {
    samples.push_back(onSurface(v.pieces[own].surface, part, middle));
    return;
  }
  const float half = 0.5f * edge;
  for (int k = 0; k < 8; ++k)
    cutBox(middle, v, own, low + half * V3(float(k & 1), float(k >> 1 & 1), float(k >> 2)), half,
           fine, samples);
}

// What a piece came to: where its samples lie, its area and its middle.
struct Run {
  std::uint32_t first = 0, count = 0;
};

Run cutOnePiece(const V3& middle, const VoxelState& v, int own, bool fine,
                std::vector<SurfaceSample>& samples, SurfacePiece& piece) {
  const std::size_t begin = samples.size();
  cutBox(middle, v, own, V3::Constant(-0.5f), 1.0f, fine, samples);
  float area = 0;
  V3 sum = V3::Zero();
  for (std::size_t i = begin; i < samples.size(); ++i) {
    area += samples[i].area;
    sum += samples[i].area * Eigen::Map<const V3>(samples[i].position);
  }
  // A plane without a piece of its own still stands somewhere: at its point nearest the voxel.
  const Eigen::Map<const V3> n(v.pieces[own].surface.n);
  const V3 at = area > 0 ? V3(sum / area) : V3(middle + n * v.pieces[own].surface.s);
  piece.area = area;
  for (int i = 0; i < 3; ++i) piece.centroid[i] = at[i];
  return {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(samples.size() - begin)};
}

// A brick's samples; `runs` by its pieces.
struct BrickCut {
  std::vector<SurfaceSample> samples;
  std::vector<SampleOrigin> origins;
  std::vector<Run> runs;
};

void cutBrick(FieldDraft& draft, std::int32_t t, const VoxelSet* of, BrickCut& cut) {
  SurfaceBrick& brick = draft.write(static_cast<std::size_t>(t));
  cut.runs.resize(brick.pieces.size());
  forEachVoxel(draft, t, of, [&](const Spot& at, const VoxelState& v) {
    const bool fine = besideEdge(draft, at, v);
    const std::size_t begin = cut.samples.size();
    for (int own = 0; own < v.count(); ++own) {
      const std::size_t piece = v.step->first + static_cast<std::size_t>(own);
      cut.runs[piece] = cutOnePiece(at.middle(), v, own, fine, cut.samples, brick.pieces[piece]);
    }
    for (std::size_t i = begin; i < cut.samples.size(); ++i)
      cut.origins.push_back(SampleOrigin::ofVoxel(t, at.cell, static_cast<int>(i - begin)));
  });
}

// Slivers. A voxel of which the surface cuts off less than 1/510 counts as full or empty and has no
// pieces, but the sheets through such corners are 1.3 % of an oblique surface; an edge reaches 0.05
// voxel into such a voxel (a wall pressed in by half a voxel would push 20 % too little), a corner
// 0.23. Each such voxel beside the surface is given to the neighbour whose surface runs nearest to
// it; the pieces inside it become samples of their own at an edge, and are added to that
// neighbour's samples elsewhere.
class SliverCutter {
 public:
  // `of`: the voxels whose samples were cut, null: all; `slots`: brick -> its entry in `cuts`.
  SliverCutter(const FieldDraft& draft, const VoxelSet* of, const std::vector<std::int32_t>& slots,
               std::vector<BrickCut>& cuts)
      : draft_(draft), of_(of), slots_(slots), cuts_(cuts), seen_(draft.cloud.bricks(), 0) {}

  // Goes by the surface voxels of these bricks, or those of them in `by`, in their order: a
  // sliver's place in the order is that of the first that sees it, and so the same however few are
  // looked at. Only slivers in `in`, if given.
  std::vector<CutSample> run(const std::vector<std::int32_t>& bricks, const VoxelSet* by,
                             const VoxelSet* in) {
    in_ = in;
    for (const std::int32_t t : bricks)
      forEachVoxel(draft_, t, by, [&](const Spot& at, const VoxelState&) {
        for (int k = 0; k < 27; ++k)
          see(at, k, at.x + k % 3 - 1, at.y + k / 3 % 3 - 1, at.z + k / 9 - 1);
      });
    // Found side by side, a part of them at a time lest they take much memory, given in order.
    std::vector<Sliver> found;
    for (std::size_t first = 0; first < candidates_.size(); first += kAtOnce) {
      found.resize(std::min(kAtOnce, candidates_.size() - first));
      parallelFor((found.size() + kTask - 1) / kTask, draft_.settings.threads,
                  [&](std::size_t task, int) {
                    const std::size_t end = std::min(found.size(), (task + 1) * kTask);
                    for (std::size_t i = task * kTask; i < end; ++i)
                      found[i] = find(candidates_[first + i]);
                  });
      for (std::size_t i = 0; i < found.size(); ++i) give(candidates_[first + i], found[i]);
    }
    return std::move(extra_);
  }

 private:
  struct Sliver {
    Spot at{};
    VoxelState owner;
    int pieces = 0;
    int own[CC_MAX_PLANES] = {};
    CutPart part[CC_MAX_PLANES];
  };

  // A voxel that may be a sliver, and the surface voxel that first sees it, on which side of it.
  struct Candidate {
    std::int32_t brick;
    std::int16_t cell, side;
    int x, y, z;
  };
  static constexpr std::size_t kAtOnce = 8192, kTask = 64;

  void see(const Spot& from, int k, int x, int y, int z) {
    if (!seen_.contains(x, y, z) || draft_.at(x, y, z) || (in_ && !in_->has(x, y, z))) return;
    std::uint8_t& seen = seen_.make(x, y, z);
    if (seen) return;
    seen = 1;
    candidates_.push_back({from.brick, from.cell, static_cast<std::int16_t>(k), x, y, z});
  }

  void give(const Candidate& c, const Sliver& sliver) {
    if (sliver.pieces == 0 || (of_ && !of_->has(sliver.at.brick, sliver.at.cell))) return;
    for (int i = 0; i < sliver.pieces; ++i)
      give(sliver, i, SampleOrigin::ofSliver(c.brick, c.cell, 8 * c.side + sliver.own[i]));
  }

  Sliver find(const Candidate& c) const {
    const int x = c.x, y = c.y, z = c.z;
    const float wanted = draft_.cloud.coverage(x, y, z) > 127 ? 1.0f : 0.0f;
    Sliver best;
    float nearest = 4;  // squared distance to the owner's middle [voxel^2]
    for (int k = 0; k < 27; ++k) {
      const int u = x + k % 3 - 1, v = y + k / 3 % 3 - 1, w = z + k / 9 - 1;
      const VoxelState other = draft_.at(u, v, w);
      if (!other) continue;
      const V3 offset(float(x - u), float(y - v), float(z - w));
      if (offset.squaredNorm() >= nearest) continue;
      Sliver found = sliverOf(other, offset, wanted);
      if (found.pieces == 0) continue;
      nearest = offset.squaredNorm();
      best = found;
      best.at = {static_cast<std::int32_t>(draft_.brickOf(u, v, w)),
                 static_cast<std::int16_t>((u & 7) | (v & 7) << 3 | (w & 7) << 6), u, v, w};
    }
    return best;
  }

  // The voxel's pieces inside the one at `offset` from it; none where they cut off so much that
  // they cannot be there: the surface has bent away, or ended.
  static Sliver sliverOf(const VoxelState& v, const V3& offset, float wanted) {
    Sliver sliver;
    sliver.owner = v;
    // A quadric that does not even explain its own block says nothing of the next voxel.
    if (v.count() == 1 && v.pieces[0].surface.residual > kSound) return sliver;
    float all = 0;
    // Does it leave the voxel as full or empty as it is? One face alone can empty what faces
    // intersect in, and fill what they unite to; else all must.
    const bool one = (v.rule() == PieceRule::Concave) == (wanted > 0);
    bool thin = !one;
    for (int own = 0; own < v.count(); ++own) {
      const SurfacePiece& piece = v.pieces[own];
      const CcSurface& f = piece.surface;
      const bool plain = ccAbs(ccPredict(&f, offset.data()).volume - wanted) < kSliver;
      thin = one ? thin || plain : thin && plain;
      const Eigen::Map<const V3> n(f.n);
      if (piece.area == 0) continue;
      if (std::abs(n.dot(offset) - f.s) > 0.5f * n.lpNorm<1>() + kJitter[kJitters - 1]) continue;
      const CutPart part = cutPiece(v, own, offset - V3::Constant(0.5f), 1.0f);
      if (part.area == 0) continue;
      all += part.area;
      sliver.part[sliver.pieces] = part;
      sliver.own[sliver.pieces++] = own;
    }
    if (!thin && (v.count() == 1 || all > kEdgeSliver)) sliver.pieces = 0;
    return sliver;
  }

  void give(const Sliver& sliver, int k, SampleOrigin origin) {
    const int own = sliver.own[k];
    const SurfacePiece& piece = sliver.owner.pieces[own];
    const SurfaceSample more = onSurface(piece.surface, sliver.part[k], sliver.at.middle());
    // At an edge a sample of its own: lumped with another it would lie too far from the edge, and
    // a wall that is pressed in by half a voxel pushed 2.5 % too little.
    if (sliver.owner.count() > 1 && more.area > kOwnSliver && piece.surface.residual < kSureEdge) {
      origin.brick = sliver.at.brick;
      origin.cell = sliver.at.cell;
      extra_.push_back({more, origin});
      return;
    }
    BrickCut& cut =
        cuts_[static_cast<std::size_t>(slots_[static_cast<std::size_t>(sliver.at.brick)])];
    const Run& run = cut.runs[sliver.owner.step->first + static_cast<std::size_t>(own)];
    SurfaceSample* into = &cut.samples[run.first];
    // Of an edge's pieces the nearest takes it, so that it stays at the edge.
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i)
      if (away(cut.samples[i], more) < away(*into, more)) into = &cut.samples[i];
    const float share = more.area / (more.area + into->area);
    for (int i = 0; i < 3; ++i) into->position[i] += share * (more.position[i] - into->position[i]);
    into->area += more.area;
  }

  static float away(const SurfaceSample& a, const SurfaceSample& b) {
    return (Eigen::Map<const V3>(a.position) - Eigen::Map<const V3>(b.position)).squaredNorm();
  }
  const FieldDraft& draft_;
  const VoxelSet* of_;
  const VoxelSet* in_ = nullptr;
  const std::vector<std::int32_t>& slots_;
  std::vector<BrickCut>& cuts_;
  std::vector<Candidate> candidates_;
  std::vector<CutSample> extra_;
  BrickGrid<std::uint8_t> seen_;
};

}  // namespace

std::vector<CutSample> cutSamples(FieldDraft& draft, const VoxelSet* of) {
  const std::vector<std::int32_t> bricks = of ? of->bricks() : draft.surfaceBricks();
  std::vector<std::int32_t> slots(draft.bricks().size(), -1);
  std::vector<BrickCut> cuts(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i)
    slots[static_cast<std::size_t>(bricks[i])] = static_cast<std::int32_t>(i);
  parallelFor(bricks.size(), draft.settings.threads, [&](std::size_t i, int) {
    if (draft.brick(static_cast<std::size_t>(bricks[i]))) cutBrick(draft, bricks[i], of, cuts[i]);
  });
  SliverCutter slivers(draft, of, slots, cuts);
  // A voxel's slivers lie beside it, and are seen from beside themselves.
  std::vector<CutSample> extra;
  if (of) {
    const VoxelSet in = of->dilated(1), by = of->dilated(2);
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
