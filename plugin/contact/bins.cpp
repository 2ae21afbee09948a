// Bins in a flat table, and the patches that grow from the heaviest of them.
#include "bins.h"

#include "simd.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// A sample faces the other body fully where the cosine between the normals exceeds this; at a wall
// that runs along the other's face it is zero within the fits' noise (0.02).
constexpr float kFacing = 0.2f;
// Bins belong together where one body's mean normals agree this well (22 deg) ...
constexpr double kAgree = 0.93;
// ... and the other's do not disagree.
constexpr double kDisagree = -0.2;
// Bins are close where their centres are nearer than this share of a cell; a bin that only links
// must weigh this share of its patch.
constexpr double kClose = 0.5, kLeastLink = 0.05, kLink = 0.7;
constexpr double kMostBox = 4096;  // cells in a box that is looked up directly

// Cells wrap around after as many as no grid holds; so do keys.
constexpr int kKeyBits = 14;

std::uint64_t keyOf(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t direction) {
  constexpr std::uint64_t kMask = (1u << kKeyBits) - 1;
  return (static_cast<std::uint64_t>(x) & kMask) |
         (static_cast<std::uint64_t>(y) & kMask) << kKeyBits |
         (static_cast<std::uint64_t>(z) & kMask) << 2 * kKeyBits |
         static_cast<std::uint64_t>(direction) << 3 * kKeyBits;
}

std::size_t slotOf(std::uint64_t key) {
  return static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> 40);
}

struct HitKeys {
  std::int32_t *x, *y, *z, *direction;
  float* gate;
};

// Cell and direction of every hit. The direction is one of the six of the axes, of the other body's
// normal less the own one's share, seen from A to B whoever's sample it is, so that both bodies'
// samples meet in one bin.
CC_LANES void keysOf(const HitColumns& hits, float perCell, const HitKeys& keys) {
  const HitColumns::Columns<const float> c = hits.columns();
  const std::int8_t* const sides = hits.sides();
  const HitKeys to = keys;
  const int count = static_cast<int>(hits.size());
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float u = c.x[i] * perCell, v = c.y[i] * perCell, w = c.z[i] * perCell;
    const std::int32_t x = static_cast<std::int32_t>(u), y = static_cast<std::int32_t>(v),
                       z = static_cast<std::int32_t>(w);
    to.x[i] = x - (u < static_cast<float>(x) ? 1 : 0);
    to.y[i] = y - (v < static_cast<float>(y) ? 1 : 0);
    to.z[i] = z - (w < static_cast<float>(z) ? 1 : 0);
    const float gate = ccMin(ccMax(c.facing[i] * (1.0f / kFacing), 0.0f), 1.0f);
    to.gate[i] = gate;
    const float sign = sides[i] == kA ? -1.0f : 1.0f;
    const float nx = sign * (c.otherX[i] - gate * c.ownX[i]),
                ny = sign * (c.otherY[i] - gate * c.ownY[i]),
                nz = sign * (c.otherZ[i] - gate * c.ownZ[i]);
    const float ax = ccAbs(nx), ay = ccAbs(ny), az = ccAbs(nz);
    const std::int32_t yz = ay >= az ? 2 + (ny < 0.0f) : 4 + (nz < 0.0f);
    const std::int32_t xs = 0 + (nx < 0.0f);
    to.direction[i] = (ax >= ay) & (ax >= az) ? xs : yz;
  }
}

double weightOf(const Sums& sums) {
  return sums.side[0].size + sums.side[1].size;
}

}  // namespace

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
  if (table_.empty()) table_.resize(1024);
  std::fill(table_.begin(), table_.end(), -1);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t bin = binOf(keyOf(cellX_[i], cellY_[i], cellZ_[i], direction_[i]));
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
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = slotOf(key) & mask;
  for (; table_[slot] >= 0; slot = (slot + 1) & mask)
    if (keys_[static_cast<std::size_t>(table_[slot])] == key)
      return static_cast<std::uint32_t>(table_[slot]);
  const std::uint32_t made = static_cast<std::uint32_t>(keys_.size());
  table_[slot] = static_cast<std::int32_t>(made);
  keys_.push_back(key);
  if (keys_.size() * 2 > table_.size()) enlarge();
  return made;
}

