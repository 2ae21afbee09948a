// Packs the records.
#include "field/field_band.h"

#include "base/parallel.h"
#include "kernels/contact/search.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

// A full or empty voxel may be cut by this part of its volume: rounding of coverage to 1/255, and
// noise of the fits.
constexpr float kSliver = 0.006f;
constexpr int kProbes = 4;            // points along a voxel's edge in claims()
constexpr float kProbeDepth = 0.05f;  // largest depth at such a point
constexpr float kMatters = 1.2f;      // a further plane counts if less than this deeper
constexpr double kBrickCost = 8;      // of a brick of the band [us]

// A brick of the band as it is being written.
struct NewBrick {
  BandBrick brick;
  bool used = false;  // at least one voxel has a plane

  void set(int cell, CcVoxel record) {
    brick.cells[static_cast<std::size_t>(cell)] = record;
    used = used || ccPlaneCount(record) > 0;
  }
};

class Writer {
 public:
  Writer(const FieldDraft& draft, const FieldLayers& layers) : draft_(draft), layers_(layers) {}

  Band all() const {
    std::vector<std::int32_t> bricks;
    for (std::size_t t = 0; t < layers_.bricks().size(); ++t)
      if (layers_.bricks()[t]) bricks.push_back(static_cast<std::int32_t>(t));
    return write(bricks, kNoBand, [&](std::int32_t t, NewBrick& out) {
      for (int k = 0; k < kBrickVoxels; ++k) out.set(k, recordAt(t, k, out.brick.planes));
    });
  }

  // As renewBand().
  Band some(const VoxelSet& scope, const std::function<BandView(std::size_t brick)>& before) const {
    return write(scope.bricks(), kAsBefore, [&](std::int32_t t, NewBrick& out) {
      const VoxelSet::Rows& rows = *scope.find(t);
      const BandView old = before(static_cast<std::size_t>(t));
      for (int k = 0; k < kBrickVoxels; ++k)
        out.set(k, VoxelSet::holds(rows, k) ? recordAt(t, k, out.brick.planes)
                                            : copied(old, k, out.brick.planes));
    });
  }

 private:
  // True if `b` bounds the body together with `a`, in a convex edge or as a thin wall's back. Small
  // pieces right at a convex edge may lie a little above each other's plane. Left out, a thread's
  // crest goes on into the air beside its edge, and a nut in its play touches nothing in 44 places.
  static bool partners(const NearPiece& a, const NearPiece& b) {
    if (a.key.voxel() == b.key.voxel()) return a.rule == PieceRule::Convex;
    const V3 d = b.centroid - a.centroid;
    const bool atEdge = a.rule == PieceRule::Convex && b.rule == PieceRule::Convex;
    const float above = atEdge ? 0.15f : -0.05f;
    return a.normal.dot(d) < above && b.normal.dot(d) > -above;
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
      const NearPiece s = nearPiece(draft_, cell.piece[i], center);
      // A full voxel lies entirely below every face that bounds it. A face that cuts it has ended.
      if (inside && below(s) < 1 - kSliver) continue;
      if (count > 0 && (s.depth > kept[0].depth + kMatters || !partners(kept[0], s))) continue;
      kept[count++] = s;
    }
    // If all have ended, at a vertex that no fit explains, the nearest is used, moved until the
    // voxel is full. Otherwise the voxel would count as deep inside, which throws contacting bodies
    // aside.
    if (inside && count == 0 && cell.count > 0) {
      NearPiece s = nearPiece(draft_, cell.piece[0], center);
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

  CcVoxel recordAt(std::int32_t t, int k, std::vector<CcVoxel>& planes) const {
    const BandCells* const cells = layers_.bricks()[static_cast<std::size_t>(t)].get();
    if (!cells || (*cells)[static_cast<std::size_t>(k)].layer < 0) return {0, 0};
    const SurfaceBrick* const brick = draft_.brick(static_cast<std::size_t>(t));
    const VoxelState own = brick ? brick->state(k) : VoxelState{};
    if (own) return record(own, planes);
    return record(draft_.cornerOf(static_cast<std::size_t>(t)) + cellOffset(k),
                  (*cells)[static_cast<std::size_t>(k)], planes);
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

  // Writes the records of `bricks` by put(brick, out); all other bricks are `rest`.
  template <typename Put>
  Band write(const std::vector<std::int32_t>& bricks, std::int32_t rest, Put&& put) const {
    std::vector<NewBrick> made(bricks.size());
    const std::size_t atOnce = draft_.partsAtOnce(16, bricks.size());
    for (std::size_t first = 0; first < bricks.size(); first += atOnce) {
      const std::size_t count = std::min(atOnce, bricks.size() - first);
      draft_.spend(kBrickCost * static_cast<double>(count));
      parallelFor(count, draft_.threads, [&](std::size_t k, int) {
        const std::size_t i = first + k;
        put(bricks[i], made[i]);
        if (made[i].used) markDeep(static_cast<std::size_t>(bricks[i]), made[i].brick);
      });
    }
    Band band{std::vector<std::int32_t>(layers_.bricks().size(), rest), {}};
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      std::int32_t& slot = band.table[static_cast<std::size_t>(bricks[i])];
      slot = made[i].used ? static_cast<std::int32_t>(band.bricks.size()) : kNoBand;
      if (made[i].used) band.bricks.push_back(std::move(made[i].brick));
    }
    return band;
  }

  // Marks full voxels without planes.
  void markDeep(std::size_t t, BandBrick& brick) const {
    const Cloud::Voxels& voxels = draft_.cloud.voxels();
    const std::int32_t stored = voxels.table[t];
    if (stored == kEmptyBrick) return;
    for (std::size_t k = 0; k < kBrickVoxels; ++k)
      if (ccPlaneCount(brick.cells[k]) == 0 &&
          (stored == kSolidBrick || voxels.coverage[static_cast<std::size_t>(stored)][k] > 127))
        brick.cells[k].b = CC_DEEP_INSIDE;
  }

  const FieldDraft& draft_;
  const FieldLayers& layers_;
};

}  // namespace

Band writeBand(const FieldDraft& draft, const FieldLayers& layers) {
  return Writer(draft, layers).all();
}

Band renewBand(const FieldDraft& draft, const FieldLayers& layers, const VoxelSet& scope,
               const std::function<BandView(std::size_t brick)>& before) {
  return Writer(draft, layers).some(scope, before);
}

}  // namespace cloudcontact
