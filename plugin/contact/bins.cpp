// Bins in a flat table, and the patches that grow from the heaviest of them.
#include "bins.h"

#include "simd.h"

#include <algorithm>
#include <functional>

namespace cloudcontact {

namespace {

constexpr std::size_t kShareHits = 1024;  // a share of the summing
constexpr std::size_t kFewSlots = 1024;   // of bins by key, to begin with
constexpr double kMostBox = 4096;         // cells in a box that is looked up directly

std::size_t slotOf(std::uint64_t key) {
  return static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> 40);
}

struct HitKeys {
  std::int32_t *x, *y, *z, *direction;
  float* gate;
};

// Cell and direction of every hit.
CC_LANES void keysOf(const HitColumns& hits, float perCell, const HitKeys& keys) {
  const HitColumns::Columns<const float> c = hits.columns();
  const std::int8_t* const sides = hits.sides();
  const HitKeys to = keys;
  const int count = static_cast<int>(hits.size());
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
    const CcBinOfHit bin = ccBinOf(at, own, other, c.facing[i], sides[i], perCell);
    to.x[i] = bin.x;
    to.y[i] = bin.y;
    to.z[i] = bin.z;
    to.direction[i] = bin.direction;
    to.gate[i] = bin.gate;
  }
}

CcFaces facesOf(const Sums& sums) {
  CcFaces faces;
  for (int s = 0; s < 2; ++s) {
    Eigen::Map<Vec3>(faces.normal[s]) = sums.normal[s];
    faces.length[s] = ccLength64(faces.normal[s]);
  }
  return faces;
}

double weightOf(const Sums& sums) {
  return sums.side[0].size + sums.side[1].size;
}

}  // namespace

void Binner::fit(const Binner& other) {
  const auto fit = [](auto& to, const auto& from) { to.reserve(from.capacity()); };
  fit(cellX_, other.cellX_), fit(cellY_, other.cellY_), fit(cellZ_, other.cellZ_);
  fit(direction_, other.direction_), fit(gate_, other.gate_), fit(bin_, other.bin_);
  fit(bins_, other.bins_), fit(sums_, other.sums_), fit(keys_, other.keys_);
  fit(table_, other.table_), fit(box_, other.box_), fit(order_, other.order_);
  fit(queue_, other.queue_), fit(patches_, other.patches_);
}

void Binner::findBins(const HitColumns& hits, double cell) {
  const std::size_t count = hits.size();
  for (auto* v : {&cellX_, &cellY_, &cellZ_, &direction_})
    if (v->size() < count) v->resize(count);
  if (gate_.size() < count) gate_.resize(count);
  bin_.resize(count);
  keysOf(hits, static_cast<float>(1 / cell),
         {cellX_.data(), cellY_.data(), cellZ_.data(), direction_.data(), gate_.data()});
  bins_.clear();
  keys_.clear();
  slots_ = kFewSlots;
  clearSlots();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t bin = binOf(ccBinKey(cellX_[i], cellY_[i], cellZ_[i], direction_[i]));
    if (bin == bins_.size()) {
      Bin& made = bins_.emplace_back();
      made.cell[0] = cellX_[i];
      made.cell[1] = cellY_[i];
      made.cell[2] = cellZ_[i];
    }
    bin_[i] = bin;
    ++bins_[bin].end;
  }
}

// The key's bin; the one after the last where it has none yet, and then it is its.
std::uint32_t Binner::binOf(std::uint64_t key) {
  const std::size_t mask = slots_ - 1;
  std::size_t slot = slotOf(key) & mask;
  for (; table_[slot] >= 0; slot = (slot + 1) & mask)
    if (keys_[static_cast<std::size_t>(table_[slot])] == key)
      return static_cast<std::uint32_t>(table_[slot]);
  const std::uint32_t made = static_cast<std::uint32_t>(keys_.size());
  table_[slot] = static_cast<std::int32_t>(made);
  keys_.push_back(key);
  if (keys_.size() * 2 > slots_) enlarge();
  return made;
}

void Binner::clearSlots() {
  if (table_.size() < slots_) table_.resize(slots_);
  std::fill_n(table_.begin(), slots_, -1);
}

void Binner::enlarge() {
  slots_ *= 4;
  clearSlots();
  const std::size_t mask = slots_ - 1;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    std::size_t slot = slotOf(keys_[i]) & mask;
    while (table_[slot] >= 0) slot = (slot + 1) & mask;
    table_[slot] = static_cast<std::int32_t>(i);
  }
}

// Hits in the order of their bins.
void Binner::order(const HitColumns& hits) {
  std::uint32_t begin = 0;
  for (Bin& bin : bins_) {
    const std::uint32_t count = bin.end;
    bin.end = begin;
    begin += count;
  }
  order_.resize(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i)
    order_[bins_[bin_[i]].end++] = static_cast<std::uint32_t>(i);
  sums_.assign(bins_.size(), Sums{});
}

// Each bin's hits at one go, of the bins from `first` to `last`.
void Binner::sum(const HitColumns& hits, double cell, bool oneSided, std::size_t first,
                 std::size_t last) {
  std::uint32_t begin = first > 0 ? bins_[first - 1].end : 0;
  for (std::size_t b = first; b < last; ++b) {
    Bin& bin = bins_[b];
    Sums& sums = sums_[b];
    sums.origin = Vec3(bin.cell[0] + 0.5, bin.cell[1] + 0.5, bin.cell[2] + 0.5) * cell;
    addHits(hits, gate_.data(), order_.data() + begin, order_.data() + bin.end, oneSided, cell,
            sums);
    begin = bin.end;
    bin.weight = weightOf(sums);
    bin.faces = facesOf(sums);
  }
}

