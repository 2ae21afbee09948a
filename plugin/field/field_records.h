// The band as a search reads it: every voxel of the grid, and the outside, leads to a record
// without a branch. Bricks without a surface share constant ones.
#pragma once

#include "field/field_builder.h"
#include "kernels/contact/search.h"

#include <vector>

namespace cloudcontact {

// What `b` of a record without planes says, beside kDeepInside (field_builder.h): empty, and a
// voxel of the band lies within four.
constexpr std::uint32_t kNearOutside = CC_NEAR_OUTSIDE;

// Where a band's bricks are: fresh ones, and those of an earlier field.
class BandSource {
 public:
  // `before` is where kept bricks are; null where there is none.
  BandSource(const Band& band, const FieldData* before) : band_(band), before_(before) {}

  std::size_t size() const { return band_.table.size(); }
  BandView view(std::size_t brick) const;
  bool fresh(std::size_t brick) const { return band_.table[brick] != kAsBefore; }
  // Which blocks of 4x4x4 voxels of the brick hold voxels of the band, a bit each, x fastest.
  std::uint8_t held(std::size_t brick) const;

 private:
  const Band& band_;
  const FieldData* before_;
};

// The planes that records of several lead to, brick by brick.
struct BandPlanes {
  std::vector<CcVoxel> planes;
  std::vector<std::uint32_t> firsts;  // of each brick; one more at the end

  explicit BandPlanes(const BandSource& source);
};

class FieldRecords {
 public:
  // `distance`: bricks from each brick to the band's nearest.
  FieldRecords(const Cloud& cloud, const BandSource& source, const BandPlanes& planes,
               const std::vector<std::uint8_t>& distance);

  CcBricks bricks() const { return bricks_; }
  // A brick's first record; the last entry is the outside's.
  const std::int32_t* firsts() const { return firsts_.data(); }
  const CcVoxel* records() const { return records_.data(); }
  std::size_t size() const { return records_.size(); }
  // Voxels at least between a point of this brick and the band, negative where the band or the
  // solid may begin in it.
  const std::int32_t* between() const { return between_.data(); }
  CcVoxel at(int x, int y, int z) const;
  std::size_t bandVoxels() const { return bandVoxels_; }
  // BandSource::held() of each brick.
  const std::vector<std::uint8_t>& held() const { return held_; }
  std::size_t bytes() const;

 private:
  struct Builder;
  CcBricks bricks_{};
  std::vector<std::int32_t> firsts_, between_;
  std::vector<CcVoxel> records_;
  std::vector<std::uint8_t> held_;
  std::size_t bandVoxels_ = 0;
};

}  // namespace cloudcontact
