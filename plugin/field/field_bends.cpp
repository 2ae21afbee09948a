// Blocks of 2x2x2 voxels share the samples around them.
#include "field/field_bends.h"

#include "base/grid_index.h"
#include "base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cloudcontact {

namespace {

// [voxels] from a voxel's center: as far as the finer samples of a coarse one lie, whose middle is
// in the voxel, on levels 1 and 2.
constexpr float kReach[] = {2.0f, 3.5f};
constexpr int kCells = 2;  // of two voxels, beside a block, hold the samples within the reach
// [voxels] More than the fit's noise, so that what only touches is not left out.
constexpr float kNoise = 0.04f;
// [voxels] A coarse sample deeper than this is near in any case, and one farther outside is not.
constexpr float kDeep = 1.5f, kOutside = 2.5f;
constexpr int kMost = 1024;  // samples around a block; with more, its records say the most

// The samples of each cell of two voxels, and whether it holds an edge.
class Cells {
 public:
  Cells(const SampleSet& set, const FieldRecords& records, const Eigen::Vector3i& bricks)
      : bricks_(bricks),
        slots_(static_cast<std::size_t>(bricks.prod()), -1),
        edges_(slots_.size()) {
    for (std::size_t t = 0; t < edges_.size(); ++t)
      for (int k = 0; records.held()[t] && k < kBrickVoxels; ++k)
        if (ccPlaneCount(records.bandRecord(t, k)) > 1)
          edges_[t] |= std::uint64_t{1} << cellOf(cellOffset(k) / 2);
    const SampleLevel& coarse = set.levels[1];
    const SampleColumns& s = set.levels[0].samples;
    for (const SampleRun& run : coarse.finer) {
      // The level's samples in a cell follow each other.
      const Eigen::Vector3i at = Eigen::Array3f(s.x[run.first], s.y[run.first], s.z[run.first])
                                     .floor()
                                     .cast<int>()
                                     .matrix();
      if (!insideGrid(at, 8 * bricks)) continue;
      std::int32_t& slot = slots_[brickIndex(at, bricks)];
      if (slot < 0) {
        slot = static_cast<std::int32_t>(runs_.size());
        runs_.emplace_back();
      }
      SampleRun& cell = runs_[static_cast<std::size_t>(slot)][cellOf(at / 2)];
      if (cell.count == 0) cell.first = run.first;
      cell.count = run.first + run.count - cell.first;
    }
  }

  // Of the cell that holds voxels 2 cell and 2 cell + 1, which must lie in the grid.
  SampleRun at(const Eigen::Vector3i& cell) const {
    const std::int32_t slot = slots_[brickIndex(2 * cell, bricks_)];
    return slot < 0 ? SampleRun{} : runs_[static_cast<std::size_t>(slot)][cellOf(cell)];
  }
  bool edge(const Eigen::Vector3i& cell) const {
    return edges_[brickIndex(2 * cell, bricks_)] >> cellOf(cell) & 1;
  }
  bool has(const Eigen::Vector3i& cell) const { return insideGrid(cell, 4 * bricks_); }

 private:
  static std::size_t cellOf(const Eigen::Vector3i& c) {
    return static_cast<std::size_t>((c.x() & 3) | (c.y() & 3) << 2 | (c.z() & 3) << 4);
  }
  Eigen::Vector3i bricks_;
  std::vector<std::int32_t> slots_;
  std::vector<std::uint64_t> edges_;  // by brick, a bit for each cell
  std::vector<std::array<SampleRun, 64>> runs_;
};

// Samples around a block, and how high each lies above a record's surface.
struct Around {
  int count = 0;
  float x[kMost], y[kMost], z[kMost], height[kMost];

  // False where an edge is near: the field may jump there by more than the surface rises.
  bool gather(const SampleColumns& s, const Cells& cells, const Eigen::Vector3i& block) {
    count = 0;
    const Eigen::Vector3i low = block - Eigen::Vector3i::Constant(kCells),
                          high = block + Eigen::Vector3i::Constant(kCells);
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i) {
          const Eigen::Vector3i cell(i, j, k);
          if (!cells.has(cell)) continue;
          const SampleRun run = cells.at(cell);
          if (cells.edge(cell) || count + static_cast<int>(run.count) > kMost) return false;
          std::copy_n(s.x.data() + run.first, run.count, x + count);
          std::copy_n(s.y.data() + run.first, run.count, y + count);
          std::copy_n(s.z.data() + run.first, run.count, z + count);
          count += static_cast<int>(run.count);
        }
    return true;
  }
};

