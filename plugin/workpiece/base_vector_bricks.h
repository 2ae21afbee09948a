// How a BaseVectorField lies in memory: blocks of 8x8x8 voxels. Bricks without matter have none;
// those so deep inside one tissue that every window in them is full share that tissue's.
#pragma once

#include <cloudcontact/workpiece/base_vector_field.h>

#include <array>
#include <vector>

#include "kernels/digitize/window_sums.h"
#include "workpiece/brick_changes.h"
#include "workpiece/depth_table.h"

namespace cloudcontact {

struct FieldBlock {
  alignas(64) std::array<CcMoments, kBrickVoxels> moments;  // of matter
  alignas(64) std::array<CcSum, kBrickVoxels> volume;       // sum of weight * coverage
  BrickCoverage coverage;
  BrickMaterial tissue;
};

// A row of the window along x, turned round the voxel: whom a change of this voxel concerns.
struct WindowRow {
  int x, y, z;  // of its first voxel, seen from the one that changes
  std::uint32_t first,
      count;  // into taps
};

// Of one tissue: sums over its voxels of coverage times powers of their indices, seen from
// the grid's middle. Integers, so that what is taken away leaves what a new sum would give.
struct TissueSums {
  std::int64_t zeroth = 0, first[3] = {0, 0, 0},
               second[6] = {0, 0, 0, 0, 0, 0};  // xx yy zz xy yz zx
  void add(const VoxelIndex& fromMiddle, std::int64_t coverage);
};

// By the tissues' densities and sums.
MassProperties massOf(const BaseVectorField::Bricks& field, const std::vector<TissueSums>& sums);

constexpr std::int32_t kNoBlock = -1;

struct BaseVectorField::Bricks {
  double voxelSize = 0;
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();
  std::vector<std::int32_t> table;  // of each brick, x fastest: a block or kNoBlock
  std::vector<FieldBlock> blocks;   // the first tissues.size() are the shared ones
  TissueTable tissues;
  std::vector<int> density;        // of each tissue [1/CC_DENSEST of the densest]
  std::vector<std::string> names;  // of the cloud's materials, empty where it had none
  Window window;
  Vec3 windowCenter = Vec3::Zero();  // [voxels]
  double perFull = 0;                // 1 / (255 * the window's weights)
  std::vector<WindowRow> rows;
  std::vector<CcMoments> taps;  // row by row
  std::vector<TissueSums> sums;
  DepthTable depths;
  FieldChanges changes;

  std::int32_t& entry(int bx, int by, int bz) {
    return table[static_cast<std::size_t>(bx) +
                 static_cast<std::size_t>(bricks.x()) *
                     (static_cast<std::size_t>(by) +
                      static_cast<std::size_t>(bricks.y()) * static_cast<std::size_t>(bz))];
  }
  std::int32_t entry(int bx, int by, int bz) const {
    return const_cast<Bricks*>(this)->entry(bx, by, bz);
  }
  bool contains(const VoxelIndex& v) const {
    return (v.array() >= 0).all() && (v.array() < kBrickEdge * bricks.array()).all();
  }
  static int cell(int x, int y, int z) { return (x & 7) | (y & 7) << 3 | (z & 7) << 6; }
  // Null outside the grid and in bricks without matter.
  const FieldBlock* blockOf(const VoxelIndex& v) const {
    if (!contains(v)) return nullptr;
    const std::int32_t b = entry(v.x() >> 3, v.y() >> 3, v.z() >> 3);
    return b == kNoBlock ? nullptr : &blocks[static_cast<std::size_t>(b)];
  }
  // The block of a brick with matter, its own from now on: a shared one is copied.
  FieldBlock& own(std::int32_t& entry) {
    if (static_cast<std::size_t>(entry) < tissues.size()) {
      blocks.push_back(FieldBlock(blocks[static_cast<std::size_t>(entry)]));
      entry = static_cast<std::int32_t>(blocks.size() - 1);
    }
    return blocks[static_cast<std::size_t>(entry)];
  }
  // What the sums say of a voxel with matter: Gr - Gc and the window's centre of gravity when full
  // less Gc, in voxels, and the share of the window that is matter.
  struct Weighed {
    Vec3 toRepresentative, outward;
    double fraction;
  };
  Weighed weigh(const FieldBlock& block, int cell) const {
    const CcMoments& m = block.moments[static_cast<std::size_t>(cell)];
    if (m.mass <= 0) return {Vec3::Zero(), Vec3::Zero(), 0};
    const double scale = 1 / m.mass;
    const Vec3 center(m.x * scale, m.y * scale, m.z * scale);
    return {window.representative - center, windowCenter - center,
            block.volume[static_cast<std::size_t>(cell)] * perFull};
  }
};

}  // namespace cloudcontact
