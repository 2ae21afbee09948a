// Spreads the pieces over the layers and packs the records.
#include "field/field_band.h"

#include "base/parallel.h"
#include "kernels/contact/search.h"
#include "voxels/brick_grid.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

constexpr int kInsideLayers = 5;   // depth is known this far below the surface [voxels]
constexpr int kOutsideLayers = 2;  // samples feel a surface before they cross it (smoothed depth)
static_assert(kInsideLayers <= kBandReach && kOutsideLayers <= kBandReach);
constexpr int kKept = 4;          // pieces that a voxel passes on
constexpr float kOneFace = 0.9f;  // cosine: of pieces within 26 deg only the nearest is kept
// A full or empty voxel may be cut by this part of its volume: rounding of coverage to 1/255, and
// noise of the fits.
constexpr float kSliver = 0.006f;
constexpr int kProbes = 4;            // points along a voxel's edge in claims()
constexpr float kProbeDepth = 0.05f;  // largest depth at such a point
constexpr float kMatters = 1.2f;      // a further plane counts if less than this deeper

struct BandCell {
  std::uint32_t piece[kKept];
  std::int8_t count = 0;
  std::int8_t layer = -1;  // 0: surface voxel; 1, 2, ... away from it on both sides
};

// A piece inside a voxel, and that voxel. Numbered by the pass that found it, then by its voxel's
// order; of two equally near ones the lower number comes first.
struct Source {
  const SurfacePiece* piece;
  std::int16_t x, y, z;
  PieceRule rule;

  bool sameVoxel(const Source& other) const { return x == other.x && y == other.y && z == other.z; }
};

// A source relative to a voxel's center.
struct NearPiece {
  std::uint32_t source;
  float distance2;  // squared distance to the piece's centroid
  float depth;      // of the center below the piece's surface
  V3 normal, centroid;
  float drop;  // dropOf(surface)
};

// The mean of a curved surface over a voxel (variance 1/12 each way) lies this much below its
// center. With it, samples spread over the voxel read the right depth on average.
float dropOf(const CcSurface& f) {
  return (f.k11 + f.k22) * (1.0f / 24.0f);
}

NearPiece nearPiece(const std::vector<Source>& sources, std::uint32_t source, const V3& center) {
  const Source& at = sources[source];
  const SurfacePiece& p = *at.piece;
  const Eigen::Map<const V3> n(p.surface.n), t1(p.surface.t1), t2(p.surface.t2), c(p.centroid);
  const V3 r = center - V3(float(at.x) + 0.5f, float(at.y) + 0.5f, float(at.z) + 0.5f);
  // Clamped, because the quadric holds over its own block only.
  const float u = std::clamp(t1.dot(r), -1.5f, 1.5f), v = std::clamp(t2.dot(r), -1.5f, 1.5f);
  const float ku = p.surface.k11 * u + p.surface.k12 * v,
              kv = p.surface.k12 * u + p.surface.k22 * v;
  const V3 m = n + ku * t1 + kv * t2;
  const float phi = n.dot(r) + 0.5f * (ku * u + kv * v) - p.surface.s, length = m.norm();
  return {source, (center - c).squaredNorm(), -phi / length, m / length, c, dropOf(p.surface)};
}

// A brick of the band as it is being written.
struct NewBrick {
  BandBrick brick;
  bool used = false;  // at least one voxel has a plane

  void set(int cell, CcVoxel record) {
    brick.cells[static_cast<std::size_t>(cell)] = record;
    used = used || ccPlaneCount(record) > 0;
  }
};

class Spreader {
 public:
  // The sources are the surface voxels in `near`, or all.
  Spreader(const FieldDraft& draft, const VoxelSet* near)
      : draft_(draft), grid_(draft.cloud.bricks(), BandCell{}) {
    seed(near);
    for (int layer = 1; layer <= std::max(kInsideLayers, kOutsideLayers); ++layer) grow(layer);
  }

  Band finish() const {
    std::vector<std::int32_t> bricks;
    for (std::size_t t = 0; t < grid_.table().size(); ++t)
      if (grid_.table()[t] >= 0) bricks.push_back(static_cast<std::int32_t>(t));
    return write(bricks, kNoBand,
                 [&](std::int32_t t, int cell, const Eigen::Vector3i& at, NewBrick& out) {
                   out.set(cell, recordAt(t, cell, at, out.brick.planes));
                 });
  }

