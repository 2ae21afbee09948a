// Connected parts, in two steps. First within each brick: a solid brick is one patch; in others a
// flood fill over the 512 voxels labels the patches. Then patches that touch across faces of bricks
// are joined by union-find. The lower number becomes the root, so parts are in the order of their
// first patches. Solid bricks are not searched.
#include <cloudcontact/voxels/pieces.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include "base/grid_index.h"
#include "voxels/cloud_builder.h"
#include "voxels/cut_between.h"

namespace cloudcontact {

namespace {

constexpr std::uint16_t kNone = 0xffff;
using BrickLabels = std::array<std::uint16_t, kBrickVoxels>;

// Labels connected voxels of a brick, in the order of their first voxels. Returns the number of
// labels.
int labelBrick(const BrickCoverage& coverage, BrickLabels& labels) {
  labels.fill(kNone);
  int count = 0;
  std::array<std::uint16_t, kBrickVoxels> open;
  for (int first = 0; first < kBrickVoxels; ++first) {
    const auto at = [](auto& values, int v) -> auto& {
      return values[v];
    };
    if (at(coverage, first) == 0 || at(labels, first) != kNone) continue;
    const auto label = static_cast<std::uint16_t>(count++);
    int waiting = 1;
    at(open, 0) = static_cast<std::uint16_t>(first);
    at(labels, first) = label;
    while (waiting > 0) {
      const int v = at(open, --waiting);
      for (int axis = 0; axis < 3; ++axis) {
        const int step = 1 << 3 * axis, place = v >> 3 * axis & 7;
        for (const int side : {-1, 1}) {
          if (place + side < 0 || place + side >= kBrickEdge) continue;
          const int w = v + side * step;
          if (at(coverage, w) == 0 || at(labels, w) != kNone) continue;
          at(labels, w) = label;
          at(open, waiting++) = static_cast<std::uint16_t>(w);
        }
      }
    }
  }
  return count;
}

// The patches of all bricks, and the parts that they form.
class Patches {
 public:
  explicit Patches(const Cloud::Voxels& voxels)
      : voxels_(voxels), labels_(voxels.coverage.size()), firsts_(voxels.table.size()) {
    int patches = 0;
    for (std::size_t t = 0; t < firsts_.size(); ++t) {
      const std::int32_t b = voxels.table[t];
      firsts_[t] = patches;
      if (b == kSolidBrick)
        ++patches;
      else if (b >= 0)
        patches += labelBrick(voxels.coverage[b], labels_[b]);
    }
    up_.resize(patches);
    std::iota(up_.begin(), up_.end(), 0);
    for (std::size_t t = 0; t < firsts_.size(); ++t)
      for (int axis = 0; axis < 3; ++axis) joinAcross(t, axis);
    numberParts();
  }

  int parts() const { return parts_; }
  // The part of a voxel; -1: none.
  int partOf(std::size_t t, int cell) const {
    const int patch = patchOf(t, cell);
    return patch < 0 ? -1 : part_[patch];
  }
  // The part of all material of a brick; -1: several, or no material.
  int onlyPart(std::size_t t) const {
    const int end = t + 1 < firsts_.size() ? firsts_[t + 1] : static_cast<int>(part_.size());
    if (firsts_[t] == end) return -1;
    const int part = part_[firsts_[t]];
    for (int p = firsts_[t] + 1; p < end; ++p)
      if (part_[p] != part) return -1;
    return part;
  }

 private:
  int patchOf(std::size_t t, int cell) const {
    const std::int32_t b = voxels_.table[t];
    if (b == kEmptyBrick) return -1;
    if (b == kSolidBrick) return firsts_[t];
    const std::uint16_t label = labels_[b][cell];
    return label == kNone ? -1 : firsts_[t] + label;
  }

  int rootOf(int patch) {
    const auto up = [this](int p) -> int& { return up_[p]; };
    for (; up(patch) != patch; patch = up(patch)) up(patch) = up(up(patch));
    return patch;
  }

  void join(int a, int b) {
    if (a < 0 || b < 0) return;
    a = rootOf(a);
    b = rootOf(b);
    up_[std::max(a, b)] = std::min(a, b);
  }

