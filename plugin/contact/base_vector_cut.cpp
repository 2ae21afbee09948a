// Cuts a field of base vectors. A voxel that loses matter concerns those voxels in whose window it
// lies: the window turned round about it, walked row by row. What the voxels of a row lose goes to
// a block's row all at once.
#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "field_bricks.h"
#include "simd.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

// Gives a brick that shares its block one of its own.
FieldBlock& ownBlock(Bricks& f, std::int32_t& entry) {
  if (static_cast<std::size_t>(entry) < f.tissues.size()) {
    f.blocks.push_back(FieldBlock(f.blocks[static_cast<std::size_t>(entry)]));
    entry = static_cast<std::int32_t>(f.blocks.size() - 1);
  }
  return f.blocks[static_cast<std::size_t>(entry)];
}

// What some voxels of one row of a brick lose; beyond `first` and `end` nothing.
struct RowLoss {
  double matter[kBrickEdge] = {}, coverage[kBrickEdge] = {};
  int first = kBrickEdge, end = 0;

  void add(int x, double lostMatter, double lostCoverage) {
    matter[x] += lostMatter;
    coverage[x] += lostCoverage;
    first = std::min(first, x);
    end = std::max(end, x + 1);
  }
};

// Eight numbers worked on at once, wherever they lie.
typedef double Eight __attribute__((vector_size(64)));

// `sums` gets, times what each of kCount voxels lost, the taps that lie `apart` before the last
// one's. The sums are read and written once for all voxels.
template <int kCount>
[[gnu::always_inline]] inline void addEight(const CcSum* taps, int apart, const double* lost,
                                            CcSum* sums) {
  Eight sum, tap;
  std::memcpy(&sum, sums, sizeof(Eight));
  for (int k = 0; k < kCount; ++k) {
    std::memcpy(&tap, taps - k * apart, sizeof(Eight));
    sum += tap * lost[k];
  }
  std::memcpy(sums, &sum, sizeof(Eight));
}

// A row of a block gets what kCount voxels beside each other lose, times the window's weights; the
// taps are those of the row's first voxel as the first of them has it, zero where the window does
// not reach.
template <int kCount>
[[gnu::always_inline]] inline void addVoxels(const CcMoments* taps, const CcSum* weights,
                                             const double* matter, const double* coverage,
                                             CcMoments* moments, CcSum* volume) {
  double lost[kCount];  // nothing that is written to lies there, so it stays in registers
  for (int k = 0; k < kCount; ++k) lost[k] = matter[k];
  for (int i = 0; i < kBrickEdge; i += 2)
    addEight<kCount>(&taps[i].mass, 4, lost, &moments[i].mass);
  for (int k = 0; k < kCount; ++k) lost[k] = coverage[k];
  addEight<kCount>(weights, 1, lost, volume);
}

// Of a row's voxels those from `first` up to `end`. The number is known to the compiler: its loops
// have no end to guess.
[[gnu::always_inline]] inline void addRow(const CcMoments* taps, const CcSum* weights,
                                          const RowLoss& loss, int first, int end,
                                          CcMoments* moments, CcSum* volume) {
  const double *const matter = loss.matter + first, *const coverage = loss.coverage + first;
  switch (end - first) {
    case 1:
      return addVoxels<1>(taps, weights, matter, coverage, moments, volume);
    case 2:
      return addVoxels<2>(taps, weights, matter, coverage, moments, volume);
    case 3:
      return addVoxels<3>(taps, weights, matter, coverage, moments, volume);
    case 4:
      return addVoxels<4>(taps, weights, matter, coverage, moments, volume);
    case 5:
      return addVoxels<5>(taps, weights, matter, coverage, moments, volume);
    case 6:
      return addVoxels<6>(taps, weights, matter, coverage, moments, volume);
    case 7:
      return addVoxels<7>(taps, weights, matter, coverage, moments, volume);
    default:
      return addVoxels<8>(taps, weights, matter, coverage, moments, volume);
  }
}

// The blocks about a brick, out to where a window may reach; null where there is no matter.
struct Neighbours {
  static constexpr int kReach = 8;  // [voxels] of a window that one brick beside is enough for
  Eigen::Vector3i brick = Eigen::Vector3i::Constant(-1);
  std::size_t made = 0;  // blocks that there were: more may lie elsewhere
  FieldBlock* blocks[27];