void Binner::enlarge() {
  table_.assign(table_.size() * 4, -1);
  const std::size_t mask = table_.size() - 1;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    std::size_t slot = slotOf(keys_[i]) & mask;
    while (table_[slot] >= 0) slot = (slot + 1) & mask;
    table_[slot] = static_cast<std::int32_t>(i);
  }
}

// Hits in the order of their bins, each bin's summed at one go.
void Binner::sum(const HitColumns& hits, double cell, bool oneSided) {
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
  begin = 0;
  for (std::size_t b = 0; b < bins_.size(); ++b) {
    Bin& bin = bins_[b];
    Sums& sums = sums_[b];
    sums.origin = Vec3(bin.cell[0] + 0.5, bin.cell[1] + 0.5, bin.cell[2] + 0.5) * cell;
    addHits(hits, gate_.data(), order_.data() + begin, order_.data() + bin.end, oneSided, cell,
            sums);
    begin = bin.end;
    bin.weight = weightOf(sums);
    for (int s = 0; s < 2; ++s) bin.length[s] = sums.normal[s].norm();
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
      const std::uint32_t cell = binOf(keyOf(bin.cell[0], bin.cell[1], bin.cell[2], 7));
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
  const std::uint64_t key = keyOf(cell[0], cell[1], cell[2], 7);
  const std::size_t mask = table_.size() - 1;
  for (std::size_t slot = slotOf(key) & mask; table_[slot] >= 0; slot = (slot + 1) & mask)
    if (keys_[static_cast<std::size_t>(table_[slot])] == key)
      return box_[static_cast<std::size_t>(table_[slot]) - bins_.size()];
  return -1;
}

bool Binner::alike(const Bin& a, const Sums& sumsA, const Sums& b, const double* lengthB,
                   double agree) const {
  double cosine[2];
  for (int s = 0; s < 2; ++s) {
    const double length = a.length[s] * lengthB[s];
    cosine[s] = length > 0 ? sumsA.normal[s].dot(b.normal[s]) / length : 1.0;
  }
  return std::max(cosine[0], cosine[1]) >= agree && std::min(cosine[0], cosine[1]) >= kDisagree;
}

// Where edges cross, each face of one body meets two of the other: four bins, of which the last
// shares no face with the first, but one with either neighbour. Only close by, or all of a thread's
// turn would hang together.
bool Binner::linked(std::size_t bin, std::size_t from, double weight, double close) const {
  if (bins_[bin].weight < kLeastLink * weight ||
      !alike(bins_[bin], sums_[bin], sums_[from], bins_[from].length, kLink))
    return false;
  return (sums_[bin].center() - sums_[from].center()).norm() < close;
}

// Grows a patch from its heaviest bin over neighbouring bins that look the same way.
void Binner::grow(std::size_t seed, Sums& patch, std::int32_t number, double close) {
  patch = sums_[seed];
  bins_[seed].patch = number;
  queue_.assign(1, static_cast<std::uint32_t>(seed));
  double length[2] = {bins_[seed].length[0], bins_[seed].length[1]};
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const std::size_t from = queue_[next];
    for (int n = 0; n < 27; ++n) {
      const std::int32_t* const at = bins_[from].cell;
      const std::int32_t cell[3] = {at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1};
      for (std::int32_t i = firstIn(cell); i >= 0; i = bins_[static_cast<std::size_t>(i)].next) {
        const std::size_t b = static_cast<std::size_t>(i);
        if (bins_[b].patch >= 0) continue;
        if (!alike(bins_[b], sums_[b], patch, length, kAgree) &&
            !linked(b, from, weightOf(patch), close))
          continue;
        bins_[b].patch = number;
        patch.add(sums_[b]);
        for (int s = 0; s < 2; ++s) length[s] = patch.normal[s].norm();
        queue_.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
}

const std::vector<Sums>& Binner::patches(const HitColumns& hits, double cell, bool oneSided) {
  patches_.clear();
  findBins(hits, cell);
  sum(hits, cell, oneSided);
  layOut();
  order_.resize(bins_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::uint32_t>(i);
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return bins_[a].weight != bins_[b].weight ? bins_[a].weight > bins_[b].weight : a < b;
  });
  for (const std::uint32_t seed : order_) {
    if (bins_[seed].patch >= 0) continue;
    patches_.emplace_back();
    grow(seed, patches_.back(), static_cast<std::int32_t>(patches_.size()) - 1, kClose * cell);
  }
  return patches_;
}

}  // namespace cloudcontact
