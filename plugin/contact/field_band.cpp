// The last step of the field: the band. Voxels beside the surface inherit the pieces nearest to
// them from their neighbours, layer by layer, and become records of one plane, or of several where
// the nearest pieces meet in a convex edge or stand back to back (a thin wall): there the depth is
// the least over the planes, which is the distance to the body's outside.
#include "../geometry/parallel.h"
#include "field_builder.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

constexpr int kInsideLayers = 5;   // how deep contact is known [voxels]
constexpr int kOutsideLayers = 2;  // samples feel a surface before they cross it (smoothed depth)
constexpr int kKept = 4;           // pieces a voxel passes on
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

// A piece seen from a voxel's middle.
struct Seen {
  std::uint32_t piece, owner;  // owner: the voxel that it was found in
  float far;                   // squared distance to the piece's centroid
  float depth;                 // of the middle under the piece's surface
  V3 normal, centroid;
  float drop;  // of the surface's mean over a voxel below its middle
};

// The mean of a curved surface over a voxel (variance 1/12 each way) lies this much below its
// middle, so that a sample anywhere in the voxel reads the right depth in the mean.
float dropOf(const CcSurface& f) {
  return (f.k11 + f.k22) * (1.0f / 24.0f);
}

Seen see(const FieldDraft& draft, std::uint32_t piece, std::uint32_t owner, const V3& middle) {
  const SurfacePiece& p = draft.pieces[piece];
  const Eigen::Map<const V3> n(p.surface.n), t1(p.surface.t1), t2(p.surface.t2), c(p.centroid);
  const SurfaceVoxel& at = draft.voxels[owner];
  const V3 r = middle - V3(float(at.x) + 0.5f, float(at.y) + 0.5f, float(at.z) + 0.5f);
  // Curvature only near the piece: the quadric is known over its own block.
  const float u = std::clamp(t1.dot(r), -1.5f, 1.5f), v = std::clamp(t2.dot(r), -1.5f, 1.5f);
  const float ku = p.surface.k11 * u + p.surface.k12 * v,
              kv = p.surface.k12 * u + p.surface.k22 * v;
  const V3 m = n + ku * t1 + kv * t2;
  const float phi = n.dot(r) + 0.5f * (ku * u + kv * v) - p.surface.s, length = m.norm();
  return {piece,      owner, (middle - c).squaredNorm(), -phi / length,
          m / length, c,     dropOf(p.surface)};
}

class Spreader {
 public:
  explicit Spreader(const FieldDraft& draft)
      : draft_(draft), grid_(draft.cloud.bricks(), BandCell{}), owner_(draft.pieces.size()) {
    for (std::uint32_t i = 0; i < draft.voxels.size(); ++i) seed(i);
  }

  Band run() {
    for (int layer = 1; layer <= std::max(kInsideLayers, kOutsideLayers); ++layer) grow(layer);
    return finish();
  }

