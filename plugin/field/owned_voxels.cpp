// Nearest samples travel from voxel to neighboring voxel, layer by layer, as a distance transform
// carries them. Then the voxels are listed by the samples of each level.
#include "field/owned_voxels.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "field/base_vector_bricks.h"

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;
using V3i = Eigen::Vector3i;

constexpr std::int32_t kNobody = -1;
constexpr std::uint32_t kNoOwner = ~0u;
// [voxels] A sample's own voxel is looked for this far behind it: one on a voxel's face belongs to
// the voxel behind.
constexpr float kBehind[] = {0.05f, 0.5f};
constexpr float kShallow = 1.5f;  // [voxels] what is deeper does not count for OwnedReach

V3 positionOf(const SampleColumns& samples, std::size_t k) {
  return {samples.x[k], samples.y[k], samples.z[k]};
}
V3 normalOf(const SampleColumns& samples, std::size_t k) {
  return {samples.nx[k], samples.ny[k], samples.nz[k]};
}
V3 centerOf(const V3i& v) {
  return v.cast<float>() + V3::Constant(0.5f);
}

// The owner of each voxel with matter.
class Owners {
 public:
  explicit Owners(const FieldData& field)
      : cloud_(field.cloud()),
        samples_(field.samples().levels[0].samples),
        slots_(cloud_.voxels().table.size(), kNobody) {
    for (std::size_t t = 0; t < slots_.size(); ++t)
      if (cloud_.voxels().table[t] != kEmptyBrick) {
        slots_[t] = static_cast<std::int32_t>(bricks_.size());
        bricks_.emplace_back().fill(kNobody);
      }
    seed();
    while (!frontier_.empty()) grow();
  }

  // Calls visit(voxel, owner) brick by brick.
  template <typename Visit>
  void each(const Visit& visit) const {
    for (std::size_t t = 0; t < slots_.size(); ++t) {
      if (slots_[t] < 0) continue;
      const V3i corner = kBrickEdge * gridCell(t, cloud_.bricks());
      const Brick& brick = bricks_[static_cast<std::size_t>(slots_[t])];
      for (int cell = 0; cell < kBrickVoxels; ++cell)
        if (const std::int32_t owner = brick[static_cast<std::size_t>(cell)]; owner >= 0)
          visit(V3i(corner + cellOffset(cell)), static_cast<std::uint32_t>(owner));
    }
  }

 private:
  using Brick = std::array<std::int32_t, kBrickVoxels>;

  std::int32_t* at(const V3i& v) {
    if (!insideGrid(v, cloud_.size())) return nullptr;
    const std::int32_t slot = slots_[brickIndex(v, cloud_.bricks())];
    if (slot < 0) return nullptr;
    return &bricks_[static_cast<std::size_t>(slot)][static_cast<std::size_t>(cellIndex(v))];
  }
  bool hasMatter(const V3i& v) const { return cloud_.coverage(v.x(), v.y(), v.z()) > 0; }
  float distance2(const V3& center, std::int32_t sample) const {
    return (center - positionOf(samples_, static_cast<std::size_t>(sample))).squaredNorm();
  }
  // Whether `one` is nearer than `other`; of equals the first.
  bool nearer(const V3& center, std::int32_t one, std::int32_t other) const {
    if (other == kNobody) return true;
    const float a = distance2(center, one), b = distance2(center, other);
    return a != b ? a < b : one < other;
  }

  void seed() {
    for (std::size_t k = 0; k < samples_.size(); ++k)
      for (const float behind : kBehind) {
        const V3 place = positionOf(samples_, k) - behind * normalOf(samples_, k);
        const V3i v = place.array().floor().cast<int>();
        std::int32_t* const owner = at(v);
        if (!owner || !hasMatter(v)) continue;
        const auto sample = static_cast<std::int32_t>(k);
        if (*owner == kNobody) frontier_.push_back(v);
        if (nearer(centerOf(v), sample, *owner)) *owner = sample;
        break;
      }
  }

