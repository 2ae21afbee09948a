// Last step of the field: the band in the layout that searches read. Every voxel of the grid, and
// the outside, leads to a record without a branch. Bricks without surface share constant ones.
#pragma once

#include "base/grid_index.h"
#include "base/large_memory.h"
#include "field/field_band.h"
#include "kernels/contact/search.h"

#include <array>
#include <vector>

namespace cloudcontact {

class FieldRecords {
 public:
  FieldRecords() = default;  // to be filled by forEachArray() and complete()
  // `before` holds the bricks that the band marks kAsBefore; null if there are none.
  FieldRecords(const Cloud& cloud, const Band& band, const FieldRecords* before);

  CcBricks bricks() const { return bricks_; }
  // Index of each brick's first record; the last entry is the outside's.
  const std::int32_t* firsts() const { return firsts_.data(); }
  const CcVoxel* records() const { return records_.data(); }
  std::size_t size() const { return records_.size(); }
  // Of a brick with records of its own (held()).
  const CcVoxel& bandRecord(std::size_t brick, int cell) const {
    return records_[static_cast<std::size_t>(firsts_[brick] + cell)];
  }
  CcVoxel& bandRecord(std::size_t brick, int cell) {
    return records_[static_cast<std::size_t>(firsts_[brick] + cell)];
  }
  // The records of any brick; a brick without planes may share them.
  const CcVoxel* brick(std::size_t brick) const { return records_.data() + firsts_[brick]; }
  // Gives a brick without planes records of its own, or those of the outside.
  void setBrick(std::size_t brick, const std::array<CcVoxel, kBrickVoxels>& records);
  void setOutside(std::size_t brick) { firsts_[brick] = firsts_.back(); }
  // Planes of the records that have several.
  const LargeVector<CcVoxel>& planes() const { return planes_; }
  // Distance of each brick to the nearest brick of the band, in bricks (Chebyshev), 255 at most.
  const std::vector<std::uint8_t>& brickDistance() const { return distance_; }
  // Lower bound on the voxels between a point of each brick and the band. Negative if the band or
  // the solid may begin inside the brick.
  const std::int32_t* between() const { return between_.data(); }
  // Which blocks of 4x4x4 voxels of each brick hold voxels of the band, one bit each, x fastest.
  const std::vector<std::uint8_t>& held() const { return held_; }

  // The outside's record outside the grid.
  CcVoxel at(int x, int y, int z) const {
    const Eigen::Vector3i bricks(bricks_.nx, bricks_.ny, bricks_.nz);
    if (!insideGrid(x >> 3, y >> 3, z >> 3, bricks)) return {0, 0};
    return records_[static_cast<std::size_t>(firsts_[brickIndex(x, y, z, bricks)] +
                                             cellIndex(x, y, z))];
  }
  BandView bandBrick(std::size_t brick) const;
  std::size_t bandVoxels() const { return bandVoxels_; }
  std::size_t bytes() const;

  // All arrays in a fixed order, for files.
  template <typename Records, typename Visit>
  static void forEachArray(Records& all, Visit&& visit) {
    visit(all.records_), visit(all.planes_), visit(all.planeFirsts_), visit(all.firsts_);
    visit(all.between_), visit(all.distance_), visit(all.held_), visit(all.near_);
    visit(all.planed_);
  }
  // The rest, after all arrays are read. False if they do not fit together.
  bool complete(const Eigen::Vector3i& bricks, std::size_t bandVoxels);

 private:
  class Source;
  struct Builder;
  FieldRecords(const Cloud& cloud, const Source& source);

  CcBricks bricks_{};
  LargeVector<CcVoxel> planes_, records_;
  std::vector<std::uint32_t> planeFirsts_;  // of each brick; one more at the end
  LargeVector<std::int32_t> firsts_, between_;
  std::vector<std::uint8_t> distance_, held_;
  std::vector<std::uint8_t> near_;    // blocks that hold band voxels or touch such, as held()
  std::vector<std::int16_t> planed_;  // band voxels of each brick
  std::size_t bandVoxels_ = 0;
};

}  // namespace cloudcontact
