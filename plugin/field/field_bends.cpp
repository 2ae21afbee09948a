// Blocks of 4x4x4 voxels share the surface around them.
#include "field/field_bends.h"

#include "base/grid_index.h"
#include "base/parallel.h"
#include "base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace cloudcontact {

namespace {

using V3f = Eigen::Vector3f;
using V3i = Eigen::Vector3i;

// [voxels] from a voxel's center: as far as the finer samples of a coarse one lie, whose middle is
// in the voxel, on levels 1 and 2; and how far beside such a sample the surface may be that it
// touches, outside.
constexpr float kBendReach[] = {2.0f, 3.5f}, kBendBeside = 0.75f,
                kWithin = kBendReach[1] + kBendBeside;
constexpr int kCells = 2;  // of two voxels, beside a block, hold the surface within the reach
// [voxels] More than the fit's noise, so that what only touches is not left out.
constexpr float kNoise = 0.04f;
// [voxels] A coarse sample deeper than this is near in any case, and one farther outside is not.
constexpr float kDeep = 1.5f, kOutside = 2.5f;
constexpr int kMostPlaces = 8192;  // places around a block; with more, its records are not measured

// Places of the surface, by cells of two voxels: all samples, and beside edges what the records
// tell beyond the samples. There the planes of a voxel go on to its borders, and another body's
// sample finds them where no surface is.
class Places {
 public:
  Places(const SampleSet& set, const FieldRecords& records, const V3i& bricks)
      : samples_(set.levels[0].samples),
        bricks_(bricks),
        slots_(static_cast<std::size_t>(bricks.prod()), -1),
        edges_(slots_.size()) {
    addSamples(set.levels[1].finer);
    for (std::size_t t = 0; t < edges_.size(); ++t)
      for (int k = 0; records.held()[t] && k < kBrickVoxels; ++k)
        if (ccPlaneCount(records.bandRecord(t, k)) > 1)
          edges_[t] |= std::uint64_t{1} << cellOf(cellOffset(k) / 2);
    for (std::size_t t = 0; t < edges_.size(); ++t)
      for (std::size_t cell = 0; records.held()[t] && cell < 64; ++cell)
        addCorners(records, t, cell);
  }

  bool has(const V3i& cell) const { return insideGrid(cell, 4 * bricks_); }
  // Copies the places of the cell that holds voxels 2 cell and 2 cell + 1, which must lie in the
  // grid, to seven columns: place, normal and width, zero but of samples. Returns how many there
  // are; none are copied if there are more than `room`.
  int copy(const V3i& cell, int room, float* const* to) const {
    const std::int32_t slot = slots_[brickIndex(2 * cell, bricks_)];
    if (slot < 0) return 0;
    const Held& held = held_[static_cast<std::size_t>(slot)][cellOf(cell)];
    const int count = static_cast<int>(held.samples.count + held.corners.count);
    if (count > room) return count;
    const LargeVector<float>* const from[] = {&samples_.x,    &samples_.y,  &samples_.z,
                                              &samples_.nx,   &samples_.ny, &samples_.nz,
                                              &samples_.width};
    for (int c = 0; c < 7; ++c) {
      std::copy_n(from[c]->data() + held.samples.first, held.samples.count, to[c]);
      float* const rest = to[c] + held.samples.count;
      for (std::uint32_t i = 0; i < held.corners.count; ++i)
        rest[i] = c < 3 ? corners_[held.corners.first + i][c] : 0.0f;
    }
    return count;
  }