  void joinAcross(std::size_t t, int axis) {
    const Eigen::Vector3i& n = voxels_.bricks;
    if (gridCell(t, n)[axis] + 1 >= n[axis]) return;
    const int stride = axis == 0 ? 1 : axis == 1 ? n.x() : n.x() * n.y();
    const std::size_t other = t + stride;
    if (voxels_.table[t] == kEmptyBrick || voxels_.table[other] == kEmptyBrick) return;
    if (voxels_.table[t] == kSolidBrick && voxels_.table[other] == kSolidBrick)
      return join(firsts_[t], firsts_[other]);
    const int step = 1 << 3 * axis;
    for (int cell = 0; cell < kBrickVoxels; ++cell)
      if ((cell >> 3 * axis & 7) == 7) join(patchOf(t, cell), patchOf(other, cell - 7 * step));
  }

  // Numbers the parts in the order of their first patches.
  void numberParts() {
    part_.resize(up_.size());
    for (int p = 0; p < static_cast<int>(up_.size()); ++p) {
      const int root = rootOf(p);
      part_[p] = root == p ? parts_++ : part_[root];
    }
  }

  const Cloud::Voxels& voxels_;
  std::vector<BrickLabels> labels_;  // by stored brick
  std::vector<int> firsts_;          // first patch of each brick
  std::vector<int> up_;              // parent of each patch
  std::vector<int> part_;            // part of each patch
  int parts_ = 0;
};

// Copy a brick's materials, and its coverage, to a part.
void copyMaterials(const Cloud::Voxels& whole, std::size_t t, Cloud::Voxels& part) {
  if (whole.materialTable.empty()) return;
  const std::int32_t m = whole.materialTable[t];
  part.materialTable[t] = m < 0 ? m : static_cast<std::int32_t>(part.material.size());
  if (m >= 0) part.material.push_back(whole.material[m]);
}

void copyCoverage(const BrickCoverage& coverage, std::size_t t, Cloud::Voxels& part) {
  part.table[t] = static_cast<std::int32_t>(part.coverage.size());
  part.coverage.push_back(coverage);
}

// Divides a brick of several parts.
void divide(const Cloud::Voxels& whole, const Patches& patches, std::size_t t,
            std::vector<std::shared_ptr<Cloud::Voxels>>& parts) {
  const BrickCoverage& all = whole.coverage[whole.table[t]];
  for (int cell = 0; cell < kBrickVoxels; ++cell) {
    const int p = patches.partOf(t, cell);
    if (p < 0) continue;
    Cloud::Voxels& part = *parts[p];
    if (part.table[t] == kEmptyBrick) {
      copyCoverage(BrickCoverage{}, t, part);
      copyMaterials(whole, t, part);
    }
    const auto k = static_cast<std::size_t>(cell);
    part.coverage.back()[k] = all[k];
  }
}

}  // namespace

std::vector<Cloud> pieces(const Cloud& cloud) {
  if (cloud.empty()) return {};
  const Cloud::Voxels& whole = cloud.voxels();
  const Patches patches(whole);
  if (patches.parts() == 1) return {cloud};
  std::vector<std::shared_ptr<Cloud::Voxels>> parts;
  for (int p = 0; p < patches.parts(); ++p)
    parts.push_back(emptyVoxels(whole.bricks, whole.materials));
  for (std::size_t t = 0; t < whole.table.size(); ++t) {
    const std::int32_t b = whole.table[t];
    const int only = b == kEmptyBrick ? -1 : patches.onlyPart(t);
    if (only < 0) {
      if (b >= 0) divide(whole, patches, t, parts);
      continue;
    }
    Cloud::Voxels& part = *parts[only];
    if (b == kSolidBrick)
      part.table[t] = kSolidBrick;
    else
      copyCoverage(whole.coverage[b], t, part);
    copyMaterials(whole, t, part);
  }
  std::vector<Cloud> result;
  for (auto& part : parts) result.emplace_back(cloud.voxelSize(), cloud.origin(), std::move(part));
  return result;
}

namespace {

// The voxels near a cut, as far as one step from those that it emptied.
class CutPlace {
 public:
  CutPlace(const Cloud& after, const Cloud& before) : after_(after) {
    for (const VoxelCut& cut : cutsBetween(before, after))
      if (cut.coverage == 0) emptied_.push_back(cut.voxel);
    for (const Eigen::Vector3i& v : emptied_) {
      low_ = low_.cwiseMin(v - Eigen::Vector3i::Ones());
      high_ = high_.cwiseMax(v + Eigen::Vector3i::Ones());
    }
  }

