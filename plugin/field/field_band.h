// Fifth step of the field: the band. Each voxel of the layers becomes a record of one plane, or of
// several where the nearest pieces meet in a convex edge or lie back to back (a thin wall). There
// the depth is the least over the planes, the distance to the outside of the body.
#pragma once

#include "field/field_layers.h"
#include "kernels/contact/field_voxel.h"

#include <functional>

namespace cloudcontact {

// A brick of the band. A voxel without planes is far outside, or deeper inside than the band
// reaches if its `b` is CC_DEEP_INSIDE. Records of several planes count them from the brick's
// first.
struct BandBrick {
  std::array<CcVoxel, kBrickVoxels> cells;
  std::vector<CcVoxel> planes;
};

// A brick of the band wherever it is stored. `first` is the index that its records use for its
// first plane. No cells: not a brick of the band.
struct BandView {
  const CcVoxel* cells = nullptr;
  const CcVoxel* planes = nullptr;
  std::uint32_t planeCount = 0, first = 0;
};

constexpr std::int32_t kNoBand = -1, kAsBefore = -2;
struct Band {
  std::vector<std::int32_t> table;  // by brick: index into `bricks`, kNoBand, or kAsBefore
  std::vector<BandBrick> bricks;
};

Band writeBand(const FieldDraft& draft, const FieldLayers& layers);
// Recomputes the voxels of `scope` only. The other voxels of its bricks are copied from `before`,
// which returns a brick of the earlier band; all other bricks are kAsBefore.
Band renewBand(const FieldDraft& draft, const FieldLayers& layers, const VoxelSet& scope,
               const std::function<BandView(std::size_t brick)>& before);

}  // namespace cloudcontact