 private:
  struct Held {
    SampleRun samples, corners;
  };
  static std::size_t cellOf(const V3i& c) {
    return static_cast<std::size_t>((c.x() & 3) | (c.y() & 3) << 2 | (c.z() & 3) << 4);
  }
  Held& heldAt(const V3i& cell) {
    std::int32_t& slot = slots_[brickIndex(2 * cell, bricks_)];
    if (slot < 0) {
      slot = static_cast<std::int32_t>(held_.size());
      held_.emplace_back();
    }
    return held_[static_cast<std::size_t>(slot)][cellOf(cell)];
  }
  // The level's samples in a cell follow each other.
  void addSamples(const LargeVector<SampleRun>& runs) {
    for (const SampleRun& run : runs) {
      const V3f first(samples_.x[run.first], samples_.y[run.first], samples_.z[run.first]);
      const V3i at = first.array().floor().cast<int>().matrix();
      if (!insideGrid(at, 8 * bricks_)) continue;
      SampleRun& held = heldAt(at / 2).samples;
      if (held.count == 0) held.first = run.first;
      held.count = run.first + run.count - held.first;
    }
  }
  bool isBesideEdge(const V3i& cell) const {
    for (int k = 0; k < 27; ++k) {
      const V3i at = cell + V3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (has(at) && edges_[brickIndex(2 * at, bricks_)] >> cellOf(at) & 1) return true;
    }
    return false;
  }
  // The corners of a cell's voxels that these say are inside.
  void addCorners(const FieldRecords& records, std::size_t t, std::size_t cell) {
    const V3i in(static_cast<int>(cell & 3), static_cast<int>(cell >> 2 & 3),
                 static_cast<int>(cell >> 4));
    const V3i at = 4 * gridCell(t, bricks_) + in;
    if (!isBesideEdge(at)) return;
    const std::size_t first = corners_.size();
    for (int corner = 0; corner < 8; ++corner) {
      const V3i voxel = 2 * at + V3i(corner & 1, corner >> 1 & 1, corner >> 2);
      const CcVoxel record = records.bandRecord(t, cellIndex(voxel));
      if (ccPlaneCount(record) > 0) addCornersOf(record, records.planes().data(), voxel);
    }
    if (corners_.size() == first) return;
    heldAt(at).corners = {static_cast<std::uint32_t>(first),
                          static_cast<std::uint32_t>(corners_.size() - first)};
  }
  void addCornersOf(CcVoxel record, const CcVoxel* planes, const V3i& voxel) {
    constexpr float kInside = 0.87f;  // half a voxel's diagonal: deeper ones hold no surface
    const float zero[3] = {0, 0, 0};
    if (std::abs(ccVoxelDepth(record, planes, zero).depth) > kInside) return;
    for (int corner = 0; corner < 8; ++corner) {
      const V3i side(corner & 1, corner >> 1 & 1, corner >> 2);
      const V3f from = side.cast<float>() - V3f::Constant(0.5f);
      if (ccVoxelDepth(record, planes, from.data()).depth > 0)
        corners_.push_back((voxel + side).cast<float>());
    }
  }

  const SampleColumns& samples_;
  V3i bricks_;
  std::vector<std::int32_t> slots_;
  std::vector<std::uint64_t> edges_;  // by brick, a bit for each cell
  std::vector<std::array<Held, 64>> held_;
  std::vector<V3f> corners_;
};

// The surface around a block, and how high it lies above a record's planes.
struct Around {
  static constexpr int kVector = 16;
  int count = 0;
  float x[kMostPlaces], y[kMostPlaces], z[kMostPlaces], nx[kMostPlaces], ny[kMostPlaces],
      nz[kMostPlaces], width[kMostPlaces];
  float height[kMostPlaces], square[kMostPlaces];  // from the voxel's center

  // False if there is more than fits.
  bool gather(const Places& places, const V3i& block) {
    count = 0;
    const V3i low = 2 * block - V3i::Constant(kCells), high = 2 * block + V3i::Constant(1 + kCells);
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i) {
          const V3i cell(i, j, k);
          if (!places.has(cell)) continue;
          float* const to[] = {x + count,  y + count,  z + count,    nx + count,
                               ny + count, nz + count, width + count};
          const int some = places.copy(cell, kMostPlaces - count, to);
          if (some > kMostPlaces - count) return false;
          count += some;
        }
    return true;
  }
};

