// Builds a field of base vectors, reads it, and cuts it. The sums are the same integers whichever
// way they come about: gathered from a window's voxels when the field is built, or changed one by
// one by what is cut. A voxel that loses matter concerns those voxels in whose window it lies: the
// window turned round about it, walked row by row.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "../geometry/parallel.h"
#include "field_bricks.h"
#include "simd.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

CcTap tapOf(const WindowTap& t) {
  return {t.weight, t.moment[0], t.moment[1], t.moment[2]};
}

// The window turned round, as rows.
void makeRows(Bricks& f) {
  const auto zeros = [&] {
    f.taps.insert(f.taps.end(), kBrickEdge, CcMoments{});
    f.weights.insert(f.weights.end(), kBrickEdge, 0.0);
  };
  zeros();
  for (auto t = f.window.taps.rbegin(); t != f.window.taps.rend(); ++t) {
    const bool goesOn = !f.rows.empty() && f.rows.back().y == -t->y && f.rows.back().z == -t->z &&
                        f.rows.back().x + static_cast<int>(f.rows.back().count) == -t->x;
    if (!goesOn) {
      if (!f.rows.empty()) zeros();
      f.rows.push_back({-t->x, -t->y, -t->z, static_cast<std::uint32_t>(f.taps.size()), 0});
    }
    ++f.rows.back().count;
    f.taps.push_back({static_cast<CcSum>(t->weight), static_cast<CcSum>(t->moment[0]),
                      static_cast<CcSum>(t->moment[1]), static_cast<CcSum>(t->moment[2])});
    f.weights.push_back(t->weight);
  }
  zeros();
}

void fillTissues(Bricks& f, const Cloud& cloud, const TissueTable& tissues) {
  const std::size_t kinds = std::max<std::size_t>(cloud.materials().size(), 1);
  requireTissues(tissues);
  if (tissues.size() != kinds)
    throw std::invalid_argument("BaseVectorField: the cloud has " + std::to_string(kinds) +
                                " materials, " + std::to_string(tissues.size()) +
                                " tissues were given (tissuesOf() finds them by name)");
  f.tissues = tissues;
  f.names = cloud.materials();
  double densest = 0;
  for (const Tissue& t : tissues) densest = std::max(densest, t.density);
  for (const Tissue& t : tissues)
    f.density.push_back(
        std::max(1, static_cast<int>(std::lround(CC_DENSEST * t.density / densest))));
  f.sums.resize(kinds);
}

// What a brick of the cloud holds, in one number: a tissue where it is full of that alone.
constexpr int kMixed = -1, kVoid = -2;
std::vector<int> kindsOf(const Cloud& cloud) {
  const Cloud::Voxels& v = cloud.voxels();
  std::vector<int> kinds(v.table.size(), kMixed);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    if (v.table[k] == kEmptyBrick) kinds[k] = kVoid;
    if (v.table[k] == kSolidBrick)
      kinds[k] = v.materialTable.empty()  ? 0
                 : v.materialTable[k] < 0 ? -1 - v.materialTable[k]
                                          : kMixed;
  }
  return kinds;
}

// The tissue of a brick all of whose windows are full of it, or kMixed.
int deepInside(const Bricks& f, const std::vector<int>& kinds, const Eigen::Vector3i& brick) {
  const auto brickOf = [](const Eigen::Vector3i& v) {
    return Eigen::Vector3i(v.unaryExpr([](int x) { return x >> 3; }));
  };
  const Eigen::Vector3i corner = kBrickEdge * brick;
  const Eigen::Vector3i low = brickOf(corner + f.window.low.cwiseMin(0));
  const Eigen::Vector3i high =
      brickOf(corner + Eigen::Vector3i::Constant(kBrickEdge - 1) + f.window.high.cwiseMax(0));
  if ((low.array() < 0).any() || (high.array() >= f.bricks.array()).any()) return kMixed;
  const auto kind = [&](int x, int y, int z) {
    return kinds[static_cast<std::size_t>(x) +
                 static_cast<std::size_t>(f.bricks.x()) *
                     (static_cast<std::size_t>(y) +
                      static_cast<std::size_t>(f.bricks.y()) * static_cast<std::size_t>(z))];
  };
  const int own = kind(brick.x(), brick.y(), brick.z());
  if (own < 0) return kMixed;
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        if (kind(x, y, z) != own) return kMixed;
  return own;
}

