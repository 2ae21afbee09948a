// Reads and cuts a field of base vectors. Its sums are the same integers either way: gathered from
// all windows when the field is built (brick_layout.h), or changed by cuts (brick_changes.h).
#include <cloudcontact/field/base_vector_field.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/hash.h"
#include "field/brick_changes.h"
#include "field/brick_layout.h"
#include "field/owned_vector_cache.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorBricks;

// Cuts the first voxel that still holds material to cut, and all others of the same density, since
// these can be spread together. Returns whether voxels of another density are left.
bool cutOneDensity(Bricks& f, FieldChanges& changes, std::span<const VoxelCut> voxels,
                   std::size_t& changed) {
  const VoxelIndex middle = kBrickEdge / 2 * f.bricks;
  int density = 0;
  bool others = false;
  for (const VoxelCut& c : voxels) {
    std::int32_t& entry = f.table[brickIndex(c.voxel, f.bricks)];
    if (entry == kNoBlock) continue;
    FieldBlock* block = &f.blocks[static_cast<std::size_t>(entry)];
    const auto cell = static_cast<std::size_t>(cellIndex(c.voxel));
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
    changes.add(f, c.voxel, density, less);
    ++changed;
  }
  changes.spread(f);
  return others;
}

// Bricks at most this far from one in which `part` has matter.
std::vector<std::uint8_t> bricksNear(const Cloud& part, int reach) {
  const Eigen::Vector3i n = part.bricks();
  std::vector<std::uint8_t> near(part.voxels().table.size(), 0);
  for (std::size_t t = 0; t < near.size(); ++t) {
    if (part.voxels().table[t] == kEmptyBrick) continue;
    const Eigen::Vector3i at = gridCell(t, n);
    const Eigen::Vector3i low = (at.array() - reach).cwiseMax(0),
                          high = (at.array() + reach).cwiseMin(n.array() - 1);
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int x = low.x(); x <= high.x(); ++x) near[gridIndex(x, y, z, n)] = 1;
  }
  return near;
}

// How many bricks a window reaches out of its own.
int reachOf(const Window& window) {
  const int most = std::max(-window.low.minCoeff(), window.high.maxCoeff());
  return (most + kBrickEdge - 1) / kBrickEdge;
}

// A copy with the bricks that `kept` marks.
std::unique_ptr<Bricks> someBricks(const Bricks& whole, const std::vector<std::uint8_t>& kept) {
  auto some = std::make_unique<Bricks>(whole.withoutBlocks());
  some->blocks.reserve(whole.tissues.size() +
                       static_cast<std::size_t>(std::count(kept.begin(), kept.end(), 1)));
  for (std::size_t t = 0; t < whole.table.size(); ++t) {
    const std::int32_t block = whole.table[t];
    if (block == kNoBlock || !kept[t]) continue;
    const bool shared = block < static_cast<std::int32_t>(whole.tissues.size());
    some->table[t] = shared ? block : static_cast<std::int32_t>(some->blocks.size());
    if (!shared) some->blocks.push_back(whole.blocks[static_cast<std::size_t>(block)]);
  }
  return some;
}

void keepBricks(Bricks& field, const std::vector<std::uint8_t>& kept) {
  for (std::size_t t = 0; t < kept.size(); ++t)
    if (!kept[t]) field.table[t] = kNoBlock;
}

// What of the field is not in `part`.
std::vector<VoxelCut> surplus(const Bricks& field, const Cloud& part) {
  std::vector<VoxelCut> cuts;
  for (std::size_t t = 0; t < field.table.size(); ++t) {
    if (field.table[t] == kNoBlock) continue;
    const FieldBlock& block = field.blocks[static_cast<std::size_t>(field.table[t])];
    const std::int32_t kept = part.voxels().table[t];
    if (kept == kSolidBrick) continue;
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      const std::uint8_t left = kept == kEmptyBrick
                                    ? std::uint8_t{0}
                                    : part.voxels().coverage[static_cast<std::size_t>(kept)][k];
      if (left < block.coverage[k])
        cuts.push_back(
            {kBrickEdge * gridCell(t, field.bricks) + cellOffset(static_cast<int>(k)), left});
    }
  }
  return cuts;
}

}  // namespace

struct BaseVectorField::State {
  std::unique_ptr<Bricks> bricks;
  OwnedVectorCache owned;
  FieldChanges changes;
};

BaseVectorField::BaseVectorField(const Cloud& cloud, const TissueTable& tissues,
                                 const WindowSettings& window)
    : state_(std::make_unique<State>()) {
  state_->bricks = layOutBricks(cloud, tissues, window);
  sumWindows(*state_->bricks);
  state_->changes.prepare(*state_->bricks);
}

BaseVectorField::BaseVectorField(std::unique_ptr<Bricks> bricks)
    : state_(std::make_unique<State>()) {
  state_->bricks = std::move(bricks);
  state_->changes.prepare(*state_->bricks);
}

