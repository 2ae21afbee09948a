// A change of a voxel affects the voxels whose windows hold it: those of the mirrored window around
// it, in rows along x.
//
// Each affected brick is visited once. The changes around it are laid out in a tile, and each of
// its rows of eight voxels gathers its windows' loss from the tile, in registers, before it writes
// to the sums. Changed voxels mostly lie together, so this takes half the time of one by one.
#include "field/brick_changes.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/simd.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorBricks;

typedef double Eight __attribute__((vector_size(64)));

// The loss of a row of eight voxels' windows: sums of coverage times weight, and of that times
// position.
struct RowSums {
  Eight volume = {}, x = {}, y = {}, z = {};
};

// Adds one row of the window. `coverage`: of the voxel that the first tap of the first of the eight
// voxels weighs.
inline void addTaps(const CcMoments* taps, std::uint32_t count, const double* coverage,
                    RowSums& sums) {
  for (std::uint32_t k = 0; k < count; ++k) {
    Eight c;
    std::memcpy(&c, coverage - k, sizeof c);
    sums.volume += c * taps[k].mass;
    sums.x += c * taps[k].x;
    sums.y += c * taps[k].y;
    sums.z += c * taps[k].z;
  }
}

inline void give(const RowSums& from, double density, CcMoments* moments, CcSum* volume) {
  for (int k = 0; k < kBrickEdge; ++k) {
    moments[k].mass += density * from.volume[k];
    moments[k].x += density * from.x[k];
    moments[k].y += density * from.y[k];
    moments[k].z += density * from.z[k];
    volume[k] += from.volume[k];
  }
}

struct TileView {
  int reach, edge;
  const int *low, *high;
  const std::uint8_t* row;
  const double* coverage;
};

// Gathers for all rows of a block whose windows reach a changed row of the tile.
CC_LANES void gatherRows(const Bricks& f, const TileView& t, double density, FieldBlock& block) {
  const int r = t.reach;
  for (int z = std::max(0, t.low[1] - 2 * r); z <= std::min(kBrickEdge - 1, t.high[1]); ++z)
    for (int y = std::max(0, t.low[0] - 2 * r); y <= std::min(kBrickEdge - 1, t.high[0]); ++y) {
      RowSums sums;
      bool any = false;
      for (const WindowRow& row : f.rows) {
        const int at = (z - row.z + r) * t.edge + y - row.y + r;
        if (!t.row[at]) continue;
        any = true;
        addTaps(&f.taps[row.first], row.count, t.coverage + at * t.edge + r - row.x, sums);
      }
      const int line = cellIndex(0, y, z);
      if (any) give(sums, density, &block.moments[line], &block.volume[line]);
    }
}

// Spreads one voxel, for windows of any reach.
void spreadOne(Bricks& f, const VoxelIndex& v, double density, double coverage) {
  const double matter = density * coverage;
  for (const WindowRow& row : f.rows) {
    const int y = v.y() + row.y, z = v.z() + row.z;
    if (y < 0 || z < 0 || y >= kBrickEdge * f.bricks.y() || z >= kBrickEdge * f.bricks.z())
      continue;
    const int first = v.x() + row.x, end = first + static_cast<int>(row.count);
    for (int b = std::max(first >> 3, 0); kBrickEdge * b < end && b < f.bricks.x(); ++b) {
      std::int32_t& entry = f.entry(b, y >> 3, z >> 3);
      if (entry == kNoBlock) continue;
      FieldBlock& block = f.own(entry);
      const int low = std::max(first, kBrickEdge * b), high = std::min(end, kBrickEdge * (b + 1));
      for (int x = low; x < high; ++x) {
        const CcMoments& tap = f.taps[row.first + static_cast<std::uint32_t>(x - first)];
        const auto cell = static_cast<std::size_t>(cellIndex(x, y, z));
        CcMoments& moments = block.moments[cell];
        moments.mass += matter * tap.mass;
        moments.x += matter * tap.x;
        moments.y += matter * tap.y;
        moments.z += matter * tap.z;
        block.volume[cell] += coverage * tap.mass;
      }
    }
  }
}

// Calls visit(index, brick, offset) for the brick and its 26 neighbors inside the grid.
template <typename Visit>
void forEachAround(const Bricks& f, const Eigen::Vector3i& brick, Visit&& visit) {
  for (int k = 0; k < 27; ++k) {
    const Eigen::Vector3i aside(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1), at = brick + aside;
    if (insideGrid(at, f.bricks)) visit(gridIndex(at, f.bricks), at, aside);
  }
}

}  // namespace

void FieldChanges::prepare(const Bricks& f) {
  const int reach = std::max(-f.window.low.minCoeff(), f.window.high.maxCoeff());
  far_ = reach > kReach;
  if (far_) return;
  few_.reserve(kFew);
  changed_.resize(kBricks + kFew);
  slot_.assign(f.table.size(), -1);
  marked_.assign(f.table.size(), 0);
  affected_.reserve(27 * changed_.size());
  tile_.reach = std::max(reach, 0);
  tile_.edge = kBrickEdge + 2 * tile_.reach;
  const std::size_t rows =
      static_cast<std::size_t>(tile_.edge) * static_cast<std::size_t>(tile_.edge);
  tile_.row.resize(rows);
  tile_.coverage.resize(rows * static_cast<std::size_t>(tile_.edge));
}

