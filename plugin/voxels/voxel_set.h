// VoxelSet: a sparse set of voxels of a grid, one bit each. Marks the voxels that an update of a
// field must visit.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

class VoxelSet {
 public:
  // One byte per row of 8 voxels along x; index y + 8 z, as a cell's index without its x.
  using Rows = std::array<std::uint8_t, kBrickVoxels / 8>;

  explicit VoxelSet(const Eigen::Vector3i& bricks);

  bool empty() const { return rows_.empty(); }
  bool has(int x, int y, int z) const;  // false outside the grid
  bool has(std::int32_t brick, int cell) const;
  void add(int x, int y, int z);      // nothing outside the grid
  void addBrick(std::int32_t brick);  // all its voxels
  void add(const VoxelSet& other);
  void remove(const VoxelSet& other);
  void keep(const VoxelSet& other);  // only what the other set holds too
  // Only voxels for which keep(brick, cell, x, y, z).
  template <typename Keep>
  void keepIf(Keep&& keep) {
    for (const std::int32_t t : listed_) {
      const Eigen::Vector3i low = cornerOf(t);
      Rows& rows = rows_[table_[t]];
      for (int cell = 0; cell < kBrickVoxels; ++cell)
        if (holds(rows, cell) &&
            !keep(t, cell, low.x() + (cell & 7), low.y() + (cell >> 3 & 7), low.z() + (cell >> 6)))
          rows[cell >> 3] &= static_cast<std::uint8_t>(~(1 << (cell & 7)));
    }
  }
  // The set with all voxels at most `reach` away along every axis; `reach` at most 8.
  VoxelSet dilated(int reach) const;

  // Indices of the bricks that may hold voxels, in ascending order.
  std::vector<std::int32_t> bricks() const;
  const Rows* find(std::int32_t brick) const;  // null where the brick holds none
  static bool holds(const Rows& rows, int cell) { return rows[cell >> 3] >> (cell & 7) & 1; }
  static int count(const Rows& rows);  // voxels

  // Calls visit(brick, cell, x, y, z) for each voxel, in ascending order of bricks and cells.
  template <typename Visit>
  void forEach(Visit&& visit) const {
    for (const std::int32_t t : bricks()) {
      const Rows& rows = *find(t);
      const Eigen::Vector3i low = cornerOf(t);
      for (int cell = 0; cell < kBrickVoxels; ++cell)
        if (holds(rows, cell))
          visit(t, cell, low.x() + (cell & 7), low.y() + (cell >> 3 & 7), low.z() + (cell >> 6));
    }
  }

 private:
  Eigen::Vector3i cornerOf(std::int32_t brick) const;
  Rows& make(int x, int y, int z);  // allocates the brick at these indices if needed
  VoxelSet stretched(int axis, int reach) const;

  Eigen::Vector3i bricks_;
  std::vector<std::int32_t> table_;   // brick -> index into rows_; -1: none
  std::vector<std::int32_t> listed_;  // allocated bricks
  std::vector<Rows> rows_;
};

}  // namespace cloudcontact