  // The next layer: free voxels beside the last one. They take the nearest of their neighbors'
  // owners; none sees another of its own layer.
  void grow() {
    std::vector<V3i> next;
    for (const V3i& v : frontier_)
      eachNeighbor(v, [&](const V3i& w, std::int32_t& owner) {
        if (owner != kNobody || !hasMatter(w)) return;
        owner = kWaits;
        next.push_back(w);
      });
    std::vector<std::int32_t> found(next.size(), kNobody);
    for (std::size_t i = 0; i < next.size(); ++i) {
      const V3 center = centerOf(next[i]);
      eachNeighbor(next[i], [&](const V3i&, std::int32_t owner) {
        if (owner >= 0 && owner != found[i] && nearer(center, owner, found[i])) found[i] = owner;
      });
    }
    for (std::size_t i = 0; i < next.size(); ++i) *at(next[i]) = found[i];
    frontier_ = std::move(next);
  }

  template <typename Visit>
  void eachNeighbor(const V3i& v, const Visit& visit) {
    const auto inner = [](int i) { return (i & 7) > 0 && (i & 7) < 7; };
    std::int32_t* const own = at(v);
    const bool inside = inner(v.x()) && inner(v.y()) && inner(v.z());
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const V3i w = v + V3i(x, y, z);
          std::int32_t* const owner = inside ? own + (x + 8 * y + 64 * z) : at(w);
          if (owner) visit(w, *owner);
        }
  }

  static constexpr std::int32_t kWaits = -2;

  const Cloud& cloud_;
  const SampleColumns& samples_;
  std::vector<std::int32_t> slots_;  // of each brick of the grid
  std::vector<Brick> bricks_;
  std::vector<V3i> frontier_;
};

// For each sample of a level the one of the next coarser level that stands for it: of its cell's
// samples, the one that faces most alike.
std::vector<std::uint32_t> coarserOf(const SampleLevel& level, const SampleColumns& fine) {
  const SampleColumns& all = level.samples;
  std::vector<std::uint32_t> coarser(fine.size(), kNoOwner);
  for (std::uint32_t k = 0; k < all.size(); ++k) {
    const SampleRun run = level.finer[level.cellOf[k]];
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i) {
      const auto alike = [&](std::uint32_t one) {
        return normalOf(all, one).dot(normalOf(fine, i));
      };
      if (coarser[i] == kNoOwner || alike(k) > alike(coarser[i])) coarser[i] = k;
    }
  }
  return coarser;
}

// A voxel with matter.
struct Matter {
  V3i at;
  std::uint8_t coverage, material;
  std::uint32_t owner;
};

void measureReach(OwnedVoxels::Level& level) {
  for (const OwnedRun& run : level.runs) {
    const V3 at(run.at), n(run.normal);
    OwnedReach& reach = level.reach.emplace_back();
    for (std::uint32_t i = run.first; i < run.last; ++i) {
      const V3 by = level.voxels[i].center() - at;
      const float rise = n.dot(by);
      reach.below = std::max(reach.below, -rise);
      if (rise < -kShallow) continue;
      reach.above = std::max(reach.above, rise);
      reach.aside = std::max(reach.aside, (by - rise * n).norm());
    }
  }
}

void makeBoxes(OwnedVoxels::Level& level) {
  constexpr std::uint32_t kBoxed = OwnedVoxels::kBoxed;
  std::uint32_t count = 0;
  for (OwnedRun& run : level.runs) {
    run.box = count;
    count += (run.size() + kBoxed - 1) / kBoxed;
  }
  OwnedBoxes& boxes = level.boxes;
  for (LargeVector<float>* const column :
       {&boxes.x, &boxes.y, &boxes.z, &boxes.halfX, &boxes.halfY, &boxes.halfZ})
    column->resize(count + OwnedVoxels::kBeyond);
  for (const OwnedRun& run : level.runs)
    for (std::uint32_t first = run.first, at = run.box; first < run.last; first += kBoxed, ++at) {
      Eigen::AlignedBox3f box;
      for (std::uint32_t i = first; i < std::min(run.last, first + kBoxed); ++i)
        box.extend(level.voxels[i].center());
      const V3 middle = box.center(), half = 0.5f * box.sizes();
      boxes.x[at] = middle.x(), boxes.y[at] = middle.y(), boxes.z[at] = middle.z();
      boxes.halfX[at] = half.x(), boxes.halfY[at] = half.y(), boxes.halfZ[at] = half.z();
    }
}