  // Every block gets one of its own: what is cut beside it changes it.
  void gather(Bricks& f, const Eigen::Vector3i& about) {
    if (brick == about && made == f.blocks.size()) return;
    brick = about;
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i at =
          about + Eigen::Vector3i(k % 3, k / 3 % 3, k / 9) - Eigen::Vector3i::Ones();
      std::int32_t* const entry = (at.array() >= 0).all() && (at.array() < f.bricks.array()).all()
                                      ? &f.entry(at.x(), at.y(), at.z())
                                      : nullptr;
      if (entry && *entry != kNoBlock) ownBlock(f, *entry);
    }
    // Only now do the blocks stay where they are.
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i at =
          about + Eigen::Vector3i(k % 3, k / 3 % 3, k / 9) - Eigen::Vector3i::Ones();
      const bool inside = (at.array() >= 0).all() && (at.array() < f.bricks.array()).all();
      const std::int32_t entry = inside ? f.entry(at.x(), at.y(), at.z()) : kNoBlock;
      blocks[k] = entry == kNoBlock ? nullptr : &f.blocks[static_cast<std::size_t>(entry)];
    }
    made = f.blocks.size();
  }
};

// All windows in which a row's voxels lie lose matter and coverage. 1,000 voxels of a window of 81:
// 0.13 ms, row by row (0.24 voxel by voxel).
CC_LANES void spread(const Bricks& f, const Neighbours& near, int vy, int vz, const RowLoss& loss) {
  for (const WindowRow& row : f.rows) {
    const int y = vy + row.y, z = vz + row.z, count = static_cast<int>(row.count);
    FieldBlock* const* const blocks = near.blocks + 3 * ((y >> 3) + 1) + 9 * ((z >> 3) + 1) + 1;
    const int line = (y & 7) << 3 | (z & 7) << 6;
    const int last = (loss.end - 1 + row.x + count - 1) >> 3;
    for (int b = (loss.first + row.x) >> 3; b <= last; ++b) {
      FieldBlock* const block = blocks[b];
      if (!block) continue;
      // Those whose windows' rows reach into the brick.
      const int first = std::max(loss.first, kBrickEdge * b - row.x - count + 1);
      const int end = std::min(loss.end, kBrickEdge * (b + 1) - row.x);
      const std::size_t tap = row.first + static_cast<std::size_t>(kBrickEdge * b - first - row.x);
      addRow(&f.taps[tap], &f.weights[tap], loss, first, end, &block->moments[line],
             &block->volume[line]);
    }
  }
}

// The same for windows that reach farther than the bricks beside; v the row's first voxel.
void spreadFar(Bricks& f, const VoxelIndex& v, const RowLoss& loss) {
  for (const WindowRow& row : f.rows) {
    const int y = v.y() + row.y, z = v.z() + row.z, count = static_cast<int>(row.count);
    if (y < 0 || z < 0 || y >= kBrickEdge * f.bricks.y() || z >= kBrickEdge * f.bricks.z())
      continue;
    const int x = v.x() + row.x, last = std::min((x + loss.end + count - 2) >> 3, f.bricks.x() - 1);
    for (int b = std::max((x + loss.first) >> 3, 0); b <= last; ++b) {
      std::int32_t& entry = f.entry(b, y >> 3, z >> 3);
      if (entry == kNoBlock) continue;
      FieldBlock& block = ownBlock(f, entry);
      const auto line = static_cast<std::size_t>(Bricks::cell(0, y, z));
      const int first = std::max(loss.first, kBrickEdge * b - x - count + 1);
      const int end = std::min(loss.end, kBrickEdge * (b + 1) - x);
      const std::size_t tap = row.first + static_cast<std::size_t>(kBrickEdge * b - first - x);
      addRow(&f.taps[tap], &f.weights[tap], loss, first, end, &block.moments[line],
             &block.volume[line]);
    }
  }
}

// Cuts voxel by voxel and tells the windows that it lies in row by row: voxels of one row mostly
// come together.
class Cutting {
 public:
  explicit Cutting(Bricks& f)
      : f_(f),
        middle_(kBrickEdge / 2 * f.bricks),
        near_(f.window.low.minCoeff() >= -Neighbours::kReach &&
              f.window.high.maxCoeff() <= Neighbours::kReach) {}

