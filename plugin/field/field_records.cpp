// Records for every brick: the band's own, or a constant one by what fills the brick and where the
// band is near.
#include "field/field_data.h"

#include <map>

namespace cloudcontact {

namespace {

constexpr int kBlocks = 8;  // of 4x4x4 voxels in a brick, x fastest

int blockOf(int cell) {
  return (cell >> 2 & 1) | (cell >> 4 & 2) | (cell >> 6 & 4);
}

}  // namespace

BandView BandSource::view(std::size_t brick) const {
  const std::int32_t slot = band_.table[brick];
  if (slot == kNoBand) return {};
  if (slot == kAsBefore) return before_->bandBrick(brick);
  const BandBrick& b = band_.bricks[static_cast<std::size_t>(slot)];
  return {b.cells.data(), b.planes.data(), static_cast<std::uint32_t>(b.planes.size()), 0};
}

std::uint8_t BandSource::held(std::size_t brick) const {
  if (!fresh(brick)) return before_->records().held()[brick];
  const BandView b = view(brick);
  int mask = 0;
  for (int k = 0; k < kBrickVoxels && b.cells; ++k)
    if (ccPlaneCount(b.cells[k]) > 0) mask |= 1 << blockOf(k);
  return static_cast<std::uint8_t>(mask);
}

BandPlanes::BandPlanes(const BandSource& source) {
  firsts.reserve(source.size() + 1);
  for (std::size_t t = 0; t < source.size(); ++t) {
    const BandView brick = source.view(t);
    firsts.push_back(static_cast<std::uint32_t>(planes.size()));
    planes.insert(planes.end(), brick.planes, brick.planes + brick.planeCount);
  }
  firsts.push_back(static_cast<std::uint32_t>(planes.size()));
}

struct FieldRecords::Builder {
  const Cloud& cloud;
  const BandSource& source;
  const BandPlanes& planes;
  const std::vector<std::uint8_t>& held;
  std::vector<std::uint8_t> near;  // of each brick, a bit for each block
  std::map<int, std::int32_t> constant;

  Eigen::Vector3i brickAt(std::size_t t) const {
    const int b = static_cast<int>(t), nx = cloud.bricks().x(), ny = cloud.bricks().y();
    return {b % nx, b / nx % ny, b / nx / ny};
  }
  bool inside(const Eigen::Vector3i& low, int cell) const {
    return cloud.coverage(low.x() + (cell & 7), low.y() + (cell >> 3 & 7), low.z() + (cell >> 6)) >
           127;
  }

  // Blocks that hold band voxels, and their 26 neighbours.
  void markNear() {
    near.assign(held.size(), 0);
    for (std::size_t t = 0; t < near.size(); ++t)
      for (int block = 0; held[t] && block < kBlocks; ++block)
        if (held[t] >> block & 1) markAround(brickAt(t), block);
  }

  void markAround(const Eigen::Vector3i& brick, int block) {
    const Eigen::Vector3i n = 2 * cloud.bricks();
    for (int k = 0; k < 27; ++k) {
      const int x = brick.x() * 2 + (block & 1) + k % 3 - 1,
                y = brick.y() * 2 + (block >> 1 & 1) + k / 3 % 3 - 1,
                z = brick.z() * 2 + (block >> 2) + k / 9 - 1;
      if (x < 0 || y < 0 || z < 0 || x >= n.x() || y >= n.y() || z >= n.z()) continue;
      near[static_cast<std::size_t>((x >> 1) + cloud.bricks().x() *
                                                   ((y >> 1) + cloud.bricks().y() * (z >> 1)))] |=
          static_cast<std::uint8_t>(1 << ((x & 1) | (y & 1) << 1 | (z & 1) << 2));
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

  // A brick with planes: they are numbered anew, and what is near outside may have changed with the
  // bricks beside it.
  std::int32_t bandBrick(std::size_t t, const BandView& brick, std::vector<CcVoxel>& records,
                         std::size_t& bandVoxels) const {
    const std::size_t first = records.size();
    records.insert(records.end(), brick.cells, brick.cells + kBrickVoxels);
    const std::uint32_t shift = planes.firsts[t] - brick.first;
    for (int k = 0; k < kBrickVoxels; ++k) {
      CcVoxel& v = records[first + static_cast<std::size_t>(k)];
      const uint count = ccPlaneCount(v);
      bandVoxels += count > 0;
      if (count > 1)
        v.b += shift;
      else if (count == 0 && v.b != kDeepInside)
        v.b = near[t] >> blockOf(k) & 1 ? kNearOutside : 0;
    }
    return static_cast<std::int32_t>(first);
  }
};

FieldRecords::FieldRecords(const Cloud& cloud, const BandSource& source, const BandPlanes& planes,
                           const std::vector<std::uint8_t>& distance) {
  const std::size_t all = source.size();
  std::size_t bandBricks = 0;
  for (std::size_t t = 0; t < all; ++t) {
    held_.push_back(source.held(t));
    bandBricks += held_.back() > 0;
  }
  Builder builder{cloud, source, planes, held_, {}, {}};
  builder.markNear();
  const Eigen::Vector3i n = cloud.bricks();
  bricks_ = {n.x(), n.y(), n.z()};
  firsts_.reserve(all + 1);
  between_.reserve(all);
  records_.reserve((bandBricks + 8) * kBrickVoxels);
  records_.assign(kBrickVoxels, CcVoxel{0, 0});  // the outside
  for (std::size_t t = 0; t < all; ++t) {
    bool solid = false;
    firsts_.push_back(held_[t] ? builder.bandBrick(t, source.view(t), records_, bandVoxels_)
                               : builder.plainBrick(t, records_, solid));
    // At a Chebyshev distance of n bricks lie at least n - 1 whole bricks between.
    between_.push_back(solid ? -kBrickEdge : (static_cast<int>(distance[t]) - 1) * kBrickEdge);
  }
  firsts_.push_back(0);
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
         (firsts_.size() + between_.size()) * sizeof(std::int32_t) + held_.size();
}

}  // namespace cloudcontact