  // As renewBand().
  Band finish(const VoxelSet& scope,
              const std::function<BandView(std::size_t brick)>& before) const {
    return write(scope.bricks(), kAsBefore,
                 [&](std::int32_t t, int cell, const Eigen::Vector3i& at, NewBrick& out) {
                   out.set(cell, scope.has(t, cell) ? recordAt(t, cell, at, out.brick.planes)
                                                    : copied(before(static_cast<std::size_t>(t)),
                                                             cell, out.brick.planes));
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
          seeds.push_back({b->stateAt(v.last), low + cellOffset(v.cell)});
    }
    std::stable_sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) {
      return a.state.step->pass < b.state.step->pass;
    });
    for (const Seed& s : seeds) seed(s.state, s.at);
  }

  void seed(const VoxelState& v, const Eigen::Vector3i& at) {
    BandCell& cell = grid_.make(at.x(), at.y(), at.z());
    cell.layer = 0;
    // Planes that only bound other pieces are no surface and are not passed on.
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
    parallelFor((next.size() + 511) / 512, draft_.threads, [&](std::size_t chunk, int) {
      const std::size_t end = std::min(next.size(), (chunk + 1) * 512);
      for (std::size_t i = chunk * 512; i < end; ++i) inherit(next[i], layer);
    });
    frontier_ = std::move(next);
  }

  // Keeps the nearest pieces that the neighbors of earlier layers know, one per direction.
  void inherit(const Eigen::Vector3i& at, int layer) {
    const V3 center = at.cast<float>() + V3::Constant(0.5f);
    NearPiece near[27 * kKept];
    int count = 0;
    for (int k = 0; k < 27; ++k) {
      const BandCell& from =
          grid_.at(at.x() + k % 3 - 1, at.y() + k / 3 % 3 - 1, at.z() + k / 9 - 1);
      if (from.layer < 0 || from.layer >= layer) continue;
      for (int i = 0; i < from.count; ++i) {
        const bool known = std::any_of(
            near, near + count, [&](const NearPiece& s) { return s.source == from.piece[i]; });
        if (!known) near[count++] = nearPiece(sources_, from.piece[i], center);
      }
    }
    std::sort(near, near + count, [](const NearPiece& a, const NearPiece& b) {
      return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.source < b.source;
    });
    BandCell& cell = grid_.make(at.x(), at.y(), at.z());
    NearPiece kept[kKept];
    for (int i = 0; i < count && cell.count < kKept; ++i) {
      const bool same = std::any_of(kept, kept + cell.count, [&](const NearPiece& k) {
        return k.normal.dot(near[i].normal) > kOneFace;
      });
      if (same) continue;
      kept[cell.count] = near[i];
      cell.piece[cell.count++] = near[i].source;
    }
  }

  // True if `b` bounds the body together with `a`, in a convex edge or as a thin wall's back.
  bool partners(const NearPiece& a, const NearPiece& b) const {
    const Source& from = sources_[a.source];
    if (from.sameVoxel(sources_[b.source])) return from.rule == PieceRule::Convex;
    const V3 d = b.centroid - a.centroid;
    return a.normal.dot(d) < -0.05f && b.normal.dot(d) > 0.05f;
  }

  // The part of the voxel below a face.
  static float below(const NearPiece& s) {
    return ccCutCube(s.normal.x(), s.normal.y(), s.normal.z(), s.depth).volume;
  }

  // True if the faces together put material into the voxel.
  static bool claims(const NearPiece* faces, int count) {
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

  // The record of a surface voxel.
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

  // The record of a voxel beside the surface.
  CcVoxel record(const Eigen::Vector3i& at, const BandCell& cell,
                 std::vector<CcVoxel>& planes) const {
    const V3 center = at.cast<float>() + V3::Constant(0.5f);
    const bool inside = draft_.cloud.coverage(at.x(), at.y(), at.z()) > 127;
    NearPiece kept[kKept];
    int count = 0;
    for (int i = 0; i < cell.count; ++i) {
      const NearPiece s = nearPiece(sources_, cell.piece[i], center);
      // A full voxel lies entirely below every face that bounds it. A face that cuts it has ended.
      if (inside && below(s) < 1 - kSliver) continue;
      if (count > 0 && (s.depth > kept[0].depth + kMatters || !partners(kept[0], s))) continue;
      kept[count++] = s;
    }
    // If all have ended, at a vertex that no fit explains, the nearest is used, moved until the
    // voxel is full. Otherwise the voxel would count as deep inside, which throws contacting bodies
    // aside.
    if (inside && count == 0 && cell.count > 0) {
      NearPiece s = nearPiece(sources_, cell.piece[0], center);
      s.depth = std::max(s.depth, 0.5f * s.normal.lpNorm<1>() + s.drop);
      kept[count++] = s;
    }
    // An empty voxel holds no material: such a face would extend into the air.
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

  // Writes the records of `bricks` by put(brick, cell, voxel, out); all other bricks are `rest`.
  template <typename Put>
  Band write(const std::vector<std::int32_t>& bricks, std::int32_t rest, Put&& put) const {
    std::vector<NewBrick> made(bricks.size());
    parallelFor(bricks.size(), draft_.threads, [&](std::size_t i, int) {
      const Eigen::Vector3i low = draft_.cornerOf(static_cast<std::size_t>(bricks[i]));
      for (int k = 0; k < kBrickVoxels; ++k) put(bricks[i], k, low + cellOffset(k), made[i]);
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

  // Marks full voxels without planes.
  void markDeep(const Eigen::Vector3i& low, BandBrick& brick) const {
    for (int k = 0; k < kBrickVoxels; ++k) {
      CcVoxel& cell = brick.cells[static_cast<std::size_t>(k)];
      if (ccPlaneCount(cell) > 0) continue;
      const Eigen::Vector3i v = low + cellOffset(k);
      if (draft_.cloud.coverage(v.x(), v.y(), v.z()) > 127) cell.b = CC_DEEP_INSIDE;
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

Band renewBand(const FieldDraft& draft, const VoxelSet& scope,
               const std::function<BandView(std::size_t brick)>& before) {
  const VoxelSet near = scope.dilated(kBandReach);
  return Spreader(draft, &near).finish(scope, before);
}

}  // namespace cloudcontact
