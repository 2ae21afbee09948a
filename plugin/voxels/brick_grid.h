// BrickGrid: a sparse grid of values per voxel, in 8x8x8 bricks that are allocated on the first
// write. Its bricks align with those of a cloud.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <array>
#include <vector>

#include "base/grid_index.h"

namespace cloudcontact {

template <typename Cell>
class BrickGrid {
 public:
  BrickGrid(const Eigen::Vector3i& bricks, const Cell& empty)
      : bricks_(bricks), empty_(empty), table_(bricks.prod(), -1) {}

  const Eigen::Vector3i& bricks() const { return bricks_; }
  bool contains(int x, int y, int z) const { return insideGrid(x, y, z, kBrickEdge * bricks_); }
  std::size_t tableIndex(int x, int y, int z) const { return brickIndex(x, y, z, bricks_); }
  // A voxel's value; the empty value outside the grid and in bricks that were never written.
  const Cell& at(int x, int y, int z) const {
    if (!contains(x, y, z)) return empty_;
    const std::int32_t brick = table_[tableIndex(x, y, z)];
    return brick < 0 ? empty_ : cells_[brick][cellIndex(x, y, z)];
  }
  // A pointer to a voxel's value; null outside the grid and in bricks that were never written.
  const Cell* find(int x, int y, int z) const {
    if (!contains(x, y, z)) return nullptr;
    const std::int32_t brick = table_[tableIndex(x, y, z)];
    return brick < 0 ? nullptr : &cells_[brick][cellIndex(x, y, z)];
  }
  // A reference to a voxel's value, whose brick is allocated if needed. The voxel must be in the
  // grid.
  Cell& make(int x, int y, int z) {
    std::int32_t& brick = table_[tableIndex(x, y, z)];
    if (brick < 0) {
      brick = static_cast<std::int32_t>(cells_.size());
      cells_.emplace_back();
      cells_.back().fill(empty_);
    }
    return cells_[brick][cellIndex(x, y, z)];
  }
  const std::vector<std::int32_t>& table() const { return table_; }
  std::vector<std::array<Cell, kBrickVoxels>>& cells() { return cells_; }
  const std::vector<std::array<Cell, kBrickVoxels>>& cells() const { return cells_; }

 private:
  Eigen::Vector3i bricks_;
  Cell empty_;
  std::vector<std::int32_t> table_;
  std::vector<std::array<Cell, kBrickVoxels>> cells_;
};

}  // namespace cloudcontact
