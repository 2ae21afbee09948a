// Collects the changes of a cut, brick by brick, and applies them to the sums of all windows that
// hold a changed voxel.
#pragma once

#include <cstdint>
#include <vector>

#include "field/base_vector_bricks.h"

namespace cloudcontact {

class FieldChanges {
 public:
  // Must be called before the first change, with the field's window and table.
  void prepare(const BaseVectorBricks& field);
  // Adds `coverage` of this density to the voxel (negative: removes), whose brick has a block.
  // Spreads the changes so far first if they are of another density or there is no more room.
  void add(BaseVectorBricks& field, const VoxelIndex& voxel, int density, int coverage);
  // Applies all changes to the windows. Allocates only blocks for bricks that shared one.
  void spread(BaseVectorBricks& field);

 private:
  static constexpr std::size_t kBricks = 64;  // most changed bricks
  static constexpr int kReach = 8;  // of windows that end in the neighboring bricks [voxels]
  // Up to so many changes are spread one by one: those of a bur lie apart.
  static constexpr std::size_t kFew = 64;

  struct Change {
    VoxelIndex voxel;
    int coverage;
  };
  struct Changed {
    Eigen::Vector3i brick;
    std::uint64_t rows = 0;  // a bit for each row along x: 1 if it changed
    double coverage[kBrickVoxels];
  };
  // The changes in and around a brick, as far as its windows reach.
  struct Tile {
    int reach = 0, edge = 0;        // edge: voxels along each axis
    int low[2] = {}, high[2] = {};  // range of the rows that changed, along y and z
    std::vector<std::uint8_t> row;  // 1 if it changed
    std::vector<double> coverage;
  };

  void keep(const Change& change, const BaseVectorBricks& field);
  void spreadTogether(BaseVectorBricks& field);
  void findAffected(const BaseVectorBricks& field);
  bool gather(const Eigen::Vector3i& brick, const BaseVectorBricks& field);
  void copyRows(const Changed& from, const Eigen::Vector3i& aside);

  bool far_ = false;  // windows reach beyond neighboring bricks: voxels are spread one by one
  int density_ = 0;
  std::vector<Change> few_;       // up to kFew changes
  std::vector<Changed> changed_;  // if there are more; the first used_ are valid
  std::size_t used_ = 0;
  std::vector<std::int8_t> slot_;     // of each brick in changed_, or -1
  std::vector<std::uint8_t> marked_;  // of each brick: 1 if it is in affected_
  std::vector<Eigen::Vector3i> affected_;
  Tile tile_;
};

}  // namespace cloudcontact