// Heights above one plane of a record at `center`: the first, or joined with those of others.
CC_LANES void addHeights(CcVoxel plane, const float* center, int first, int unites,
                         Around& around) {
  const float zero[3] = {0, 0, 0}, cx = center[0], cy = center[1], cz = center[2];
  const CcDepth d = ccPlaneDepth(plane, zero);
  const float nx = d.normal[0], ny = d.normal[1], nz = d.normal[2], offset = d.depth;
  CC_INDEPENDENT
  for (int i = 0; i < around.count; ++i) {
    const float h =
        nx * (around.x[i] - cx) + ny * (around.y[i] - cy) + nz * (around.z[i] - cz) - offset;
    const float all = unites ? ccMin(around.height[i], h) : ccMax(around.height[i], h);
    around.height[i] = first ? h : all;
  }
}

// The greatest height within the reach of each level.
CC_LANES void greatest(const Around& around, const float* center, float* most) {
  const float cx = center[0], cy = center[1], cz = center[2];
  const float near = kReach[0] * kReach[0], far = kReach[1] * kReach[1];
  float lanes[2][16];
  for (int k = 0; k < 16; ++k) lanes[0][k] = lanes[1][k] = -1e30f;
  for (int base = 0; base < around.count; base += 16) {
    const int some = std::min(16, around.count - base);
    CC_INDEPENDENT
    for (int k = 0; k < some; ++k) {
      const float x = around.x[base + k] - cx, y = around.y[base + k] - cy,
                  z = around.z[base + k] - cz;
      const float square = x * x + y * y + z * z, h = around.height[base + k];
      lanes[0][k] = ccMax(lanes[0][k], square <= near ? h : -1e30f);
      lanes[1][k] = ccMax(lanes[1][k], square <= far ? h : -1e30f);
    }
  }
  for (int r = 0; r < 2; ++r) most[r] = *std::max_element(lanes[r], lanes[r] + 16);
}

// Of the record at a voxel, 0 if it is too far from the surface.
uint bendAt(CcVoxel record, const CcVoxel* planes, const Eigen::Vector3i& voxel, Around& around) {
  const float zero[3] = {0, 0, 0};
  const float depth = ccVoxelDepth(record, planes, zero).depth;
  if (depth > kDeep || depth < -kOutside || around.count == 0) return 0;
  const float center[3] = {static_cast<float>(voxel.x()) + 0.5f,
                           static_cast<float>(voxel.y()) + 0.5f,
                           static_cast<float>(voxel.z()) + 0.5f};
  const uint count = ccPlaneCount(record);
  for (uint k = 0; k < count; ++k)
    addHeights(count == 1 ? record : planes[record.b + k], center, k == 0, ccConcave(record),
               around);
  float most[2];
  greatest(around, center, most);
  return ccPackBend(most[0] + kNoise, most[1] + kNoise);
}

}  // namespace

void measureBends(const SampleSet& samples, FieldRecords& records) {
  const CcBricks n = records.bricks();
  const Eigen::Vector3i bricks(n.nx, n.ny, n.nz);
  const Cells cells(samples, records, bricks);
  Around around;
  for (std::size_t t = 0; t < records.held().size(); ++t) {
    if (!records.held()[t]) continue;
    const Eigen::Vector3i low = kBrickEdge * gridCell(t, bricks);
    for (int block = 0; block < 64; ++block) {
      const Eigen::Vector3i in(block & 3, block >> 2 & 3, block >> 4);
      bool gathered = false;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3i at =
            low + 2 * in + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2);
        CcVoxel& record = records.bandRecord(t, cellIndex(at));
        if (ccPlaneCount(record) == 0) continue;
        if (!gathered && !around.gather(samples.levels[0].samples, cells, low / 2 + in)) break;
        gathered = true;
        ccSetBend(&record, bendAt(record, records.planes().data(), at, around));
      }
    }
  }
}

}  // namespace cloudcontact
