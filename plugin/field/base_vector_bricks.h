// A BaseVectorField's memory: blocks of 8x8x8 voxels. Bricks without material have none; bricks so
// deep inside one tissue that all their windows are full share that tissue's block.
#pragma once

#include <cloudcontact/field/window.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "base/grid_index.h"
#include "base/large_memory.h"
#include "field/depth_table.h"
#include "kernels/digitize/window_sums.h"

namespace cloudcontact {

// The voxels of a brick and the sums of their windows.
struct FieldBlock {
  alignas(64) std::array<CcMoments, kBrickVoxels> moments;  // of material
  alignas(64) std::array<CcSum, kBrickVoxels> volume;       // sum of weight * coverage
  BrickCoverage coverage;
  BrickMaterial tissue;
};
static_assert(sizeof(FieldBlock) == sizeof(CcBlock) &&
              offsetof(FieldBlock, volume) == offsetof(CcBlock, volume) &&
              offsetof(FieldBlock, coverage) == offsetof(CcBlock, coverage) &&
              offsetof(FieldBlock, tissue) == offsetof(CcBlock, tissue));

// A row along x of the mirrored window: the voxels whose windows hold the voxel in its middle.
struct WindowRow {
  int x, y, z;                 // of its first voxel, from the middle
  std::uint32_t first, count;  // into taps
};

constexpr std::int32_t kNoBlock = -1;

struct BaseVectorBricks {
  double voxelSize = 0;                              // [m]
  Vec3 origin = Vec3::Zero();                        // [m]
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();  // along each axis
  std::vector<std::int32_t> table;                   // block of each brick, or kNoBlock
  LargeVector<FieldBlock> blocks;                    // the first tissues.size() are shared
  TissueTable tissues;
  std::vector<int> density;        // of each tissue, the densest's is CC_DENSEST
  std::vector<std::string> names;  // of the cloud's materials; empty where it has none
  Window window;
  Vec3 windowCenter = Vec3::Zero();  // [voxels]
  double perFull = 0;                // 1 / (255 * the window's weights)
  std::vector<WindowRow> rows;
  std::vector<CcMoments> taps;  // row by row
  std::vector<MatterSums>
      sums;  // of each tissue; positions are the voxels' indices from the middle
  DepthTable depths;

  // All but the voxels: the blocks are the shared ones, no brick has one.
  BaseVectorBricks withoutBlocks() const {
    BaseVectorBricks some{voxelSize, origin,       bricks,  {},   {},   tissues, density, names,
                          window,    windowCenter, perFull, rows, taps, sums,    depths};
    some.table.assign(table.size(), kNoBlock);
    some.blocks.assign(blocks.begin(),
                       blocks.begin() + static_cast<std::ptrdiff_t>(tissues.size()));
    return some;
  }

  std::int32_t& entry(int bx, int by, int bz) { return table[gridIndex(bx, by, bz, bricks)]; }
  std::int32_t entry(int bx, int by, int bz) const { return table[gridIndex(bx, by, bz, bricks)]; }
  bool contains(const VoxelIndex& v) const { return insideGrid(v, kBrickEdge * bricks); }
  // Null outside the grid and in bricks without material.
  const FieldBlock* blockOf(const VoxelIndex& v) const {
    if (!contains(v)) return nullptr;
    const std::int32_t b = table[brickIndex(v, bricks)];
    return b == kNoBlock ? nullptr : &blocks[static_cast<std::size_t>(b)];
  }
  // The block of a brick with material, for changes: a shared block is copied first.
  FieldBlock& own(std::int32_t& entry) {
    if (static_cast<std::size_t>(entry) < tissues.size()) {
      blocks.push_back(FieldBlock(blocks[static_cast<std::size_t>(entry)]));
      entry = static_cast<std::int32_t>(blocks.size() - 1);
    }
    return blocks[static_cast<std::size_t>(entry)];
  }
  // Of a voxel, by the sums of its window [voxels].
  struct Weighed {
    Vec3 toRepresentative;  // Gr - Gc
    Vec3 outward;           // center of gravity of a full window - Gc
    double fraction;        // of the window that is material
  };
  Weighed weigh(const FieldBlock& block, int cell) const {
    const CcMoments& m = block.moments[static_cast<std::size_t>(cell)];
    if (m.mass <= 0) return {Vec3::Zero(), Vec3::Zero(), 0};
    const double scale = 1 / m.mass;
    const Vec3 center(m.x * scale, m.y * scale, m.z * scale);
    return {window.representative - center, windowCenter - center,
            block.volume[static_cast<std::size_t>(cell)] * perFull};
  }
  // The same memory as kernels see it.
  CcWorkpiece workpiece() const {
    const auto* const seen = reinterpret_cast<const CcBlock*>(blocks.data());
    return {bricks.x(), bricks.y(), bricks.z(), table.data(), seen, density.data()};
  }
};

}  // namespace cloudcontact