  // True if all voxels beside emptied ones are connected within the box around these. False: not
  // known.
  bool connected() const {
    if (emptied_.empty()) return true;
    const Eigen::Vector3i size = high_ - low_ + Eigen::Vector3i::Ones();
    if (size.cast<double>().prod() > kMostVoxels) return false;
    std::vector<std::uint8_t> state(static_cast<std::size_t>(size.prod()));
    const auto at = [&](const Eigen::Vector3i& v) -> std::uint8_t& {
      return state[gridIndex(v - low_, size)];
    };
    std::vector<Eigen::Vector3i> open;
    std::size_t beside = 0;
    for (const Eigen::Vector3i& v : emptied_)
      forEachFace(v, [&](const Eigen::Vector3i& w) {
        if (at(w) == kBeside || !filled(w)) return;
        at(w) = kBeside;
        ++beside;
        if (open.empty()) open.push_back(w);
      });
    if (beside == 0) return false;
    std::size_t met = 1;
    at(open.front()) = kMet;
    while (!open.empty() && met < beside) {
      const Eigen::Vector3i v = open.back();
      open.pop_back();
      forEachFace(v, [&](const Eigen::Vector3i& w) {
        if ((w.array() < low_.array()).any() || (w.array() > high_.array()).any()) return;
        if (at(w) == kMet || !filled(w)) return;
        met += at(w) == kBeside;
        at(w) = kMet;
        open.push_back(w);
      });
    }
    return met == beside;
  }

 private:
  static constexpr std::uint8_t kBeside = 1, kMet = 2;
  static constexpr double kMostVoxels = 1 << 15;  // of a box; a larger one costs as much as all

  bool filled(const Eigen::Vector3i& v) const { return after_.coverage(v.x(), v.y(), v.z()) > 0; }
  template <typename Visit>
  static void forEachFace(const Eigen::Vector3i& v, Visit&& visit) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) visit(Eigen::Vector3i(v + side * Eigen::Vector3i::Unit(axis)));
  }

  const Cloud& after_;
  std::vector<Eigen::Vector3i> emptied_;
  Eigen::Vector3i low_ = Eigen::Vector3i::Constant(1 << 20), high_ = -low_;
};

}  // namespace

// What was connected through emptied voxels, was so through voxels beside them.
std::vector<Cloud> pieces(const Cloud& after, const Cloud& before) {
  if (after.empty() || after.bricks() != before.bricks()) return pieces(after);
  if (CutPlace(after, before).connected()) return {after};
  return pieces(after);
}

namespace {

void validate(const Cloud& cloud, std::span<const VoxelCut> cuts) {
  if (cloud.empty()) throw std::invalid_argument("cutCloud: the cloud is empty");
  const Eigen::Vector3i n = cloud.size();
  for (const VoxelCut& c : cuts)
    if (!insideGrid(c.voxel, n))
      throw std::out_of_range("cutCloud: voxel (" + std::to_string(c.voxel.x()) + ", " +
                              std::to_string(c.voxel.y()) + ", " + std::to_string(c.voxel.z()) +
                              ") is outside the cloud's grid");
}

// Gives every brick numbers of its own and drops those of empty bricks.
void tidy(Cloud::Voxels& voxels) {
  std::vector<BrickCoverage> kept;
  kept.reserve(voxels.coverage.size());
  for (std::int32_t& b : voxels.table) {
    if (b < 0) continue;
    const BrickCoverage& brick = voxels.coverage[b];
    const bool empty = std::all_of(brick.begin(), brick.end(), [](auto c) { return c == 0; });
    b = empty ? kEmptyBrick : static_cast<std::int32_t>(kept.size());
    if (!empty) kept.push_back(brick);
  }
  voxels.coverage = std::move(kept);
}

}  // namespace

Cloud cutCloud(const Cloud& cloud, Span<const VoxelCut> cuts) {
  validate(cloud, cuts);
  auto voxels = std::make_shared<Cloud::Voxels>(cloud.voxels());
  tidy(*voxels);
  for (const VoxelCut& c : cuts) {
    std::int32_t& slot = voxels->table[brickIndex(c.voxel, voxels->bricks)];
    if (slot == kEmptyBrick || (slot == kSolidBrick && c.coverage == 255)) continue;
    if (slot == kSolidBrick) {
      slot = static_cast<std::int32_t>(voxels->coverage.size());
      voxels->coverage.emplace_back().fill(255);
    }
    std::uint8_t& left = voxels->coverage[slot][cellIndex(c.voxel)];
    left = std::min(left, c.coverage);
  }
  tidy(*voxels);
  return Cloud(cloud.voxelSize(), cloud.origin(), std::move(voxels));
}

}  // namespace cloudcontact