CC_LANES void measureSquares(const float* center, Around& around) {
  const float cx = center[0], cy = center[1], cz = center[2];
  CC_INDEPENDENT
  for (int i = 0; i < around.count; ++i) {
    const float x = around.x[i] - cx, y = around.y[i] - cy, z = around.z[i] - cz;
    around.square[i] = x * x + y * y + z * z;
  }
}

// Heights above one plane of a record at `center`: the first, or joined with those of others.
CC_LANES void addHeights(CcVoxel plane, const float* center, int first, int unites,
                         Around& around) {
  const float zero[3] = {0, 0, 0}, cx = center[0], cy = center[1], cz = center[2];
  const CcDepth d = ccPlaneDepth(plane, zero);
  const float nx = d.normal[0], ny = d.normal[1], nz = d.normal[2], offset = d.depth;
  CC_INDEPENDENT
  for (int i = 0; i < around.count; ++i) {
    const float at =
        nx * (around.x[i] - cx) + ny * (around.y[i] - cy) + nz * (around.z[i] - cz) - offset;
    const float cosine = nx * around.nx[i] + ny * around.ny[i] + nz * around.nz[i];
    const float sine = CC_SQRT(ccMax(1.0f - cosine * cosine, 0.0f));
    const float h = at + CC_HALF_WIDTH * around.width[i] * sine;
    const float all = unites ? ccMin(around.height[i], h) : ccMax(around.height[i], h);
    around.height[i] = first ? h : all;
  }
}

// The greatest heights within two distances of the center.
struct Greatest {
  float near, far;
};
CC_LANES Greatest greatest(const Around& around, float near, float far) {
  float within[2][Around::kVector];
  std::fill_n(within[0], 2 * Around::kVector, -1e30f);
  for (int base = 0; base < around.count; base += Around::kVector) {
    const int some = std::min(Around::kVector, around.count - base);
    CC_INDEPENDENT
    for (int k = 0; k < some; ++k) {
      const float square = around.square[base + k], h = around.height[base + k];
      within[0][k] = ccMax(within[0][k], square <= near * near ? h : -1e30f);
      within[1][k] = ccMax(within[1][k], square <= far * far ? h : -1e30f);
    }
  }
  return {*std::max_element(within[0], within[0] + Around::kVector),
          *std::max_element(within[1], within[1] + Around::kVector)};
}

// The least square of the distances of all places, and of all samples.
struct Least {
  float all, samples;
};
CC_LANES Least leastSquares(const Around& around) {
  float all[Around::kVector], samples[Around::kVector];
  std::fill_n(all, Around::kVector, 1e30f), std::fill_n(samples, Around::kVector, 1e30f);
  for (int base = 0; base < around.count; base += Around::kVector) {
    const int some = std::min(Around::kVector, around.count - base);
    CC_INDEPENDENT
    for (int k = 0; k < some; ++k) {
      const float square = around.square[base + k];
      all[k] = ccMin(all[k], square);
      samples[k] = ccMin(samples[k], around.width[base + k] > 0.0f ? square : 1e30f);
    }
  }
  return {*std::min_element(all, all + Around::kVector),
          *std::min_element(samples, samples + Around::kVector)};
}

// Of a record with planes, 0 if it is too far from the surface.
uint bendAt(CcVoxel record, const CcVoxel* planes, const float* center, Around& around) {
  const float zero[3] = {0, 0, 0};
  const float depth = ccVoxelDepth(record, planes, zero).depth;
  if (depth > kDeep || depth < -kOutside) return 0;
  const uint count = ccPlaneCount(record);
  for (uint k = 0; k < count; ++k)
    addHeights(count == 1 ? record : planes[record.b + k], center, k == 0, ccConcave(record),
               around);
  measureSquares(center, around);
  const Greatest rises = greatest(around, kBendReach[0], kBendReach[1]);
  return ccPackBend(rises.near + kNoise, rises.far + kNoise);
}

bool isOutside(const CcVoxel& record) {
  return ccPlaneCount(record) == 0 && record.b == CC_NEAR_OUTSIDE;
}