// Sums of one voxel, gathered from the cloud.
void gather(const Bricks& f, const Cloud& cloud, const VoxelIndex& v, FieldBlock& block, int cell) {
  CcMoments moments{};
  CcSum volume = 0;
  for (const WindowTap& t : f.window.taps) {
    const VoxelIndex at = v + VoxelIndex(t.x, t.y, t.z);
    const int coverage = cloud.coverage(at.x(), at.y(), at.z());
    if (coverage == 0) continue;
    const int tissue = f.names.empty() ? 0 : cloud.material(at.x(), at.y(), at.z());
    ccWeigh(&moments, tapOf(t), coverage * f.density[static_cast<std::size_t>(tissue)]);
    volume += static_cast<CcSum>(coverage * t.weight);
  }
  block.moments[static_cast<std::size_t>(cell)] = moments;
  block.volume[static_cast<std::size_t>(cell)] = volume;
}

void fillShared(Bricks& f) {
  for (std::size_t tissue = 0; tissue < f.tissues.size(); ++tissue) {
    FieldBlock& block = f.blocks[tissue];
    CcMoments moments{};
    CcSum volume = 0;
    for (const WindowTap& t : f.window.taps) {
      ccWeigh(&moments, tapOf(t), 255 * f.density[tissue]);
      volume += static_cast<CcSum>(255 * t.weight);
    }
    block.moments.fill(moments);
    block.volume.fill(volume);
    block.coverage.fill(255);
    block.tissue.fill(static_cast<std::uint8_t>(tissue));
  }
}

void fillBlock(const Bricks& f, const Cloud& cloud, const Eigen::Vector3i& brick,
               FieldBlock& block) {
  for (int k = 0; k < kBrickVoxels; ++k) {
    const VoxelIndex v = kBrickEdge * brick + VoxelIndex(k & 7, k >> 3 & 7, k >> 6);
    const auto at = static_cast<std::size_t>(k);
    block.coverage[at] = cloud.coverage(v.x(), v.y(), v.z());
    block.tissue[at] = f.names.empty() ? std::uint8_t{0} : cloud.material(v.x(), v.y(), v.z());
    if (block.coverage[at] == 0) block.tissue[at] = 0;
    gather(f, cloud, v, block, k);
  }
}

Eigen::Vector3i brickAt(const Bricks& f, std::size_t entry) {
  const auto nx = static_cast<std::size_t>(f.bricks.x()),
             ny = static_cast<std::size_t>(f.bricks.y());
  return {static_cast<int>(entry % nx), static_cast<int>(entry / nx % ny),
          static_cast<int>(entry / (nx * ny))};
}

void sumUp(Bricks& f) {
  const VoxelIndex middle = kBrickEdge / 2 * f.bricks;
  for (std::size_t entry = 0; entry < f.table.size(); ++entry) {
    if (f.table[entry] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[entry])];
    const VoxelIndex corner = kBrickEdge * brickAt(f, entry) - middle;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const auto at = static_cast<std::size_t>(k);
      f.sums[block.tissue[at]].add(corner + VoxelIndex(k & 7, k >> 3 & 7, k >> 6),
                                   {block.coverage[at], 0, 0});
    }
  }
}