const BaseVectorField::Bricks& BaseVectorField::bricks() const {
  return *state_->bricks;
}

OwnedVectorCache& BaseVectorField::owned() const {
  return state_->owned;
}

std::unique_ptr<BaseVectorField::Bricks> BaseVectorField::takeBricks() && {
  return std::move(state_->bricks);
}

BaseVectorField::~BaseVectorField() = default;
BaseVectorField::BaseVectorField(BaseVectorField&&) noexcept = default;
BaseVectorField& BaseVectorField::operator=(BaseVectorField&&) noexcept = default;

double BaseVectorField::voxelSize() const {
  return bricks().voxelSize;
}
const Vec3& BaseVectorField::origin() const {
  return bricks().origin;
}
Eigen::Vector3i BaseVectorField::size() const {
  return kBrickEdge * bricks().bricks;
}
const TissueTable& BaseVectorField::tissues() const {
  return bricks().tissues;
}
const Window& BaseVectorField::window() const {
  return bricks().window;
}

std::uint8_t BaseVectorField::coverage(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks().blockOf(v);
  return block ? block->coverage[static_cast<std::size_t>(cellIndex(v))] : 0;
}

int BaseVectorField::tissue(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks().blockOf(v);
  return block ? block->tissue[static_cast<std::size_t>(cellIndex(v))] : 0;
}

BaseVector BaseVectorField::at(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks().blockOf(v);
  if (!block) return {};
  const Bricks::Weighed w = bricks().weigh(*block, cellIndex(v));
  return {bricks().voxelSize * w.toRepresentative, w.fraction};
}

std::optional<double> BaseVectorField::depth(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks().blockOf(v);
  if (!block) return std::nullopt;
  const Bricks::Weighed w = bricks().weigh(*block, cellIndex(v));
  if (w.fraction <= 0) return std::nullopt;
  const Vec3 outward = w.outward.isZero() ? Vec3::UnitZ() : w.outward;
  return bricks().voxelSize * bricks().depths.at(outward, w.fraction);
}

std::size_t BaseVectorField::cut(Span<const VoxelCut> voxels) {
  Bricks& f = *state_->bricks;
  state_->owned.made.reset();
  for (const VoxelCut& c : voxels)
    if (!f.contains(c.voxel))
      throw std::out_of_range("BaseVectorField::cut: a voxel lies outside the grid");
  std::size_t changed = 0;
  for (bool more = true; more;) more = cutOneDensity(f, state_->changes, voxels, changed);
  return changed;
}

// What is to be cut away counts only in windows that hold matter of the part, so only so far from
// it.
void BaseVectorField::keepPart(const Cloud& part) {
  Bricks& f = *state_->bricks;
  if (part.empty()) throw std::invalid_argument("BaseVectorField::keepPart: the part is empty");
  if (part.bricks() != f.bricks || part.voxelSize() != f.voxelSize || part.origin() != f.origin)
    throw std::invalid_argument("BaseVectorField::keepPart: the part has another grid");
  keepBricks(f, bricksNear(part, reachOf(f.window)));
  cut(surplus(f, part));
  keepBricks(f, bricksNear(part, 0));
  sumTissues(f);
}

BaseVectorField BaseVectorField::ofPart(const Cloud& part) const {
  const bool fits = !part.empty() && part.bricks() == bricks().bricks;
  BaseVectorField result(
      someBricks(bricks(), fits ? bricksNear(part, reachOf(window()))
                                : std::vector<std::uint8_t>(bricks().table.size(), 0)));
  result.keepPart(part);
  return result;
}

void BaseVectorField::reserve() {
  Bricks& f = *state_->bricks;
  std::size_t shared = 0;
  for (const std::int32_t entry : f.table)
    shared += entry != kNoBlock && static_cast<std::size_t>(entry) < f.tissues.size();
  // resize() rather than reserve(), so that the pages are mapped too.
  const std::size_t used = f.blocks.size();
  f.blocks.resize(used + shared);
  f.blocks.resize(used);
}

MassProperties BaseVectorField::mass() const {
  return massOf(bricks(), bricks().sums);
}

Cloud BaseVectorField::cloud() const {
  const Bricks& f = bricks();
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
  const Bricks& f = bricks();
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
  for (const MatterSums& s : f.sums) {
    hash.addWord(static_cast<std::uint64_t>(s.mass));
    for (const std::int64_t v : s.first) hash.addWord(static_cast<std::uint64_t>(v));
    for (const std::int64_t v : s.second) hash.addWord(static_cast<std::uint64_t>(v));
  }
  return hash.value();
}

std::size_t BaseVectorField::bytes() const {
  return bricks().blocks.capacity() * sizeof(FieldBlock) +
         bricks().table.size() * sizeof(std::int32_t);
}

}  // namespace cloudcontact