 private:
  void seed(std::uint32_t voxel) {
    const SurfaceVoxel& v = draft_.voxels[voxel];
    BandCell& cell = grid_.make(v.x, v.y, v.z);
    cell.layer = 0;
    for (std::uint32_t k = 0; k < v.count; ++k) {
      owner_[v.first + k] = voxel;
      // Only pieces that are there are handed on; a plane that merely bounds them is not a surface.
      if (cell.count < kKept && draft_.pieces[v.first + k].area > 0)
        cell.piece[cell.count++] = v.first + k;
    }
    frontier_.push_back({v.x, v.y, v.z});
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
                                       [&](const Seen& s) { return s.piece == from.piece[i]; });
        if (!known) seen[count++] = see(draft_, from.piece[i], owner_[from.piece[i]], middle);
      }
    }
    std::sort(seen, seen + count, [](const Seen& a, const Seen& b) {
      return a.far != b.far ? a.far < b.far : a.piece < b.piece;
    });
    BandCell& cell = grid_.make(at.x(), at.y(), at.z());
    Seen kept[kKept];
    for (int i = 0; i < count && cell.count < kKept; ++i) {
      const bool same = std::any_of(kept, kept + cell.count, [&](const Seen& k) {
        return k.normal.dot(seen[i].normal) > kOneFace;
      });
      if (same) continue;
      kept[cell.count] = seen[i];
      cell.piece[cell.count++] = seen[i].piece;
    }
  }

  // True where `b` bounds the body beside `a` as a convex edge or a thin wall's back does.
  bool partners(const Seen& a, const Seen& b) const {
    if (a.owner == b.owner) return draft_.voxels[a.owner].rule == PieceRule::Convex;
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

  CcVoxel record(const SurfaceVoxel& v, std::vector<CcVoxel>& planes) const {
    const std::uint32_t first = static_cast<std::uint32_t>(planes.size());
    for (std::uint32_t k = 0; k < v.count; ++k) {
      const CcSurface& f = draft_.pieces[v.first + k].surface;
      const CcVoxel plane = ccPackPlane(f.n, f.s - dropOf(f));
      if (v.count == 1) return plane;
      planes.push_back(plane);
    }
    return ccPackPlanes(first, v.count, v.rule == PieceRule::Concave);
  }

  CcVoxel record(const Eigen::Vector3i& at, const BandCell& cell,
                 std::vector<CcVoxel>& planes) const {
    const V3 middle = at.cast<float>() + V3::Constant(0.5f);
    const bool inside = draft_.cloud.coverage(at.x(), at.y(), at.z()) > 127;
    Seen kept[kKept];
    int count = 0;
    for (int i = 0; i < cell.count; ++i) {
      const Seen s = see(draft_, cell.piece[i], owner_[cell.piece[i]], middle);
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
      Seen s = see(draft_, cell.piece[0], owner_[cell.piece[0]], middle);
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

  Band finish() const {
    Band band{BrickGrid<CcVoxel>(draft_.cloud.bricks(), CcVoxel{0, 0}), {}, 0};
    const Eigen::Vector3i n = draft_.cloud.bricks();
    for (std::size_t t = 0; t < grid_.table().size(); ++t) {
      if (grid_.table()[t] < 0) continue;
      const int b = static_cast<int>(t);
      const Eigen::Vector3i brick(b % n.x(), b / n.x() % n.y(), b / n.x() / n.y());
      for (int k = 0; k < kBrickVoxels; ++k) {
        const BandCell& cell =
            grid_.cells()[static_cast<std::size_t>(grid_.table()[t])][static_cast<std::size_t>(k)];
        if (cell.layer < 0) continue;
        const Eigen::Vector3i at = brick * kBrickEdge + Eigen::Vector3i(k & 7, k >> 3 & 7, k >> 6);
        const std::int32_t own = draft_.index.at(at.x(), at.y(), at.z());
        const CcVoxel v = own >= 0
                              ? record(draft_.voxels[static_cast<std::size_t>(own)], band.planes)
                              : record(at, cell, band.planes);
        if (ccPlaneCount(v) == 0) continue;
        band.grid.make(at.x(), at.y(), at.z()) = v;
        ++band.voxels;
      }
    }
    markDeep(band);
    return band;
  }

  // Full voxels of the band's bricks that have no plane.
  void markDeep(Band& band) const {
    const Eigen::Vector3i n = draft_.cloud.bricks();
    for (std::size_t t = 0; t < band.grid.table().size(); ++t) {
      if (band.grid.table()[t] < 0) continue;
      const int b = static_cast<int>(t);
      const Eigen::Vector3i low =
          Eigen::Vector3i(b % n.x(), b / n.x() % n.y(), b / n.x() / n.y()) * kBrickEdge;
      auto& cells = band.grid.cells()[static_cast<std::size_t>(band.grid.table()[t])];
      for (int k = 0; k < kBrickVoxels; ++k) {
        CcVoxel& cell = cells[static_cast<std::size_t>(k)];
        if (ccPlaneCount(cell) > 0) continue;
        if (draft_.cloud.coverage(low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6)) >
            127)
          cell.b = kDeepInside;
      }
    }
  }

  const FieldDraft& draft_;
  BrickGrid<BandCell> grid_;
  std::vector<std::uint32_t> owner_;  // the voxel that a piece was found in
  std::vector<Eigen::Vector3i> frontier_;
};

}  // namespace

Band spreadBand(const FieldDraft& draft) {
  return Spreader(draft).run();
}

}  // namespace cloudcontact
