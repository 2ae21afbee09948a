// The third step of the field: samples. Each piece of surface inside a voxel becomes a quadrature
// point at its centroid with its area, so that sums over samples integrate linear functions over
// flat faces exactly. A piece that lies in the face between two voxels must be counted once: the
// plane is cut at four offsets within an eighth of a voxel about its place and the areas
// averaged, so that each voxel has half of it however the fits' noise falls.
#include "../geometry/parallel.h"
#include "field_builder.h"

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
constexpr std::size_t kChunk = 1024;  // voxels that one thread cuts at a time
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
    V3 kept[16];
    int keep = 0;
    for (int i = 0; i < count; ++i) {
      const V3 &a = corner[i], &b = corner[(i + 1) % count];
      const float da = n.dot(a) - s, db = n.dot(b) - s;
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
float toEdge(const FieldDraft& draft, const SurfaceVoxel& v, std::uint32_t own, const V3& x) {
  const Eigen::Map<const V3> n(draft.pieces[v.first + own].surface.n);
  float nearest = 1e9f;
  for (std::uint32_t k = 0; k < v.count; ++k) {
    if (k == own) continue;
    const CcSurface& other = draft.pieces[v.first + k].surface;
    const Eigen::Map<const V3> m(other.n);
    const float along = (m - n.dot(m) * n).norm();
    if (along > 1e-3f) nearest = std::min(nearest, std::abs(other.s - m.dot(x)) / along);
  }
  return nearest;
}

// The part of piece `own` inside the box of that edge, bounded by the voxel's other pieces.
CutPart cutPiece(const FieldDraft& draft, const SurfaceVoxel& v, std::uint32_t own, const V3& low,
                 float edge) {
  const CcSurface& f = draft.pieces[v.first + own].surface;
  const Eigen::Map<const V3> n(f.n);
  const float off = n.dot(low + V3::Constant(0.5f * edge)) - f.s;
  if (std::abs(off) > 0.5f * edge * n.lpNorm<1>() + kJitter[kJitters - 1]) return {};
  float area = 0, second = 0, alone = 0, unused = 0;
  V3 first = V3::Zero(), nowhere = V3::Zero();
  for (float jitter : kJitter) {
    Polygon p = squareOn(f, jitter);
    for (int axis = 0; axis < 3; ++axis) {
      p.clip(V3::Unit(axis), low[axis] + edge);
      p.clip(-V3::Unit(axis), -low[axis]);
    }
    if (v.count > 1) p.moments(n, alone, nowhere, unused);
    for (std::uint32_t k = 0; k < v.count; ++k) {
      if (k == own) continue;
      const CcSurface& other = draft.pieces[v.first + k].surface;
      const Eigen::Map<const V3> m(other.n);
      const float sign = v.rule == PieceRule::Concave ? -1.0f : 1.0f;
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
  if (part.met) part.width = std::min(part.width, 2 * toEdge(draft, v, own, part.centroid));
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

// Where a piece's samples lie.
struct Run {
  std::uint32_t first = 0, count = 0;
};

// Whether an edge runs through the voxel or one beside it, and the voxel's own surface is a good
// fit: where it is not, finer samples would only tell its faults in more detail. Samples there are
// half a voxel wide: wider ones a voxel off reach under a wall's edge by their width alone, and a
// loop over a table's edge did up to 1.3 % of its work for nothing (0.3 % now).
bool besideEdge(const FieldDraft& draft, const SurfaceVoxel& v) {
  if (draft.pieces[v.first].surface.residual > kSureEdge) return false;
  for (int k = 0; k < 27; ++k) {
    const std::int32_t other =
        draft.index.at(v.x + k % 3 - 1, v.y + k / 3 % 3 - 1, v.z + k / 9 - 1);
    if (other >= 0 && draft.voxels[static_cast<std::size_t>(other)].count > 1) return true;
  }
  return false;
}

// Samples of a piece inside a box: one, or, where it ends there at another or they shall be `fine`,
// those of the box's octants, so that samples are small beside an edge and nowhere else.
void cutBox(const FieldDraft& draft, const SurfaceVoxel& v, std::uint32_t own, const V3& low,
            float edge, bool fine, std::vector<SurfaceSample>& samples) {
  const CutPart part = cutPiece(draft, v, own, low, edge);
  if (part.area == 0) return;
  if ((!part.met && !fine) || edge < 1.5f * (v.count > 3 ? kSmallestAtTip : kSmallest)) {
    const V3 middle(float(v.x) + 0.5f, float(v.y) + 0.5f, float(v.z) + 0.5f);
    samples.push_back(onSurface(draft.pieces[v.first + own].surface, part, middle));
    return;
  }
  const float half = 0.5f * edge;
  for (int k = 0; k < 8; ++k)
    cutBox(draft, v, own, low + half * V3(float(k & 1), float(k >> 1 & 1), float(k >> 2)), half,
           fine, samples);
}

// Samples of a voxel's own pieces.
void cutVoxel(FieldDraft& draft, const SurfaceVoxel& v, std::vector<Run>& runs,
              std::vector<SurfaceSample>& samples) {
  const V3 middle(float(v.x) + 0.5f, float(v.y) + 0.5f, float(v.z) + 0.5f);
  const bool fine = besideEdge(draft, v);
  for (std::uint32_t own = 0; own < v.count; ++own) {
    SurfacePiece& piece = draft.pieces[v.first + own];
    const std::size_t begin = samples.size();
    cutBox(draft, v, own, V3::Constant(-0.5f), 1.0f, fine, samples);
    runs[v.first + own] = {static_cast<std::uint32_t>(begin),
                           static_cast<std::uint32_t>(samples.size() - begin)};
    V3 sum = V3::Zero();
    for (std::size_t i = begin; i < samples.size(); ++i) {
      piece.area += samples[i].area;
      sum += samples[i].area * Eigen::Map<const V3>(samples[i].position);
    }
    // A plane without a piece of its own still stands somewhere: at its point nearest the voxel.
    const Eigen::Map<const V3> n(piece.surface.n);
    const V3 at = piece.area > 0 ? V3(sum / piece.area) : V3(middle + n * piece.surface.s);
    for (int i = 0; i < 3; ++i) piece.centroid[i] = at[i];
  }
}

// Slivers. A voxel of which the surface cuts off less than 1/510 counts as full or empty and has no
// pieces, but the sheets through such corners are 1.3 % of an oblique surface; an edge reaches 0.05
// voxel into such a voxel (a wall pressed in by half a voxel would push 20 % too little), a corner
// 0.23. Each such voxel beside the surface is given to the neighbour whose surface runs nearest to
// it; the pieces inside it become samples of their own at an edge, and are added to that
// neighbour's samples elsewhere.
class SliverCutter {
 public:
  SliverCutter(FieldDraft& draft, const std::vector<Run>& runs, std::vector<SurfaceSample>& samples)
      : draft_(draft), runs_(runs), samples_(samples), seen_(draft.cloud.bricks(), 0) {}

  void run() {
    for (const SurfaceVoxel& v : draft_.voxels)
      for (int k = 0; k < 27; ++k) {
        const int x = v.x + k % 3 - 1, y = v.y + k / 3 % 3 - 1, z = v.z + k / 9 - 1;
        if (!seen_.contains(x, y, z) || draft_.index.at(x, y, z) >= 0) continue;
        std::uint8_t& seen = seen_.make(x, y, z);
        if (seen) continue;
        seen = 1;
        cut(x, y, z);
      }
    samples_.insert(samples_.end(), extra_.begin(), extra_.end());
  }

 private:
  struct Sliver {
    const SurfaceVoxel* owner = nullptr;
    int pieces = 0;
    std::uint32_t own[CC_MAX_PLANES] = {};
    CutPart part[CC_MAX_PLANES];
  };

  void cut(int x, int y, int z) {
    const float wanted = draft_.cloud.coverage(x, y, z) > 127 ? 1.0f : 0.0f;
    Sliver best;
    float nearest = 4;  // squared distance to the owner's middle [voxel^2]
    for (int k = 0; k < 27; ++k) {
      const std::int32_t other = draft_.index.at(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1);
      if (other < 0) continue;
      const SurfaceVoxel& v = draft_.voxels[static_cast<std::size_t>(other)];
      const V3 offset(float(x - v.x), float(y - v.y), float(z - v.z));
      if (offset.squaredNorm() >= nearest) continue;
      const Sliver found = sliverOf(v, offset, wanted);
      if (found.pieces == 0) continue;
      nearest = offset.squaredNorm();
      best = found;
    }
    for (int k = 0; k < best.pieces; ++k) give(best, k);
  }

  // The voxel's pieces inside the one at `offset` from it; none where they cut off so much that
  // they cannot be there: the surface has bent away, or ended.
  Sliver sliverOf(const SurfaceVoxel& v, const V3& offset, float wanted) const {
    Sliver sliver;
    sliver.owner = &v;
    // A quadric that does not even explain its own block says nothing of the next voxel.
    if (v.count == 1 && draft_.pieces[v.first].surface.residual > kSound) return sliver;
    float all = 0;
    // Does it leave the voxel as full or empty as it is? One face alone can empty what faces
    // intersect in, and fill what they unite to; else all must.
    const bool one = (v.rule == PieceRule::Concave) == (wanted > 0);
    bool thin = !one;
    for (std::uint32_t own = 0; own < v.count; ++own) {
      const SurfacePiece& piece = draft_.pieces[v.first + own];
      const CcSurface& f = piece.surface;
      const bool plain = ccAbs(ccPredict(&f, offset.data()).volume - wanted) < kSliver;
      thin = one ? thin || plain : thin && plain;
      const Eigen::Map<const V3> n(f.n);
      if (piece.area == 0) continue;
      if (std::abs(n.dot(offset) - f.s) > 0.5f * n.lpNorm<1>() + kJitter[kJitters - 1]) continue;
      const CutPart part = cutPiece(draft_, v, own, offset - V3::Constant(0.5f), 1.0f);
      if (part.area == 0) continue;
      all += part.area;
      sliver.part[sliver.pieces] = part;
      sliver.own[sliver.pieces++] = own;
    }
    if (!thin && (v.count == 1 || all > kEdgeSliver)) sliver.pieces = 0;
    return sliver;
  }

  void give(const Sliver& sliver, int k) {
    const SurfaceVoxel& v = *sliver.owner;
    const std::uint32_t index = v.first + sliver.own[k];
    const V3 middle(float(v.x) + 0.5f, float(v.y) + 0.5f, float(v.z) + 0.5f);
    const SurfaceSample more = onSurface(draft_.pieces[index].surface, sliver.part[k], middle);
    // At an edge a sample of its own: lumped with another it would lie too far from the edge, and
    // a wall that is pressed in by half a voxel pushed 2.5 % too little.
    if (v.count > 1 && more.area > kOwnSliver &&
        draft_.pieces[index].surface.residual < kSureEdge) {
      extra_.push_back(more);
      return;
    }
    const Run& run = runs_[index];
    SurfaceSample* into = &samples_[run.first];
    // Of an edge's pieces the nearest takes it, so that it stays at the edge.
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i)
      if (away(samples_[i], more) < away(*into, more)) into = &samples_[i];
    const float share = more.area / (more.area + into->area);
    for (int i = 0; i < 3; ++i) into->position[i] += share * (more.position[i] - into->position[i]);
    into->area += more.area;
  }

  static float away(const SurfaceSample& a, const SurfaceSample& b) {
    return (Eigen::Map<const V3>(a.position) - Eigen::Map<const V3>(b.position)).squaredNorm();
  }
  FieldDraft& draft_;
  const std::vector<Run>& runs_;
  std::vector<SurfaceSample>& samples_;
  std::vector<SurfaceSample> extra_;
  BrickGrid<std::uint8_t> seen_;
};

}  // namespace

std::vector<SurfaceSample> cutSamples(FieldDraft& draft) {
  std::vector<Run> runs(draft.pieces.size());
  std::vector<std::vector<SurfaceSample>> cut((draft.voxels.size() + kChunk - 1) / kChunk);
  parallelFor(cut.size(), draft.settings.threads, [&](std::size_t chunk, int) {
    const std::size_t end = std::min(draft.voxels.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i)
      cutVoxel(draft, draft.voxels[i], runs, cut[chunk]);
  });
  std::vector<SurfaceSample> samples;
  std::size_t all = 0;
  for (const auto& part : cut) all += part.size();
  samples.reserve(all);
  for (std::size_t chunk = 0; chunk < cut.size(); ++chunk) {
    const std::size_t end = std::min(draft.voxels.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i)
      for (std::uint32_t k = 0; k < draft.voxels[i].count; ++k)
        runs[draft.voxels[i].first + k].first += static_cast<std::uint32_t>(samples.size());
    samples.insert(samples.end(), cut[chunk].begin(), cut[chunk].end());
  }
  SliverCutter(draft, runs, samples).run();
  return samples;
}

}  // namespace cloudcontact