// Neighbours are looked up 27 times a bin, mostly in vain: in a box of cells that is a read each.
void Binner::layOut() {
  box_.clear();
  if (bins_.empty()) return;
  std::int32_t high[3];
  for (int i = 0; i < 3; ++i) low_[i] = high[i] = bins_[0].cell[i];
  for (const Bin& bin : bins_)
    for (int i = 0; i < 3; ++i) {
      low_[i] = std::min(low_[i], bin.cell[i]);
      high[i] = std::max(high[i], bin.cell[i]);
    }
  double all = 1;
  for (int i = 0; i < 3; ++i) all *= static_cast<double>(high[i]) - low_[i] + 3;
  hashed_ = all > kMostBox;
  // A cell of margin all around, so that a neighbour is never outside.
  for (int i = 0; i < 3; ++i) span_[i] = high[i]-- - low_[i]-- + 3;
  if (!hashed_) box_.assign(static_cast<std::size_t>(all), -1);
  for (std::size_t b = 0; b < bins_.size(); ++b) {
    Bin& bin = bins_[b];
    std::int32_t* first = nullptr;
    if (hashed_) {
      const std::uint32_t cell = binOf(ccBinKey(bin.cell[0], bin.cell[1], bin.cell[2], 7));
      if (box_.size() + bins_.size() <= cell) box_.push_back(-1);
      first = &box_[cell - bins_.size()];
    } else {
      const std::int32_t* const c = bin.cell;
      first = &box_[static_cast<std::size_t>(
          (c[0] - low_[0]) + span_[0] * ((c[1] - low_[1]) + span_[1] * (c[2] - low_[2])))];
    }
    bin.next = *first;
    *first = static_cast<std::int32_t>(b);
  }
}

std::int32_t Binner::firstIn(const std::int32_t* cell) const {
  if (!hashed_) {
    const int x = cell[0] - low_[0], y = cell[1] - low_[1], z = cell[2] - low_[2];
    return box_[static_cast<std::size_t>(x + span_[0] * (y + span_[1] * z))];
  }
  const std::uint64_t key = ccBinKey(cell[0], cell[1], cell[2], 7);
  const std::size_t mask = slots_ - 1;
  for (std::size_t slot = slotOf(key) & mask; table_[slot] >= 0; slot = (slot + 1) & mask)
    if (keys_[static_cast<std::size_t>(table_[slot])] == key)
      return box_[static_cast<std::size_t>(table_[slot]) - bins_.size()];
  return -1;
}

bool Binner::linked(std::size_t bin, std::size_t from, double weight, double close) const {
  const Vec3 here = sums_[bin].center(), there = sums_[from].center();
  return ccLinked(&bins_[bin].faces, &bins_[from].faces, bins_[bin].weight, weight, here.data(),
                  there.data(), close) != 0;
}

// Grows a patch from its heaviest bin over neighbouring bins that look the same way.
void Binner::grow(std::size_t seed, Sums& patch, std::int32_t number, double close) {
  patch = sums_[seed];
  bins_[seed].patch = number;
  queue_.assign(1, static_cast<std::uint32_t>(seed));
  CcFaces faces = bins_[seed].faces;
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const std::size_t from = queue_[next];
    for (int n = 0; n < 27; ++n) {
      const std::int32_t* const at = bins_[from].cell;
      const std::int32_t cell[3] = {at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1};
      for (std::int32_t i = firstIn(cell); i >= 0; i = bins_[static_cast<std::size_t>(i)].next) {
        const std::size_t b = static_cast<std::size_t>(i);
        if (bins_[b].patch >= 0) continue;
        if (!ccAlike(&bins_[b].faces, &faces, CC_AGREE) && !linked(b, from, weightOf(patch), close))
          continue;
        bins_[b].patch = number;
        patch.add(sums_[b]);
        faces = facesOf(patch);
        queue_.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
}

const std::vector<Sums>& Binner::patches(const HitColumns& hits, double cell, bool oneSided,
                                         const TaskRunner* shareOut) {
  patches_.clear();
  findBins(hits, cell);
  order(hits);
  const int shares = shareOut ? static_cast<int>(hits.size() / kShareHits) : 1;
  // A share's bins are those whose last hit is in its part of the hits.
  const auto binAt = [&](int share) {
    const auto hit = static_cast<std::uint32_t>(hits.size() * static_cast<std::size_t>(share) /
                                                static_cast<std::size_t>(shares));
    const auto found =
        std::lower_bound(bins_.begin(), bins_.end(), hit + 1,
                         [](const Bin& bin, std::uint32_t end) { return bin.end < end; });
    return static_cast<std::size_t>(found - bins_.begin());
  };
  const auto sumShare = [&](int i) { sum(hits, cell, oneSided, binAt(i), binAt(i + 1)); };
  if (shares > 1)
    (*shareOut)(shares, std::cref(sumShare));
  else
    sum(hits, cell, oneSided, 0, bins_.size());
  layOut();
  order_.resize(bins_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::uint32_t>(i);
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return bins_[a].weight != bins_[b].weight ? bins_[a].weight > bins_[b].weight : a < b;
  });
  for (const std::uint32_t seed : order_) {
    if (bins_[seed].patch >= 0) continue;
    patches_.emplace_back();
    grow(seed, patches_.back(), static_cast<std::int32_t>(patches_.size()) - 1, CC_CLOSE * cell);
  }
  return patches_;
}

}  // namespace cloudcontact
