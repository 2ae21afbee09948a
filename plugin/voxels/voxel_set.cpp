// Rows of bits in bricks. Boxes are written row by row, and dilation works axis by axis.
#include "voxels/voxel_set.h"

#include <algorithm>

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

bool VoxelSet::has(std::int32_t brick, int cell) const {
  const Rows* const rows = find(brick);
  return rows && holds(*rows, cell);
}

bool VoxelSet::has(int x, int y, int z) const {
  if (!insideGrid(x, y, z, kBrickEdge * bricks_)) return false;
  return has(static_cast<std::int32_t>(brickIndex(x, y, z, bricks_)), cellIndex(x, y, z));
}

void VoxelSet::addBox(const Eigen::Vector3i& low, const Eigen::Vector3i& high) {
  const Eigen::Vector3i first = low.cwiseMax(Eigen::Vector3i::Zero());
  const Eigen::Vector3i last = high.cwiseMin(kBrickEdge * bricks_ - Eigen::Vector3i::Constant(1));
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); x = (x | 7) + 1) {
        const int to = std::min(last.x(), x | 7) & 7;
        const int mask = (0xff >> (7 - to)) & (0xff << (x & 7));
        make(x >> 3, y >> 3, z >> 3)[(y & 7) | (z & 7) << 3] |= static_cast<std::uint8_t>(mask);
      }
}

void VoxelSet::add(const VoxelSet& other) {
  for (const std::int32_t t : other.listed_) {
    const Eigen::Vector3i at = other.cornerOf(t) / kBrickEdge;
    Rows& own = make(at.x(), at.y(), at.z());
    const Rows& more = *other.find(t);
    for (std::size_t i = 0; i < own.size(); ++i) own[i] |= more[i];
  }
}

// Dilation along one axis, by runs of bits.
VoxelSet VoxelSet::stretched(int axis, int reach) const {
  VoxelSet result(bricks_);
  const Eigen::Vector3i by = reach * Eigen::Vector3i::Unit(axis);
  for (const std::int32_t t : listed_) {
    const Rows& rows = *find(t);
    const Eigen::Vector3i corner = cornerOf(t);
    for (int row = 0; row < static_cast<int>(rows.size()); ++row) {
      const int bits = rows[row];
      const Eigen::Vector3i at = corner + Eigen::Vector3i(0, row & 7, row >> 3);
      for (int from = 0, to; from < kBrickEdge; from = to) {
        to = from + 1;
        if (!(bits >> from & 1)) continue;
        while (to < kBrickEdge && bits >> to & 1) ++to;
        result.addBox(at + Eigen::Vector3i(from, 0, 0) - by,
                      at + Eigen::Vector3i(to - 1, 0, 0) + by);
      }
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
