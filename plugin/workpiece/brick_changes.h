// Matter that a cut takes, gathered brick by brick until it is taken from the sums of all windows
// that it lay in.
#pragma once

#include <cloudcontact/workpiece/base_vector_field.h>

#include <cstdint>
#include <vector>

namespace cloudcontact {

class FieldChanges {
 public:
  // Before the first change, once the field's window and table are known.
  void prepare(const BaseVectorField::Bricks& field);
  // The voxel's coverage grows by as much (shrinks where negative), of matter of this density. Its
  // brick has a block. What came before is spread where there is no more room, or it was of another
  // density.
  void add(BaseVectorField::Bricks& field, const VoxelIndex& voxel, int density, int coverage);
  // Into all windows; nothing is left to spread. Allocates only blocks for bricks that shared one.
  void spread(BaseVectorField::Bricks& field);

 private:
  static constexpr std::size_t kBricks = 64;  // changed ones that there is room for
  static constexpr int kReach = 8;  // [voxels] of a window that one brick beside is enough for
  // Changes that are sooner spread one by one. A bur's lie apart: with 16 a haptic tick's p99 was
  // 130 us, with 64 to 256 it is 78.
  static constexpr std::size_t kFew = 64;

  struct Change {
    VoxelIndex voxel;
    int coverage;
  };
  struct Changed {
    Eigen::Vector3i brick;
    std::uint64_t rows = 0;  // those along x that changed, a bit each
    double coverage[kBrickVoxels];
  };
  // The changes about one brick, out to where its windows reach.
  struct Tile {
    int reach = 0, edge = 0;        // edge: of its rows, and how many there are each way
    int low[2] = {}, high[2] = {};  // of the rows that changed, along y and z
    std::vector<std::uint8_t> row;  // 1: it changed
    std::vector<double> coverage;
  };

  void keep(const Change& change, const BaseVectorField::Bricks& field);
  void spreadTogether(BaseVectorField::Bricks& field);
  void findAffected(const BaseVectorField::Bricks& field);
  bool gather(const Eigen::Vector3i& brick, const BaseVectorField::Bricks& field);
  void copyRows(const Changed& from, const Eigen::Vector3i& aside);

  bool far_ = false;  // windows reach beyond the bricks beside: every voxel is spread by itself
  int density_ = 0;
  std::vector<Change> few_;       // the first ones, up to kFew
  std::vector<Changed> changed_;  // the first used_ of them, once there are more
  std::size_t used_ = 0;
  std::vector<std::int8_t> slot_;     // of each brick, -1: it did not change
  std::vector<std::uint8_t> marked_;  // of each brick: it is in affected_
  std::vector<Eigen::Vector3i> affected_;
  Tile tile_;
};

}  // namespace cloudcontact
