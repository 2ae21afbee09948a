// Nearest samples travel from voxel to neighboring voxel, layer by layer, as a distance transform
// carries them. Then the voxels are listed by the samples of each level.
#include "field/owned_voxels.h"

#include <algorithm>
#include <numeric>

#include "field/base_vector_bricks.h"

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;
using V3i = Eigen::Vector3i;

constexpr std::int32_t kNobody = -1;
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
  std::vector<std::uint32_t> coarser(fine.size(), 0);
  std::vector<float> best(fine.size(), -2);
  for (std::uint32_t k = 0; k < all.size(); ++k) {
    const SampleRun run = level.finer[level.cellOf[k]];
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i) {
      const float alike = normalOf(all, k).dot(normalOf(fine, i));
      if (alike > best[i]) best[i] = alike, coarser[i] = k;
    }
  }
  return coarser;
}

// Lists voxels by their owners on a level, and by their depth below these.
void listBy(const SampleColumns& samples, const std::vector<std::uint32_t>& owner,
            const OwnedVoxels& voxels, OwnedVoxels::Level& level) {
  level.firsts.assign(samples.size() + 1, 0);
  for (const std::uint32_t k : owner) ++level.firsts[k + 1];
  std::partial_sum(level.firsts.begin(), level.firsts.end(), level.firsts.begin());
  std::vector<std::uint32_t> next(level.firsts.begin(), level.firsts.end() - 1);
  std::vector<std::pair<float, std::uint32_t>> sorted(owner.size());
  for (std::uint32_t i = 0; i < owner.size(); ++i) {
    const std::uint32_t k = owner[i];
    const V3 by = positionOf(samples, k) - V3(voxels.x[i], voxels.y[i], voxels.z[i]);
    sorted[next[k]++] = {normalOf(samples, k).dot(by), i};
  }
  for (std::size_t k = 0; k < samples.size(); ++k)
    std::sort(sorted.begin() + level.firsts[k], sorted.begin() + level.firsts[k + 1]);
  level.order.resize(owner.size());
  for (std::size_t i = 0; i < owner.size(); ++i) level.order[i] = sorted[i].second;
}

void measureReach(const SampleColumns& samples, const OwnedVoxels& voxels,
                  OwnedVoxels::Level& level) {
  level.reach.resize(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const V3 at = positionOf(samples, k), n = normalOf(samples, k);
    OwnedReach& reach = level.reach[k];
    for (std::uint32_t i = level.firsts[k]; i < level.firsts[k + 1]; ++i) {
      const std::uint32_t e = level.order[i];
      const V3 by = V3(voxels.x[e], voxels.y[e], voxels.z[e]) - at;
      const float rise = n.dot(by);
      reach.below = std::max(reach.below, -rise);
      if (rise < -kShallow) continue;
      reach.above = std::max(reach.above, rise);
      reach.aside = std::max(reach.aside, (by - rise * n).norm());
    }
  }
}

template <typename Number>
void permute(const std::vector<std::uint32_t>& order, std::vector<Number>& values) {
  std::vector<Number> permuted(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) permuted[i] = values[order[i]];
  values = std::move(permuted);
}

// Puts the voxels in the order of the coarsest level.
void putInOrder(OwnedVoxels& voxels) {
  const std::vector<std::uint32_t> order = std::move(voxels.levels[kLevels - 1].order);
  voxels.levels[kLevels - 1].order.clear();
  permute(order, voxels.x), permute(order, voxels.y), permute(order, voxels.z);
  permute(order, voxels.coverage), permute(order, voxels.material);
  std::vector<std::uint32_t> place(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  for (int level = 0; level < kLevels - 1; ++level)
    for (std::uint32_t& voxel : voxels.levels[level].order) voxel = place[voxel];
}

std::shared_ptr<const OwnedVoxels> makeOwned(const FieldData& field) {
  const Cloud& cloud = field.cloud();
  const SampleSet& set = field.samples();
  auto owned = std::make_shared<OwnedVoxels>();
  std::vector<std::uint32_t> owner;
  Owners(field).each([&](const V3i& v, std::uint32_t k) {
    const V3 center = centerOf(v);
    owned->x.push_back(center.x()), owned->y.push_back(center.y()), owned->z.push_back(center.z());
    owned->coverage.push_back(cloud.coverage(v.x(), v.y(), v.z()));
    owned->material.push_back(cloud.material(v.x(), v.y(), v.z()));
    owner.push_back(k);
  });
  for (int level = 0; level < kLevels; ++level) {
    const SampleColumns& samples = set.levels[level].samples;
    if (level > 0) {
      const auto coarser = coarserOf(set.levels[level], set.levels[level - 1].samples);
      for (std::uint32_t& k : owner) k = coarser[k];
    }
    listBy(samples, owner, *owned, owned->levels[level]);
    measureReach(samples, *owned, owned->levels[level]);
  }
  putInOrder(*owned);
  for (std::vector<float>* const column : {&owned->x, &owned->y, &owned->z})
    column->resize(owned->size() + OwnedVoxels::kBeyond);
  return owned;
}

std::shared_ptr<const OwnedVectors> makeVectors(const OwnedVoxels& voxels,
                                                const BaseVectorBricks& bricks) {
  auto made = std::make_shared<OwnedVectors>();
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const V3i v(int(voxels.x[i]), int(voxels.y[i]), int(voxels.z[i]));
    const FieldBlock* const block = bricks.blockOf(v);
    Vec3 f = Vec3::Zero();
    if (block) f = bricks.weigh(*block, cellIndex(v)).toRepresentative;
    made->x.push_back(float(f.x())), made->y.push_back(float(f.y())),
        made->z.push_back(float(f.z()));
  }
  return made;
}

}  // namespace

std::size_t OwnedVoxels::bytes() const {
  std::size_t sum = size() * (3 * sizeof(float) + 2);
  for (const Level& level : levels)
    sum += (level.order.size() + level.firsts.size()) * sizeof(std::uint32_t) +
           level.reach.size() * sizeof(OwnedReach);
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
