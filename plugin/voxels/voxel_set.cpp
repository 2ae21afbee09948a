// Rows of bits in bricks. Boxes are written row by row, and dilation works axis by axis.
#include "voxels/voxel_set.h"

#include <algorithm>
#include <bit>

#include "base/grid_index.h"

namespace cloudcontact {

VoxelSet::VoxelSet(const Eigen::Vector3i& bricks) : bricks_(bricks), table_(bricks.prod(), -1) {}

Eigen::Vector3i VoxelSet::cornerOf(std::int32_t brick) const {
  return kBrickEdge * gridCell(brick, bricks_);
}

VoxelSet::Rows& VoxelSet::make(int x, int y, int z) {
  const std::size_t brick = gridIndex(x, y, z, bricks_);
  std::int32_t& slot = table_[brick];
  if (slot < 0) {
    slot = static_cast<std::int32_t>(rows_.size());
    rows_.emplace_back();
    rows_.back().fill(0);
    listed_.push_back(static_cast<std::int32_t>(brick));
  }
  return rows_[slot];
}

const VoxelSet::Rows* VoxelSet::find(std::int32_t brick) const {
  const std::int32_t slot = table_[brick];
  return slot < 0 ? nullptr : &rows_[slot];
}

int VoxelSet::count(const Rows& rows) {
  int sum = 0;
  for (const std::uint8_t row : rows) sum += std::popcount(row);
  return sum;
}

bool VoxelSet::has(std::int32_t brick, int cell) const {
  const Rows* const rows = find(brick);
  return rows && holds(*rows, cell);
}

bool VoxelSet::has(int x, int y, int z) const {
  if (!insideGrid(x, y, z, kBrickEdge * bricks_)) return false;
  return has(static_cast<std::int32_t>(brickIndex(x, y, z, bricks_)), cellIndex(x, y, z));
}

void VoxelSet::add(int x, int y, int z) {
  if (!insideGrid(x, y, z, kBrickEdge * bricks_)) return;
  make(x >> 3, y >> 3, z >> 3)[(y & 7) | (z & 7) << 3] |= static_cast<std::uint8_t>(1 << (x & 7));
}

void VoxelSet::addBrick(std::int32_t brick) {
  const Eigen::Vector3i at = gridCell(brick, bricks_);
  make(at.x(), at.y(), at.z()).fill(0xff);
}

void VoxelSet::add(const VoxelSet& other) {
  for (const std::int32_t t : other.listed_) {
    const Eigen::Vector3i at = other.cornerOf(t) / kBrickEdge;
    Rows& own = make(at.x(), at.y(), at.z());
    const Rows& more = *other.find(t);
    for (std::size_t i = 0; i < own.size(); ++i) own[i] |= more[i];
  }
}

void VoxelSet::remove(const VoxelSet& other) {
  for (const std::int32_t t : listed_) {
    const Rows* const less = other.find(t);
    if (!less) continue;
    Rows& own = rows_[table_[t]];
    for (std::size_t i = 0; i < own.size(); ++i) own[i] &= static_cast<std::uint8_t>(~(*less)[i]);
  }
}

void VoxelSet::keep(const VoxelSet& other) {
  for (const std::int32_t t : listed_) {
    const Rows* const both = other.find(t);
    Rows& own = rows_[table_[t]];
    for (std::size_t i = 0; i < own.size(); ++i) own[i] &= both ? (*both)[i] : 0;
  }
}

namespace {

// A brick and its two neighbors along an axis, after dilation of the middle one.
struct Stretched {
  VoxelSet::Rows part[3] = {};  // low neighbor, the brick, high neighbor
};

// Along x the bits of a row move, along y and z whole rows: 1 or 8 rows to the next one.
Stretched stretch(const VoxelSet::Rows& rows, int axis, int reach) {
  Stretched result;
  if (axis == 0) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::uint32_t bits = 0;
      for (int by = -reach; by <= reach; ++by) bits |= std::uint32_t{rows[i]} << (8 + by);
      for (int k = 0; k < 3; ++k)
        result.part[k][i] = static_cast<std::uint8_t>(bits >> 8 * k & 0xff);
    }
    return result;
  }
  const int step = axis == 1 ? 1 : 8;
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
    if (rows[i] == 0) continue;
    const int at = i / step & 7, first = i - at * step;
    for (int to = at - reach + 8; to <= at + reach + 8; ++to)
      result.part[to >> 3][first + (to & 7) * step] |= rows[i];
  }
  return result;
}

bool any(const VoxelSet::Rows& rows) {
  return std::any_of(rows.begin(), rows.end(), [](std::uint8_t row) { return row != 0; });
}

}  // namespace

VoxelSet VoxelSet::stretched(int axis, int reach) const {
  VoxelSet result(bricks_);
  for (const std::int32_t t : listed_) {
    const Stretched more = stretch(*find(t), axis, reach);
    const Eigen::Vector3i low = cornerOf(t) / kBrickEdge - Eigen::Vector3i::Unit(axis);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3i at = low + k * Eigen::Vector3i::Unit(axis);
      if (!insideGrid(at.x(), at.y(), at.z(), bricks_) || !any(more.part[k])) continue;
      Rows& own = result.make(at.x(), at.y(), at.z());
      for (std::size_t i = 0; i < own.size(); ++i) own[i] |= more.part[k][i];
    }
  }
  return result;
}

VoxelSet VoxelSet::dilated(int reach) const {
  return stretched(0, reach).stretched(1, reach).stretched(2, reach);
}

std::vector<std::int32_t> VoxelSet::bricks() const {
  std::vector<std::int32_t> sorted = listed_;
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace cloudcontact