// The record of a voxel outside: the plane of the nearest sample, or nothing where no surface is
// near.
CcVoxel outsideAt(const float* center, Around& around) {
  measureSquares(center, around);
  const Least least = leastSquares(around);
  if (least.all > kWithin * kWithin) return {0, 0};
  CcVoxel record = {0, CC_NEAR_OUTSIDE};
  if (least.samples > kWithin * kWithin) return record;
  const auto nearest =
      std::find_if(around.width, around.width + around.count,
                   [&](const float& width) {
                     return width > 0 && around.square[&width - around.width] == least.samples;
                   }) -
      around.width;
  const V3f n(around.nx[nearest], around.ny[nearest], around.nz[nearest]);
  const V3f by =
      V3f(around.x[nearest], around.y[nearest], around.z[nearest]) - Eigen::Map<const V3f>(center);
  const CcVoxel plane = ccPackPlane(n.data(), n.dot(by));
  addHeights(plane, center, 1, 0, around);
  ccPackOutside(plane, greatest(around, kWithin, kWithin).far + kNoise, &record);
  return record;
}

// Measures the records of a brick, `to`, with the brick's planes where it has any; `low`: its first
// voxel.
void measureBrick(const Places& places, const CcVoxel* planes, const V3i& low, Around& around,
                  CcVoxel* to) {
  for (int block = 0; block < 8; ++block) {
    const V3i first = low + 4 * V3i(block & 1, block >> 1 & 1, block >> 2);
    bool gathered = false;
    for (int k = 0; k < 64; ++k) {
      const V3i at = first + V3i(k & 3, k >> 2 & 3, k >> 4);
      CcVoxel& record = to[cellIndex(at)];
      const bool outside = isOutside(record);
      if (!outside && ccPlaneCount(record) == 0) continue;
      if (!gathered && !around.gather(places, first / 4)) break;
      gathered = true;
      const V3f center = at.cast<float>() + V3f::Constant(0.5f);
      if (outside)
        record = outsideAt(center.data(), around);
      else
        ccSetBend(&record, bendAt(record, planes, center.data(), around));
    }
  }
}

// What a brick without planes gets.
struct OwnBrick {
  std::array<CcVoxel, kBrickVoxels> records;
  bool near = false;  // the surface is
};

}  // namespace

void measureBends(const SampleSet& samples, FieldRecords& records, int threads) {
  const CcBricks n = records.bricks();
  const V3i bricks(n.nx, n.ny, n.nz);
  const Places places(samples, records, bricks);
  std::vector<std::size_t> all;
  for (std::size_t t = 0; t < records.held().size(); ++t)
    if (records.brickDistance()[t] <= 1) all.push_back(t);
  std::vector<std::unique_ptr<Around>> around(static_cast<std::size_t>(threadCount(threads)));
  std::vector<std::unique_ptr<OwnBrick>> own(all.size());
  parallelFor(all.size(), threads, [&](std::size_t i, int worker) {
    const std::size_t t = all[i];
    std::unique_ptr<Around>& memory = around[static_cast<std::size_t>(worker)];
    if (!memory) memory = std::make_unique<Around>();
    const V3i low = kBrickEdge * gridCell(t, bricks);
    const CcVoxel* const planes = records.planes().data();
    if (records.held()[t])
      return measureBrick(places, planes, low, *memory, &records.bandRecord(t, 0));
    const CcVoxel* const shared = records.brick(t);
    if (std::none_of(shared, shared + kBrickVoxels, isOutside)) return;
    own[i] = std::make_unique<OwnBrick>();
    std::copy_n(shared, kBrickVoxels, own[i]->records.begin());
    measureBrick(places, planes, low, *memory, own[i]->records.data());
    own[i]->near = std::any_of(own[i]->records.begin(), own[i]->records.end(),
                               [](const CcVoxel& v) { return v.a != 0 || v.b != 0; });
  });
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!own[i]) continue;
    if (own[i]->near)
      records.setBrick(all[i], own[i]->records);
    else
      records.setOutside(all[i]);
  }
}

}  // namespace cloudcontact