  // False where the voxel has no more than that already.
  bool cut(const VoxelCut& c) {
    const VoxelIndex row(c.voxel.x() >> 3, c.voxel.y(), c.voxel.z());
    if (row != row_) begin(row);
    if (!block_) return false;
    const int x = c.voxel.x() & 7;
    const std::size_t cell = cell_ + static_cast<std::size_t>(x);
    const int less = c.coverage - block_->coverage[cell];
    if (less >= 0) return false;
    if (!owned_) own();
    const std::uint8_t tissue = block_->tissue[cell];
    block_->coverage[cell] = c.coverage;
    if (c.coverage == 0) block_->tissue[cell] = 0;
    if (tissue != tissue_) tellSums(tissue);
    lost_.add(x, less);
    loss_.add(x, less * f_.density[tissue], less);
    return true;
  }

  // To be called after the last voxel, too.
  void finish() {
    if (loss_.end == 0) return;
    tellSums(tissue_);
    if (near_)
      spread(f_, *around_, row_.y() & 7, row_.z() & 7, loss_);
    else
      spreadFar(f_, VoxelIndex(kBrickEdge * row_.x(), row_.y(), row_.z()), loss_);
    loss_ = {};
  }

 private:
  void begin(const VoxelIndex& row) {
    finish();
    row_ = row;
    entry_ = &f_.entry(row.x(), row.y() >> 3, row.z() >> 3);
    cell_ = static_cast<std::size_t>(Bricks::cell(0, row.y(), row.z()));
    block_ = *entry_ == kNoBlock ? nullptr : &f_.blocks[static_cast<std::size_t>(*entry_)];
    owned_ = false;
  }
  // Before the row's block is changed.
  void own() {
    const Eigen::Vector3i brick(row_.x(), row_.y() >> 3, row_.z() >> 3);
    // Rows that go from brick to brick come back to the same few.
    around_ = &neighbours_[(brick.x() & 1) | (brick.y() & 1) << 1 | (brick.z() & 1) << 2];
    if (near_) around_->gather(f_, brick);
    block_ = &ownBlock(f_, *entry_);
    owned_ = true;
  }
  // What the row has lost so far, seen from the grid's middle; then `tissue` is what it loses.
  void tellSums(std::uint8_t tissue) {
    f_.sums[tissue_].add(VoxelIndex(kBrickEdge * row_.x(), row_.y(), row_.z()) - middle_, lost_);
    lost_ = {};
    tissue_ = tissue;
  }

  Bricks& f_;
  const VoxelIndex middle_;
  const bool near_;
  Neighbours neighbours_[8];
  Neighbours* around_ = nullptr;
  VoxelIndex row_ = VoxelIndex::Constant(-1);  // its brick's x, its y and z
  std::int32_t* entry_ = nullptr;              // of its brick
  FieldBlock* block_ = nullptr;
  std::size_t cell_ = 0;  // of its first voxel
  bool owned_ = false;    // the block may be written to
  RowLoss loss_;
  std::uint8_t tissue_ = 0;
  RowSums lost_;  // of that tissue
};

}  // namespace

std::size_t BaseVectorField::cut(std::span<const VoxelCut> voxels) {
  Bricks& f = *bricks_;
  for (const VoxelCut& c : voxels)
    if (!f.contains(c.voxel))
      throw std::out_of_range("BaseVectorField::cut: a voxel lies outside the grid");
  Cutting cutting(f);
  std::size_t changed = 0;
  for (const VoxelCut& c : voxels) changed += cutting.cut(c);
  cutting.finish();
  return changed;
}

void BaseVectorField::reserve() {
  std::size_t shared = 0;
  for (const std::int32_t entry : bricks_->table)
    shared += entry != kNoBlock && static_cast<std::size_t>(entry) < bricks_->tissues.size();
  // Touched as well as reserved: a page's first use costs more than what is written on it.
  const std::size_t used = bricks_->blocks.size();
  bricks_->blocks.resize(used + shared);
  bricks_->blocks.resize(used);
}

}  // namespace cloudcontact
