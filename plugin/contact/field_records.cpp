// Records for every brick: the band's own, or a constant one by what fills the brick and where the
// band is near.
#include "field_records.h"

#include <map>

namespace cloudcontact {

namespace {

constexpr int kBlocks = 8;  // of 4x4x4 voxels in a brick, x fastest

int blockOf(int cell) {
  return (cell >> 2 & 1) | (cell >> 4 & 2) | (cell >> 6 & 4);
}

}  // namespace

struct FieldRecords::Builder {
  const Cloud& cloud;
  const BrickGrid<CcVoxel>& grid;
  std::vector<std::uint8_t> near;  // of each brick, a bit for each block
  std::map<int, std::int32_t> constant;

  Eigen::Vector3i brickAt(std::size_t t) const {
    const int b = static_cast<int>(t), nx = grid.bricks().x(), ny = grid.bricks().y();
    return {b % nx, b / nx % ny, b / nx / ny};
  }
  bool inside(const Eigen::Vector3i& low, int cell) const {
    return cloud.coverage(low.x() + (cell & 7), low.y() + (cell >> 3 & 7), low.z() + (cell >> 6)) >
           127;
  }

  // Blocks that hold band voxels, and their 26 neighbours.
  void markNear() {
    near.assign(grid.table().size(), 0);
    for (std::size_t t = 0; t < near.size(); ++t) {
      if (grid.table()[t] < 0) continue;
      int held = 0;
      const auto& cells = grid.cells()[static_cast<std::size_t>(grid.table()[t])];
      for (int k = 0; k < kBrickVoxels; ++k)
        if (ccPlaneCount(cells[static_cast<std::size_t>(k)]) > 0) held |= 1 << blockOf(k);
      for (int block = 0; block < kBlocks; ++block)
        if (held >> block & 1) markAround(brickAt(t), block);
    }
  }

  void markAround(const Eigen::Vector3i& brick, int block) {
    for (int k = 0; k < 27; ++k) {
      const int x = brick.x() * 8 + (block & 1) * 4 + (k % 3 - 1) * 4,
                y = brick.y() * 8 + (block >> 1 & 1) * 4 + (k / 3 % 3 - 1) * 4,
                z = brick.z() * 8 + (block >> 2) * 4 + (k / 9 - 1) * 4;
      if (!grid.contains(x, y, z)) continue;
      near[grid.tableIndex(x, y, z)] |=
          static_cast<std::uint8_t>(1 << ((x >> 2 & 1) | (y >> 1 & 2) | (z & 4)));
    }
  }

  CcVoxel plain(const Eigen::Vector3i& low, int cell, int mask) const {
    if (inside(low, cell)) return {0, kDeepInside};
    return {0, mask >> blockOf(cell) & 1 ? kNearOutside : 0};
  }

  // A brick without planes: one of its own only where it is inside in part.
  std::int32_t plainBrick(std::size_t t, std::vector<CcVoxel>& records, bool& solid) {
    const Eigen::Vector3i low = brickAt(t) * kBrickEdge;
    const std::int32_t stored = cloud.voxels().table[t];
    int full = stored == kSolidBrick ? kBrickVoxels : 0;
    if (stored >= 0)
      for (int k = 0; k < kBrickVoxels; ++k) full += inside(low, k);
    solid = full > 0;
    const bool mixed = full > 0 && full < kBrickVoxels;
    const int kind = full == kBrickVoxels ? 256 : near[t];
    if (!mixed)
      if (const auto known = constant.find(kind); known != constant.end()) return known->second;
    const std::int32_t first = static_cast<std::int32_t>(records.size());
    for (int k = 0; k < kBrickVoxels; ++k) records.push_back(plain(low, k, near[t]));
    if (!mixed) constant[kind] = first;
    return first;
  }

  std::int32_t bandBrick(std::size_t t, std::vector<CcVoxel>& records) const {
    const std::int32_t first = static_cast<std::int32_t>(records.size());
    const auto& cells = grid.cells()[static_cast<std::size_t>(grid.table()[t])];
    for (int k = 0; k < kBrickVoxels; ++k) {
      CcVoxel v = cells[static_cast<std::size_t>(k)];
      if (ccPlaneCount(v) == 0 && v.b != kDeepInside && near[t] >> blockOf(k) & 1)
        v.b = kNearOutside;
      records.push_back(v);
    }
    return first;
  }
};

FieldRecords::FieldRecords(const Cloud& cloud, Band& band,
                           const std::vector<std::uint8_t>& distance) {
  Builder builder{cloud, band.grid, {}, {}};
  builder.markNear();
  const Eigen::Vector3i n = band.grid.bricks();
  bricks_ = {n.x(), n.y(), n.z()};
  const std::size_t all = band.grid.table().size();
  firsts_.reserve(all + 1);
  records_.assign(kBrickVoxels, CcVoxel{0, 0});  // the outside
  records_.reserve((band.grid.cells().size() + 8) * kBrickVoxels);
  for (std::size_t t = 0; t < all; ++t) {
    bool solid = false;
    firsts_.push_back(band.grid.table()[t] >= 0 ? builder.bandBrick(t, records_)
                                                : builder.plainBrick(t, records_, solid));
    // At a Chebyshev distance of n bricks lie at least n - 1 whole bricks between.
    between_.push_back(solid ? -kBrickEdge : (static_cast<int>(distance[t]) - 1) * kBrickEdge);
  }
  firsts_.push_back(0);
  band.grid = BrickGrid<CcVoxel>(Eigen::Vector3i::Zero(), CcVoxel{0, 0});
}

CcVoxel FieldRecords::at(int x, int y, int z) const {
  if (x < 0 || y < 0 || z < 0 || x >= 8 * bricks_.nx || y >= 8 * bricks_.ny || z >= 8 * bricks_.nz)
    return {0, 0};
  const int brick = (x >> 3) + bricks_.nx * ((y >> 3) + bricks_.ny * (z >> 3));
  const int cell = (x & 7) | (y & 7) << 3 | (z & 7) << 6;
  return records_[static_cast<std::size_t>(firsts_[static_cast<std::size_t>(brick)] + cell)];
}

std::size_t FieldRecords::bytes() const {
  return records_.size() * sizeof(CcVoxel) +
         (firsts_.size() + between_.size()) * sizeof(std::int32_t);
}

}  // namespace cloudcontact
