// The last step of the field: the band. Voxels beside the surface inherit the pieces nearest to
// them from their neighbours, layer by layer, and become records of one plane, or of several where
// the nearest pieces meet in a convex edge or stand back to back (a thin wall): there the depth is
// the least over the planes, which is the distance to the body's outside.
#include "base/parallel.h"
#include "field/field_data.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

constexpr int kInsideLayers = 5;   // how deep contact is known [voxels]
constexpr int kOutsideLayers = 2;  // samples feel a surface before they cross it (smoothed depth)
static_assert(kInsideLayers <= kBandReach && kOutsideLayers <= kBandReach);
constexpr int kKept = 4;  // pieces a voxel passes on
constexpr float kOneFace =
    0.9f;  // cosine: pieces within 26 deg are one face, the nearest stands for it
// A voxel that counts as full or empty may still be cut by this much of its volume: what coverage
// in 1/255 rounds away, and the fits' noise.
constexpr float kSliver = 0.006f;
constexpr int kProbes = 4;            // points along a voxel's edge where an edge is looked for
constexpr float kProbeDepth = 0.05f;  // and how deep it may claim them to be
constexpr float kMatters = 1.2f;      // a further plane counts where it is less than this deeper

struct BandCell {
  std::uint32_t piece[kKept];
  std::int8_t count = 0;
  std::int8_t layer = -1;  // 0: surface voxel, then 1, 2, ... outwards from it on both sides
};

// A piece that is there, and the voxel that it was found in. Numbered by the pass that found them,
// then by their voxels' order: of two as near the one with the lower number comes first.
struct Source {
  const SurfacePiece* piece;
  std::int16_t x, y, z;
  PieceRule rule;

  bool sameVoxel(const Source& other) const { return x == other.x && y == other.y && z == other.z; }
};

// A source seen from a voxel's middle.
struct Seen {
  std::uint32_t source;
  float far;    // squared distance to the piece's centroid
  float depth;  // of the middle under the piece's surface
  V3 normal, centroid;
  float drop;  // of the surface's mean over a voxel below its middle
};

// The mean of a curved surface over a voxel (variance 1/12 each way) lies this much below its
// middle, so that a sample anywhere in the voxel reads the right depth in the mean.
float dropOf(const CcSurface& f) {
  return (f.k11 + f.k22) * (1.0f / 24.0f);
}

Seen see(const std::vector<Source>& sources, std::uint32_t source, const V3& middle) {
  const Source& at = sources[source];
  const SurfacePiece& p = *at.piece;
  const Eigen::Map<const V3> n(p.surface.n), t1(p.surface.t1), t2(p.surface.t2), c(p.centroid);
  const V3 r = middle - V3(float(at.x) + 0.5f, float(at.y) + 0.5f, float(at.z) + 0.5f);
  // Curvature only near the piece: the quadric is known over its own block.
  const float u = std::clamp(t1.dot(r), -1.5f, 1.5f), v = std::clamp(t2.dot(r), -1.5f, 1.5f);
  const float ku = p.surface.k11 * u + p.surface.k12 * v,
              kv = p.surface.k12 * u + p.surface.k22 * v;
  const V3 m = n + ku * t1 + kv * t2;
  const float phi = n.dot(r) + 0.5f * (ku * u + kv * v) - p.surface.s, length = m.norm();
  return {source, (middle - c).squaredNorm(), -phi / length, m / length, c, dropOf(p.surface)};
}

// A brick of a finished band as it is being written.
struct Draught {
  BandBrick brick;
  bool used = false;  // some voxel has a plane

  void set(int cell, CcVoxel record) {
    brick.cells[static_cast<std::size_t>(cell)] = record;
    used = used || ccPlaneCount(record) > 0;
  }
};

class Spreader {
 public:
  // Sources are the surface voxels of `near`, or all.
  Spreader(const FieldDraft& draft, const VoxelSet* near)
      : draft_(draft), grid_(draft.cloud.bricks(), BandCell{}) {
    seed(near);
    for (int layer = 1; layer <= std::max(kInsideLayers, kOutsideLayers); ++layer) grow(layer);
  }