void FieldChanges::add(Bricks& f, const VoxelIndex& voxel, int density, int coverage) {
  if (far_) return spreadOne(f, voxel, density, coverage);
  if (density != density_ || used_ >= kBricks) spread(f);
  density_ = density;
  if (used_ == 0 && few_.size() < kFew) return few_.push_back({voxel, coverage});
  for (const Change& change : few_) keep(change, f);
  few_.clear();
  keep({voxel, coverage}, f);
}

void FieldChanges::keep(const Change& change, const Bricks& f) {
  const Eigen::Vector3i brick = change.voxel / kBrickEdge;
  std::int8_t& slot = slot_[gridIndex(brick, f.bricks)];
  if (slot < 0) {
    slot = static_cast<std::int8_t>(used_);
    Changed& fresh = changed_[used_++];
    fresh.brick = brick;
    fresh.rows = 0;
    std::memset(fresh.coverage, 0, sizeof fresh.coverage);
  }
  Changed& to = changed_[static_cast<std::size_t>(slot)];
  const int cell = cellIndex(change.voxel);
  to.rows |= std::uint64_t{1} << (cell >> 3);
  to.coverage[cell] += change.coverage;
}

// The bricks with material whose windows may hold a change.
void FieldChanges::findAffected(const Bricks& f) {
  affected_.clear();
  for (std::size_t k = 0; k < used_; ++k)
    forEachAround(f, changed_[k].brick,
                  [&](std::size_t index, const Eigen::Vector3i& at, const auto&) {
                    if (marked_[index] || f.table[index] == kNoBlock) return;
                    marked_[index] = 1;
                    affected_.push_back(at);
                  });
}

// Copies the changed rows of a brick at offset `aside` from the tile's.
void FieldChanges::copyRows(const Changed& from, const Eigen::Vector3i& aside) {
  const int r = tile_.reach, edge = tile_.edge;
  const int begin = aside.x() < 0 ? kBrickEdge - r : 0;
  const int count = aside.x() == 0 ? kBrickEdge : r;
  const int to = aside.x() < 0 ? 0 : aside.x() == 0 ? r : r + kBrickEdge;
  for (std::uint64_t left = from.rows; left != 0; left &= left - 1) {
    const int row = std::countr_zero(left);
    const int place[2] = {kBrickEdge * aside.y() + (row & 7) + r,
                          kBrickEdge * aside.z() + (row >> 3) + r};
    if (std::min(place[0], place[1]) < 0 || std::max(place[0], place[1]) >= edge) continue;
    const double* const values = from.coverage + kBrickEdge * row + begin;
    if (std::all_of(values, values + count, [](double c) { return c == 0; })) continue;
    const int at = place[1] * edge + place[0];
    std::uint8_t& seen = tile_.row[static_cast<std::size_t>(at)];
    double* const coverage = &tile_.coverage[static_cast<std::size_t>(at * edge)];
    if (!seen) {
      std::fill_n(coverage, edge, 0.0);
      seen = 1;
    }
    std::copy_n(values, count, coverage + to);
    for (int i = 0; i < 2; ++i) {
      tile_.low[i] = std::min(tile_.low[i], place[i]);
      tile_.high[i] = std::max(tile_.high[i], place[i]);
    }
  }
}

// Lays out the tile of a brick. False if nothing in it changed.
bool FieldChanges::gather(const Eigen::Vector3i& brick, const Bricks& f) {
  std::fill(tile_.row.begin(), tile_.row.end(), std::uint8_t{0});
  for (int i = 0; i < 2; ++i) {
    tile_.low[i] = tile_.edge;
    tile_.high[i] = -1;
  }
  forEachAround(f, brick, [&](std::size_t index, const auto&, const Eigen::Vector3i& aside) {
    if (slot_[index] >= 0) copyRows(changed_[static_cast<std::size_t>(slot_[index])], aside);
  });
  return tile_.high[0] >= 0;
}

void FieldChanges::spread(Bricks& f) {
  for (const Change& change : few_) spreadOne(f, change.voxel, density_, change.coverage);
  few_.clear();
  if (used_ > 0) spreadTogether(f);
}

void FieldChanges::spreadTogether(Bricks& f) {
  findAffected(f);
  for (const Eigen::Vector3i& brick : affected_) {
    const std::size_t index = gridIndex(brick, f.bricks);
    marked_[index] = 0;
    if (!gather(brick, f)) continue;  // its block stays shared
    FieldBlock& block = f.own(f.table[index]);
    gatherRows(
        f,
        {tile_.reach, tile_.edge, tile_.low, tile_.high, tile_.row.data(), tile_.coverage.data()},
        density_, block);
  }
  for (std::size_t k = 0; k < used_; ++k) slot_[gridIndex(changed_[k].brick, f.bricks)] = -1;
  used_ = 0;
}

}  // namespace cloudcontact