void build(Bricks& f, const Cloud& cloud) {
  const std::vector<int> kinds = kindsOf(cloud);
  f.table.assign(kinds.size(), kNoBlock);
  std::vector<std::size_t> own;  // entries with a block of their own
  for (std::size_t entry = 0; entry < kinds.size(); ++entry) {
    if (kinds[entry] == kVoid) continue;
    const int deep = deepInside(f, kinds, brickAt(f, entry));
    if (deep >= 0)
      f.table[entry] = deep;
    else
      own.push_back(entry);
  }
  f.blocks.resize(f.tissues.size() + own.size());
  fillShared(f);
  parallelFor(own.size(), 0, [&](std::size_t k, int) {
    fillBlock(f, cloud, brickAt(f, own[k]), f.blocks[f.tissues.size() + k]);
  });
  for (std::size_t k = 0; k < own.size(); ++k)
    f.table[own[k]] = static_cast<std::int32_t>(f.tissues.size() + k);
  sumUp(f);
}

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

void TissueSums::add(const VoxelIndex& at, const RowSums& row) {
  const std::int64_t x = at.x(), y = at.y(), z = at.z(), all = row.zeroth;
  const std::int64_t alongX = all * x + row.first;
  zeroth += all;
  first[0] += alongX, first[1] += all * y, first[2] += all * z;
  second[0] += all * x * x + 2 * x * row.first + row.second;
  second[1] += all * y * y, second[2] += all * z * z;
  second[3] += alongX * y, second[4] += all * y * z, second[5] += alongX * z;
}

BaseVectorField::BaseVectorField(const Cloud& cloud, const TissueTable& tissues,
                                 const WindowSettings& window)
    : bricks_(std::make_unique<Bricks>()) {
  if (cloud.empty()) throw std::invalid_argument("BaseVectorField: the cloud is empty");
  Bricks& f = *bricks_;
  f.voxelSize = cloud.voxelSize();
  f.origin = cloud.origin();
  f.bricks = cloud.bricks();
  fillTissues(f, cloud, tissues);
  f.window = makeWindow(window, cloud.voxelSize());
  f.windowCenter = f.window.center();
  f.perFull = 1 / (255.0 * static_cast<double>(f.window.weights));
  f.depths = DepthTable(f.window);
  makeRows(f);
  build(f, cloud);
}

BaseVectorField::~BaseVectorField() = default;
BaseVectorField::BaseVectorField(BaseVectorField&&) noexcept = default;
BaseVectorField& BaseVectorField::operator=(BaseVectorField&&) noexcept = default;

double BaseVectorField::voxelSize() const {
  return bricks_->voxelSize;
}
const Vec3& BaseVectorField::origin() const {
  return bricks_->origin;
}
Eigen::Vector3i BaseVectorField::size() const {
  return kBrickEdge * bricks_->bricks;
}
const TissueTable& BaseVectorField::tissues() const {
  return bricks_->tissues;
}
const Window& BaseVectorField::window() const {
  return bricks_->window;
}

std::uint8_t BaseVectorField::coverage(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  return block ? block->coverage[static_cast<std::size_t>(Bricks::cell(v.x(), v.y(), v.z()))] : 0;
}

int BaseVectorField::tissue(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  return block ? block->tissue[static_cast<std::size_t>(Bricks::cell(v.x(), v.y(), v.z()))] : 0;
}

BaseVector BaseVectorField::at(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  if (!block) return {};
  const Bricks::Weighed w = bricks_->weigh(*block, Bricks::cell(v.x(), v.y(), v.z()));
  return {bricks_->voxelSize * w.toRepresentative, w.fraction};
}

std::optional<double> BaseVectorField::depth(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  if (!block) return std::nullopt;
  const Bricks::Weighed w = bricks_->weigh(*block, Bricks::cell(v.x(), v.y(), v.z()));
  if (w.fraction <= 0) return std::nullopt;
  const Vec3 outward = w.outward.isZero() ? Vec3::UnitZ() : w.outward;
  return bricks_->voxelSize * bricks_->depths.at(outward, w.fraction);
}

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

