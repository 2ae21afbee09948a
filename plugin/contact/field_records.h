// The band as a search reads it: every voxel of the grid, and the outside, leads to a record
// without a branch. Bricks without a surface share constant ones.
#pragma once

#include "field_builder.h"
#include "look_up.h"

#include <vector>

namespace cloudcontact {

// What `b` of a record without planes says, beside kDeepInside (field_builder.h): empty, and a
// voxel of the band lies within four.
constexpr std::uint32_t kNearOutside = 2;

class FieldRecords {
 public:
  // Moves the band's bricks here. `distance`: bricks from each brick to the band's nearest.
  FieldRecords(const Cloud& cloud, Band& band, const std::vector<std::uint8_t>& distance);

  CcBricks bricks() const { return bricks_; }
  // A brick's first record; the last entry is the outside's.
  const std::int32_t* firsts() const { return firsts_.data(); }
  const CcVoxel* records() const { return records_.data(); }
  // Voxels at least between a point of this brick and the band, negative where the band or the
  // solid may begin in it.
  const std::int32_t* between() const { return between_.data(); }
  CcVoxel at(int x, int y, int z) const;
  std::size_t bytes() const;

 private:
  struct Builder;
  CcBricks bricks_{};
  std::vector<std::int32_t> firsts_, between_;
  std::vector<CcVoxel> records_;
};

}  // namespace cloudcontact