  // Everything.
  Band finish() const {
    std::vector<std::int32_t> bricks;
    for (std::size_t t = 0; t < grid_.table().size(); ++t)
      if (grid_.table()[t] >= 0) bricks.push_back(static_cast<std::int32_t>(t));
    return write(bricks, kNoBand,
                 [&](std::int32_t t, int cell, const Eigen::Vector3i& at, Draught& out) {
                   out.set(cell, recordAt(t, cell, at, out.brick.planes));
                 });
  }

  // Only the voxels of `where`; the bricks' others are what they were.
  Band finish(const VoxelSet& where, const FieldData& before) const {
    return write(where.bricks(), kAsBefore,
                 [&](std::int32_t t, int cell, const Eigen::Vector3i& at, Draught& out) {
                   out.set(cell, where.has(t, cell)
                                     ? recordAt(t, cell, at, out.brick.planes)
                                     : copied(before.bandBrick(static_cast<std::size_t>(t)), cell,
                                              out.brick.planes));
                 });
  }

 private:
  void seed(const VoxelSet* near) {
    struct Seed {
      VoxelState state;
      Eigen::Vector3i at;
    };
    std::vector<Seed> seeds;
    for (const std::int32_t t : near ? near->bricks() : draft_.surfaceBricks()) {
      const SurfaceBrick* const b = draft_.brick(static_cast<std::size_t>(t));
      if (!b) continue;
      const Eigen::Vector3i low = draft_.cornerOf(static_cast<std::size_t>(t));
      for (const SurfaceVoxel& v : b->voxels)
        if (!near || near->has(t, v.cell))
          seeds.push_back({b->stateAt(v.last),
                           low + Eigen::Vector3i(v.cell & 7, v.cell >> 3 & 7, v.cell >> 6)});
    }
    std::stable_sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) {
      return a.state.step->pass < b.state.step->pass;
    });
    for (const Seed& s : seeds) seed(s.state, s.at);
  }

  void seed(const VoxelState& v, const Eigen::Vector3i& at) {
    BandCell& cell = grid_.make(at.x(), at.y(), at.z());
    cell.layer = 0;
    // Only pieces that are there are handed on; a plane that merely bounds them is not a surface.
    for (int k = 0; k < v.count() && cell.count < kKept; ++k) {
      if (!(v.pieces[k].area > 0)) continue;
      cell.piece[cell.count++] = static_cast<std::uint32_t>(sources_.size());
      sources_.push_back({&v.pieces[k], static_cast<std::int16_t>(at.x()),
                          static_cast<std::int16_t>(at.y()), static_cast<std::int16_t>(at.z()),
                          v.rule()});
    }
    frontier_.push_back(at);
  }

  void grow(int layer) {
    std::vector<Eigen::Vector3i> next;
    for (const Eigen::Vector3i& v : frontier_)
      for (int k = 0; k < 27; ++k) {
        const Eigen::Vector3i w = v + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (!grid_.contains(w.x(), w.y(), w.z()) || grid_.at(w.x(), w.y(), w.z()).layer >= 0)
          continue;
        const bool inside = draft_.cloud.coverage(w.x(), w.y(), w.z()) > 127;
        if (layer > (inside ? kInsideLayers : kOutsideLayers)) continue;
        grid_.make(w.x(), w.y(), w.z()).layer = static_cast<std::int8_t>(layer);
        next.push_back(w);
      }
    parallelFor((next.size() + 511) / 512, draft_.settings.threads, [&](std::size_t chunk, int) {
      const std::size_t end = std::min(next.size(), (chunk + 1) * 512);
      for (std::size_t i = chunk * 512; i < end; ++i) inherit(next[i], layer);
    });
    frontier_ = std::move(next);
  }

  // The nearest piece and its convex partners among all that the neighbours of earlier layers know.
  void inherit(const Eigen::Vector3i& at, int layer) {
    const V3 middle = at.cast<float>() + V3::Constant(0.5f);
    Seen seen[27 * kKept];
    int count = 0;
    for (int k = 0; k < 27; ++k) {
      const BandCell& from =
          grid_.at(at.x() + k % 3 - 1, at.y() + k / 3 % 3 - 1, at.z() + k / 9 - 1);
      if (from.layer < 0 || from.layer >= layer) continue;
      for (int i = 0; i < from.count; ++i) {
        const bool known = std::any_of(seen, seen + count,
                                       [&](const Seen& s) { return s.source == from.piece[i]; });
        if (!known) seen[count++] = see(sources_, from.piece[i], middle);
      }
    }
    std::sort(seen, seen + count, [](const Seen& a, const Seen& b) {
      return a.far != b.far ? a.far < b.far : a.source < b.source;
    });
    BandCell& cell = grid_.make(at.x(), at.y(), at.z());
    Seen kept[kKept];
    for (int i = 0; i < count && cell.count < kKept; ++i) {
      const bool same = std::any_of(kept, kept + cell.count, [&](const Seen& k) {
        return k.normal.dot(seen[i].normal) > kOneFace;
      });
      if (same) continue;
      kept[cell.count] = seen[i];
      cell.piece[cell.count++] = seen[i].source;
    }
  }

  // True where `b` bounds the body beside `a` as a convex edge or a thin wall's back does.
  bool partners(const Seen& a, const Seen& b) const {
    const Source& from = sources_[a.source];
    if (from.sameVoxel(sources_[b.source])) return from.rule == PieceRule::Convex;
    const V3 d = b.centroid - a.centroid;
    return a.normal.dot(d) < -0.05f && b.normal.dot(d) > 0.05f;
  }

  // The share of the voxel that lies below a face.
  static float below(const Seen& s) {
    return ccCutCube(s.normal.x(), s.normal.y(), s.normal.z(), s.depth).volume;
  }

  // True where the faces together put material into the voxel.
  static bool claims(const Seen* faces, int count) {
    for (int i = 0; i < count; ++i)
      if (below(faces[i]) <= kSliver) return false;
    if (count <= 1) return count == 1;
    for (int k = 0; k < kProbes * kProbes * kProbes; ++k) {
      const V3 at =
          (V3(float(k % kProbes), float(k / kProbes % kProbes), float(k / kProbes / kProbes)) +
           V3::Constant(0.5f)) /
              kProbes -
          V3::Constant(0.5f);
      float depth = 1e9f;
      for (int i = 0; i < count; ++i)
        depth = std::min(depth, faces[i].depth - faces[i].normal.dot(at));
      if (depth > kProbeDepth) return true;
    }
    return false;
  }

  // Of a surface voxel.
  static CcVoxel record(const VoxelState& v, std::vector<CcVoxel>& planes) {
    const std::uint32_t first = static_cast<std::uint32_t>(planes.size());
    for (int k = 0; k < v.count(); ++k) {
      const CcSurface& f = v.pieces[k].surface;
      const CcVoxel plane = ccPackPlane(f.n, f.s - dropOf(f));
      if (v.count() == 1) return plane;
      planes.push_back(plane);
    }
    return ccPackPlanes(first, static_cast<std::uint32_t>(v.count()),
                        v.rule() == PieceRule::Concave);
  }

  // Of a voxel beside the surface.
  CcVoxel record(const Eigen::Vector3i& at, const BandCell& cell,
                 std::vector<CcVoxel>& planes) const {
    const V3 middle = at.cast<float>() + V3::Constant(0.5f);
    const bool inside = draft_.cloud.coverage(at.x(), at.y(), at.z()) > 127;
    Seen kept[kKept];
    int count = 0;
    for (int i = 0; i < cell.count; ++i) {
      const Seen s = see(sources_, cell.piece[i], middle);
      // A full voxel lies wholly below every face that bounds it; one that says otherwise has
      // ended.
      if (inside && below(s) < 1 - kSliver) continue;
      if (count > 0 && (s.depth > kept[0].depth + kMatters || !partners(kept[0], s))) continue;
      kept[count++] = s;
    }
    // Where all of them do, at a vertex that no fit explains, the nearest stands in, moved to where
    // the voxel is full: without it two such voxels at the end of a M16 nut's thread counted as
    // deep inside, and threw the nut aside.
    if (inside && count == 0 && cell.count > 0) {
      Seen s = see(sources_, cell.piece[0], middle);
      s.depth = std::max(s.depth, 0.5f * s.normal.lpNorm<1>() + s.drop);
      kept[count++] = s;
    }
    // Nor does an empty voxel lie in the material: a face alone would run on into the air.
    if (!inside && claims(kept, count)) return {0, 0};
    if (count == 0) return {0, 0};
    if (count == 1) return ccPackPlane(kept[0].normal.data(), kept[0].depth - kept[0].drop);
    const std::uint32_t first = static_cast<std::uint32_t>(planes.size());
    for (int i = 0; i < count; ++i)
      planes.push_back(ccPackPlane(kept[i].normal.data(), kept[i].depth - kept[i].drop));
    return ccPackPlanes(first, static_cast<std::uint32_t>(count), 0);
  }

  CcVoxel recordAt(std::int32_t t, int k, const Eigen::Vector3i& at,
                   std::vector<CcVoxel>& planes) const {
    const std::int32_t slot = grid_.table()[static_cast<std::size_t>(t)];
    if (slot < 0) return {0, 0};
    const BandCell& cell =
        grid_.cells()[static_cast<std::size_t>(slot)][static_cast<std::size_t>(k)];
    if (cell.layer < 0) return {0, 0};
    const VoxelState own = draft_.at(at.x(), at.y(), at.z());
    return own ? record(own, planes) : record(at, cell, planes);
  }

  static CcVoxel copied(const BandView& from, int cell, std::vector<CcVoxel>& planes) {
    CcVoxel v = from.cells ? from.cells[cell] : CcVoxel{0, 0};
    const uint count = ccPlaneCount(v);
    if (count == 0) return {0, 0};
    if (count == 1) return v;
    const CcVoxel* const first = from.planes + (v.b - from.first);
    v.b = static_cast<std::uint32_t>(planes.size());
    planes.insert(planes.end(), first, first + count);
    return v;
  }

  // Bricks whose records `put` gives, one after the other; all others are `rest`.
  template <typename Put>
  Band write(const std::vector<std::int32_t>& bricks, std::int32_t rest, Put&& put) const {
    std::vector<Draught> made(bricks.size());
    parallelFor(bricks.size(), draft_.settings.threads, [&](std::size_t i, int) {
      const Eigen::Vector3i low = draft_.cornerOf(static_cast<std::size_t>(bricks[i]));
      for (int k = 0; k < kBrickVoxels; ++k)
        put(bricks[i], k, Eigen::Vector3i(low + Eigen::Vector3i(k & 7, k >> 3 & 7, k >> 6)),
            made[i]);
      if (made[i].used) markDeep(low, made[i].brick);
    });
    Band band{std::vector<std::int32_t>(grid_.table().size(), rest), {}};
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      std::int32_t& slot = band.table[static_cast<std::size_t>(bricks[i])];
      slot = made[i].used ? static_cast<std::int32_t>(band.bricks.size()) : kNoBand;
      if (made[i].used) band.bricks.push_back(std::move(made[i].brick));
    }
    return band;
  }

  // Full voxels of the band's bricks that have no plane.
  void markDeep(const Eigen::Vector3i& low, BandBrick& brick) const {
    for (int k = 0; k < kBrickVoxels; ++k) {
      CcVoxel& cell = brick.cells[static_cast<std::size_t>(k)];
      if (ccPlaneCount(cell) > 0) continue;
      if (draft_.cloud.coverage(low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6)) >
          127)
        cell.b = kDeepInside;
    }
  }

  const FieldDraft& draft_;
  BrickGrid<BandCell> grid_;
  std::vector<Source> sources_;
  std::vector<Eigen::Vector3i> frontier_;
};

}  // namespace

Band spreadBand(const FieldDraft& draft) {
  return Spreader(draft, nullptr).finish();
}

Band spreadBandAgain(const FieldDraft& draft, const VoxelSet& where, const FieldData& before) {
  const VoxelSet near = where.dilated(kBandReach);
  return Spreader(draft, &near).finish(where, before);
}

}  // namespace cloudcontact