// Lists the voxels by their owners on a level.
void listBy(const SampleColumns& samples, const std::vector<Matter>& voxels,
            OwnedVoxels::Level& level) {
  std::vector<std::uint32_t> firsts(samples.size() + 1, 0);
  for (const Matter& v : voxels) ++firsts[v.owner + 1];
  std::partial_sum(firsts.begin(), firsts.end(), firsts.begin());
  std::vector<std::uint32_t> next(firsts.begin(), firsts.end() - 1);
  std::vector<std::pair<float, std::uint32_t>> sorted(voxels.size());
  for (std::uint32_t i = 0; i < voxels.size(); ++i) {
    const std::uint32_t k = voxels[i].owner;
    const V3 by = positionOf(samples, k) - centerOf(voxels[i].at);
    sorted[next[k]++] = {normalOf(samples, k).dot(by), i};
  }
  for (std::size_t k = 0; k < samples.size(); ++k) {
    std::sort(sorted.begin() + firsts[k], sorted.begin() + firsts[k + 1]);
    OwnedRun run{{}, {}, firsts[k], firsts[k + 1], 0};
    V3::Map(run.at) = positionOf(samples, k);
    V3::Map(run.normal) = normalOf(samples, k);
    level.runs.push_back(run);
  }
  for (const auto& one : sorted) {
    const Matter& v = voxels[one.second];
    level.voxels.push_back(OwnedVoxel::of(v.at, v.coverage, v.material));
  }
  level.voxels.resize(voxels.size() + OwnedVoxels::kBeyond);
  measureReach(level);
  makeBoxes(level);
}

std::shared_ptr<const OwnedVoxels> makeOwned(const FieldData& field) {
  const Cloud& cloud = field.cloud();
  const SampleSet& set = field.samples();
  std::vector<Matter> voxels;
  Owners(field).each([&](const V3i& v, std::uint32_t k) {
    voxels.push_back(
        {v, cloud.coverage(v.x(), v.y(), v.z()), cloud.material(v.x(), v.y(), v.z()), k});
  });
  auto owned = std::make_shared<OwnedVoxels>();
  for (int level = 0; level < kLevels; ++level) {
    if (level > 0) {
      const auto coarser = coarserOf(set.levels[level], set.levels[level - 1].samples);
      for (Matter& v : voxels) v.owner = coarser[v.owner];
    }
    listBy(set.levels[level].samples, voxels, owned->levels[level]);
  }
  return owned;
}

OwnedVectors::Level vectorsOf(const OwnedVoxels::Level& level, const BaseVectorBricks& bricks) {
  OwnedVectors::Level made;
  for (std::vector<float>* const column : {&made.x, &made.y, &made.z, &made.length})
    column->resize(level.voxels.size());
  for (std::size_t i = 0; i < level.size(); ++i) {
    const V3i v = level.voxels[i].center().array().floor().cast<int>();
    const FieldBlock* const block = bricks.blockOf(v);
    if (!block) continue;
    const V3 f = bricks.weigh(*block, cellIndex(v)).toRepresentative.cast<float>();
    made.x[i] = f.x(), made.y[i] = f.y(), made.z[i] = f.z(), made.length[i] = f.norm();
  }
  return made;
}

std::shared_ptr<const OwnedVectors> makeVectors(const OwnedVoxels& voxels,
                                                const BaseVectorBricks& bricks) {
  auto made = std::make_shared<OwnedVectors>();
  for (const OwnedVoxels::Level& level : voxels.levels)
    made->levels.push_back(vectorsOf(level, bricks));
  return made;
}

}  // namespace

std::size_t OwnedVoxels::bytes() const {
  std::size_t sum = 0;
  for (const Level& level : levels)
    sum += level.runs.size() * (sizeof(OwnedRun) + sizeof(OwnedReach)) +
           level.boxes.x.size() * 6 * sizeof(float) + level.voxels.size() * sizeof(OwnedVoxel);
  return sum;
}

const OwnedVoxels& ownedVoxels(const FieldData& field) {
  LazyOwnedVoxels& lazy = field.lazyVoxels();
  std::call_once(lazy.once, [&] { lazy.made = makeOwned(field); });
  return *lazy.made;
}

std::shared_ptr<const OwnedVectors> ownedVectors(const FieldData& field,
                                                 const BaseVectorField& vectors) {
  const OwnedVoxels& voxels = ownedVoxels(field);
  OwnedVectorCache& cache = vectors.owned();
  const std::lock_guard lock(cache.mutex);
  if (!cache.made || cache.field.lock() != field.life()) {
    cache.made = makeVectors(voxels, vectors.bricks());
    cache.field = field.life();
  }
  return cache.made;
}

}  // namespace cloudcontact
