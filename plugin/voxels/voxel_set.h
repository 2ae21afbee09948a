// A sparse set of a grid's voxels, a bit each: what a renewal of a field has to look at again.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

class VoxelSet {
 public:
  // A byte for each row of 8 voxels along x; index y + 8 z, as a cell's number without its x.
  using Rows = std::array<std::uint8_t, kBrickVoxels / 8>;

  explicit VoxelSet(const Eigen::Vector3i& bricks);

  bool empty() const { return rows_.empty(); }
  bool has(int x, int y, int z) const;  // false outside the grid
  bool has(std::int32_t brick, int cell) const;
  void add(int x, int y, int z) { addBox({x, y, z}, {x, y, z}); }
  // All from `low` to `high`, both included, as far as they lie in the grid.
  void addBox(const Eigen::Vector3i& low, const Eigen::Vector3i& high);
  void add(const VoxelSet& other);
  // With all voxels at most `reach` from one of the set along every axis.
  VoxelSet dilated(int reach) const;

  // Numbers of the bricks that may hold voxels (x fastest), rising.
  std::vector<std::int32_t> bricks() const;
  const Rows* find(std::int32_t brick) const;  // null: none of the brick's
  static bool holds(const Rows& rows, int cell) {
    return rows[static_cast<std::size_t>(cell >> 3)] >> (cell & 7) & 1;
  }

  // Calls visit(brick, cell, x, y, z) for all, brick by brick in the order of their numbers.
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
  Rows& make(int x, int y, int z);  // of the brick with these indices
  VoxelSet stretched(int axis, int reach) const;

  Eigen::Vector3i bricks_;
  std::vector<std::int32_t> table_;  // brick -> rows_, -1: none
  std::vector<std::int32_t> listed_;
  std::vector<Rows> rows_;
};

}  // namespace cloudcontact