BaseVectorField::Mass BaseVectorField::mass() const {
  const Bricks& f = *bricks_;
  const double h = f.voxelSize, voxel = h * h * h;
  Mass result;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < f.sums.size(); ++k) {
    const TissueSums& s = f.sums[k];
    const auto d = [&](std::int64_t sum) { return static_cast<double>(sum) / 255; };
    Eigen::Matrix3d m;
    m << d(s.second[0]), d(s.second[3]), d(s.second[5]), d(s.second[3]), d(s.second[1]),
        d(s.second[4]), d(s.second[5]), d(s.second[4]), d(s.second[2]);
    // A voxel's own spread about its centre.
    m += Eigen::Matrix3d::Identity() * (d(s.zeroth) / 12);
    const double density = f.tissues[k].density;
    result.volume += voxel * d(s.zeroth);
    result.mass += density * voxel * d(s.zeroth);
    first += density * voxel * h * Vec3(d(s.first[0]), d(s.first[1]), d(s.first[2]));
    second += density * voxel * h * h * m;
  }
  if (!(result.mass > 0)) return result;
  const Vec3 center = first / result.mass;
  second -= result.mass * center * center.transpose();
  result.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  result.centerOfMass =
      f.origin + h * ((kBrickEdge / 2 * f.bricks).cast<double>() + Vec3::Constant(0.5)) + center;
  return result;
}

Cloud BaseVectorField::cloud() const {
  const Bricks& f = *bricks_;
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = f.bricks;
  voxels->materials = f.names;
  voxels->table.assign(f.table.size(), kEmptyBrick);
  if (!f.names.empty()) voxels->materialTable.assign(f.table.size(), -1);
  for (std::size_t k = 0; k < f.table.size(); ++k) {
    if (f.table[k] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[k])];
    const auto all = [&](const auto& values, int value) {
      return std::all_of(values.begin(), values.end(), [&](int v) { return v == value; });
    };
    if (all(block.coverage, 255)) {
      voxels->table[k] = kSolidBrick;
    } else if (!all(block.coverage, 0)) {
      voxels->table[k] = static_cast<std::int32_t>(voxels->coverage.size());
      voxels->coverage.push_back(block.coverage);
    }
    if (f.names.empty()) continue;
    if (all(block.tissue, block.tissue[0])) {
      voxels->materialTable[k] = -1 - block.tissue[0];
    } else {
      voxels->materialTable[k] = static_cast<std::int32_t>(voxels->material.size());
      voxels->material.push_back(block.tissue);
    }
  }
  return Cloud(f.voxelSize, f.origin, std::move(voxels));
}

std::uint64_t BaseVectorField::hash() const {
  const Bricks& f = *bricks_;
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a over whole numbers
  const auto mix = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  for (std::size_t entry = 0; entry < f.table.size(); ++entry) {
    if (f.table[entry] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[entry])];
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      if (block.coverage[k] == 0) continue;
      const CcMoments& m = block.moments[k];
      mix(entry * kBrickVoxels + k);
      mix(static_cast<std::uint64_t>(block.coverage[k]) << 8 | block.tissue[k]);
      for (const CcSum s : {m.mass, m.x, m.y, m.z, block.volume[k]})
        mix(static_cast<std::uint64_t>(static_cast<std::int64_t>(s)));
    }
  }
  for (const TissueSums& s : f.sums) {
    mix(static_cast<std::uint64_t>(s.zeroth));
    for (const std::int64_t v : s.first) mix(static_cast<std::uint64_t>(v));
    for (const std::int64_t v : s.second) mix(static_cast<std::uint64_t>(v));
  }
  return hash;
}

std::size_t BaseVectorField::bytes() const {
  return bricks_->blocks.capacity() * sizeof(FieldBlock) +
         bricks_->table.size() * sizeof(std::int32_t);
}

}  // namespace cloudcontact
