// How a field is built from a cloud, a step a file:
//   field_fit.cpp     each voxel that the surface crosses gets the quadric of its 3x3x3 block
//   field_edges.cpp   those whose quadric does not explain the block get the planes of an edge
//   field_samples.cpp the pieces of surface inside each voxel become samples
//   field_band.cpp    voxels beside the surface inherit the nearest pieces
// Each step looks but a few voxels far. So the field of a body that was cut is renewed from the one
// before (field_renewal.cpp): every step also runs on a set of voxels alone, and gives there what
// it would give if all were built anew, to the bit.
// All lengths in voxels, positions in the grid's frame (voxel (0,0,0) spans [0,1]^3).
#pragma once

#include <cloudcontact/field/surface_field.h>

#include "field/sample_set.h"
#include "field/surface_brick.h"
#include "kernels/contact/search.h"
#include "voxels/brick_grid.h"
#include "voxels/voxel_set.h"

#include <memory>
#include <vector>

namespace cloudcontact {

using SurfaceBricks = std::vector<std::shared_ptr<const SurfaceBrick>>;

// The surface as far as it is known; null where a brick has none. Bricks that came from an earlier
// field are shared with it until they are written to.
class FieldDraft {
 public:
  FieldDraft(const Cloud& wholeCloud, const FieldSettings& how, SurfaceBricks before = {});

  const Cloud& cloud;
  const FieldSettings& settings;

  const SurfaceBrick* brick(std::size_t t) const { return bricks_[t].get(); }
  const SurfaceBricks& bricks() const { return bricks_; }
  // A brick of the draft's own, made or copied where it is not yet. Distinct bricks may be written
  // to by different threads.
  SurfaceBrick& write(std::size_t t);
  void compact();                                   // what was written; bricks without voxels go
  std::vector<std::int32_t> surfaceBricks() const;  // numbers of those that have voxels, rising
  Eigen::Vector3i cornerOf(std::size_t t) const;    // lowest voxel of a brick
  // A voxel's pieces before a pass; nothing outside the grid.
  VoxelState at(int x, int y, int z, int pass = kAfterAll) const {
    if (x < 0 || y < 0 || z < 0 || x >= size_.x() || y >= size_.y() || z >= size_.z()) return {};
    const SurfaceBrick* const b = bricks_[brickOf(x, y, z)].get();
    return b ? b->state((x & 7) | (y & 7) << 3 | (z & 7) << 6, pass) : VoxelState{};
  }
  std::size_t brickOf(int x, int y, int z) const {
    return static_cast<std::size_t>(x >> 3) +
           nx_ * (static_cast<std::size_t>(y >> 3) + ny_ * static_cast<std::size_t>(z >> 3));
  }

 private:
  Eigen::Vector3i size_;
  std::size_t nx_, ny_;
  SurfaceBricks bricks_;
  std::vector<SurfaceBrick*> own_;  // null: shared, or not there
};

// The coverage of the 3x3x3 block about a voxel, 0..1.
void gatherBlock(const Cloud& cloud, int x, int y, int z, float* coverage);

void fitSurfaceVoxels(FieldDraft& draft);
// Only `where`; returns the voxels whose quadric came, went or changed.
VoxelSet refitSurfaceVoxels(FieldDraft& draft, const VoxelSet& where);

void resolveEdges(FieldDraft& draft);
// After refitSurfaceVoxels(draft, refitted) = changed; `before` as the draft began. Returns the
// voxels whose pieces came, went or changed.
VoxelSet resolveEdgesAgain(FieldDraft& draft, const SurfaceBricks& before, const VoxelSet& refitted,
                           VoxelSet changed);

// The samples of all voxels, or of `of`. Also tells the pieces their areas.
std::vector<CutSample> cutSamples(FieldDraft& draft, const VoxelSet* of = nullptr);

// A brick of the finished band. A voxel without a plane is far outside, or, where its `b` is this,
// deeper inside than the band reaches. Records of several planes count them from the brick's first.
constexpr std::uint32_t kDeepInside = CC_DEEP_INSIDE;
struct BandBrick {
  std::array<CcVoxel, kBrickVoxels> cells;
  std::vector<CcVoxel> planes;
};

// A band's brick wherever it is kept: `first` is what its records take for the number of its first
// plane. No cells: not a brick of the band.
struct BandView {
  const CcVoxel* cells = nullptr;
  const CcVoxel* planes = nullptr;
  std::uint32_t planeCount = 0, first = 0;
};

// The bricks that were made: index into `bricks`, kNoBand, or kAsBefore for one that is as it was.
constexpr std::int32_t kNoBand = -1, kAsBefore = -2;
constexpr int kBandReach = 5;  // [voxels] no record is made of pieces farther away than this
struct Band {
  std::vector<std::int32_t> table;
  std::vector<BandBrick> bricks;
};
Band spreadBand(const FieldDraft& draft);
// Only the bricks that hold voxels of `where`, and of these all that lies outside it as it was.
class FieldData;
Band spreadBandAgain(const FieldDraft& draft, const VoxelSet& where, const FieldData& before);

}  // namespace cloudcontact
