// A field of base vectors, read and cut. The sums are the same integers whichever way they come
// about: gathered from a window's voxels when the field is built (field_layout.h), or changed by
// what is cut (field_changes.h).
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/hash.h"
#include "workpiece/brick_layout.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

// Cuts the first voxel that is there, and all others of its density: these spread together. Returns
// whether some of another density are left.
bool cutOneDensity(Bricks& f, std::span<const VoxelCut> voxels, std::size_t& changed) {
  const VoxelIndex middle = kBrickEdge / 2 * f.bricks;
  int density = 0;
  bool others = false;
  for (const VoxelCut& c : voxels) {
    std::int32_t& entry = f.entry(c.voxel.x() >> 3, c.voxel.y() >> 3, c.voxel.z() >> 3);
    if (entry == kNoBlock) continue;
    FieldBlock* block = &f.blocks[static_cast<std::size_t>(entry)];
    const auto cell = static_cast<std::size_t>(Bricks::cell(c.voxel.x(), c.voxel.y(), c.voxel.z()));
    const int less = c.coverage - block->coverage[cell];
    if (less >= 0) continue;
    const std::uint8_t tissue = block->tissue[cell];
    if (density == 0) density = f.density[tissue];
    if (density != f.density[tissue]) {
      others = true;
      continue;
    }
    block = &f.own(entry);
    block->coverage[cell] = c.coverage;
    if (c.coverage == 0) block->tissue[cell] = 0;
    f.sums[tissue].add(c.voxel - middle, less);
    f.changes.add(f, c.voxel, density, less);
    ++changed;
  }
  f.changes.spread(f);
  return others;
}

}  // namespace

void TissueSums::add(const VoxelIndex& at, std::int64_t coverage) {
  const std::int64_t x = at.x(), y = at.y(), z = at.z();
  zeroth += coverage;
  first[0] += coverage * x, first[1] += coverage * y, first[2] += coverage * z;
  second[0] += coverage * x * x, second[1] += coverage * y * y, second[2] += coverage * z * z;
  second[3] += coverage * x * y, second[4] += coverage * y * z, second[5] += coverage * z * x;
}

BaseVectorField::BaseVectorField(const Cloud& cloud, const TissueTable& tissues,
                                 const WindowSettings& window)
    : bricks_(layOutBricks(cloud, tissues, window)) {
  sumWindows(*bricks_);
  bricks_->changes.prepare(*bricks_);
}

BaseVectorField::BaseVectorField(std::unique_ptr<Bricks> bricks) : bricks_(std::move(bricks)) {
  bricks_->changes.prepare(*bricks_);
}

std::unique_ptr<Bricks> BaseVectorField::takeBricks() && {
  return std::move(bricks_);
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
  std::size_t changed = 0;
  for (bool more = true; more;) more = cutOneDensity(f, voxels, changed);
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

MassProperties BaseVectorField::mass() const {
  return massOf(*bricks_, bricks_->sums);
}

MassProperties massOf(const Bricks& f, const std::vector<TissueSums>& sums) {
  const double h = f.voxelSize, voxel = h * h * h;
  MassProperties result;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const TissueSums& s = sums[k];
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
  Fnv1a hash;
  for (std::size_t entry = 0; entry < f.table.size(); ++entry) {
    if (f.table[entry] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[entry])];
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      if (block.coverage[k] == 0) continue;
      const CcMoments& m = block.moments[k];
      hash.addWord(entry * kBrickVoxels + k);
      hash.addWord(static_cast<std::uint64_t>(block.coverage[k]) << 8 | block.tissue[k]);
      for (const CcSum s : {m.mass, m.x, m.y, m.z, block.volume[k]})
        hash.addWord(static_cast<std::uint64_t>(static_cast<std::int64_t>(s)));
    }
  }
  for (const TissueSums& s : f.sums) {
    hash.addWord(static_cast<std::uint64_t>(s.zeroth));
    for (const std::int64_t v : s.first) hash.addWord(static_cast<std::uint64_t>(v));
    for (const std::int64_t v : s.second) hash.addWord(static_cast<std::uint64_t>(v));
  }
  return hash.value();
}

std::size_t BaseVectorField::bytes() const {
  return bricks_->blocks.capacity() * sizeof(FieldBlock) +
         bricks_->table.size() * sizeof(std::int32_t);
}

}  // namespace cloudcontact
