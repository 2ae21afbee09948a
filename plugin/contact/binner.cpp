// Bins in a flat table, and the patches that grow from the heaviest of them.
#include "contact/binner.h"

#include "base/simd.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace cloudcontact {

namespace {

constexpr std::size_t kShareHits = 1024;  // of one task that sums
constexpr std::size_t kFewSlots = 1024;   // of the table by key, at first
constexpr double kMostBox = 4096;         // cells in a box that is addressed directly
constexpr std::int32_t kDirections = 6;
constexpr std::size_t kEmptyPlaces = 2048;  // of a direct table that may stay empty

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
    const CcBinOfHit bin = ccBinOf(at, own, other, c.facing[i], c.depth[i], sides[i], perCell);
    to.x[i] = bin.x;
    to.y[i] = bin.y;
    to.z[i] = bin.z;
    to.direction[i] = bin.direction;
    to.gate[i] = bin.gate;
  }
}

CcFaces facesOf(const CcSums& sums) {
  CcFaces faces;
  for (int s = 0; s < 2; ++s) {
    faces.normal[s] = ccVecAt(sums.normal[s]);
    faces.length[s] = ccLength64(faces.normal[s]);
  }
  return faces;
}

double weightOf(const CcSums& sums) {
  return sums.side[0].size + sums.side[1].size;
}

}  // namespace

void Binner::reserveLike(const Binner& other) {
  const auto fit = [](auto& to, const auto& from) { to.reserve(from.capacity()); };
  fit(cellX_, other.cellX_), fit(cellY_, other.cellY_), fit(cellZ_, other.cellZ_);
  fit(direction_, other.direction_), fit(gate_, other.gate_), fit(bin_, other.bin_);
  fit(bins_, other.bins_), fit(sums_, other.sums_), fit(keys_, other.keys_);
  fit(table_, other.table_), fit(box_, other.box_), fit(order_, other.order_);
  fit(heaviest_, other.heaviest_);
  fit(queue_, other.queue_), fit(ends_, other.ends_), fit(patches_, other.patches_);
  fit(runs_, other.runs_);
}

// Finds the box of the hits' cells, with a margin of one cell so that it contains all neighbors. A
// box that is too large is hashed.
CC_LANES void Binner::findBox(int count) {
  const std::vector<std::int32_t>* const cells[3] = {&cellX_, &cellY_, &cellZ_};
  double all = 1;
  for (int k = 0; k < 3; ++k) {
    const std::int32_t* const at = cells[k]->data();
    std::int32_t low = at[0], high = at[0];
    for (int i = 1; i < count; ++i) {
      low = at[i] < low ? at[i] : low;
      high = at[i] > high ? at[i] : high;
    }
    all *= static_cast<double>(high) - low + 3;
    low_[k] = low - 1;
    span_[k] = static_cast<std::int32_t>(std::min(static_cast<double>(high) - low + 3, 1e9));
  }
  hashed_ = all > kMostBox;
  cells_ = hashed_ ? 0 : static_cast<std::size_t>(all);
}

// Replaces each hit's direction by its index in a table of the box's cells times directions.
CC_LANES void Binner::findPlaces(int count) {
  const std::int32_t *const x = cellX_.data(), *const y = cellY_.data(), *const z = cellZ_.data();
  std::int32_t* const direction = direction_.data();
  const std::int32_t lx = low_[0], ly = low_[1], lz = low_[2], nx = span_[0], ny = span_[1];
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i)
    direction[i] += kDirections * ((x[i] - lx) + nx * ((y[i] - ly) + ny * (z[i] - lz)));
}

void Binner::findBins(const HitColumns& hits, double cell) {
  const std::size_t count = hits.size();
  bins_.clear();
  keys_.clear();
  bin_.resize(count);
  cells_ = 0;
  hashed_ = false;
  direct_ = false;
  if (count == 0) return;
  for (auto* v : {&cellX_, &cellY_, &cellZ_, &direction_})
    if (v->size() < count) v->resize(count);
  if (gate_.size() < count) gate_.resize(count);
  keysOf(hits, static_cast<float>(1 / cell),
         {cellX_.data(), cellY_.data(), cellZ_.data(), direction_.data(), gate_.data()});
  findBox(static_cast<int>(count));
  // Address the table directly unless most of it would stay empty.
  const std::size_t places = kDirections * cells_;
  if (!hashed_ && places <= kEmptyPlaces + 8 * count) {
    findPlaces(static_cast<int>(count));
    direct_ = true;
    slots_ = places;
    clearSlots();
    for (std::size_t i = 0; i < count; ++i) {
      std::int32_t& bin = table_[static_cast<std::size_t>(direction_[i])];
      if (bin < 0) bin = static_cast<std::int32_t>(bins_.size());
      addTo(static_cast<std::uint32_t>(bin), i);
    }
    return;
  }
  slots_ = kFewSlots;
  clearSlots();
  for (std::size_t i = 0; i < count; ++i)
    addTo(binOf(ccBinKey(cellX_[i], cellY_[i], cellZ_[i], direction_[i])), i);
}

// Adds a hit to a bin, which may be a new one after the last.
void Binner::addTo(std::uint32_t bin, std::size_t hit) {
  if (bin == bins_.size()) {
    Bin& made = bins_.emplace_back();
    made.cell[0] = cellX_[hit];
    made.cell[1] = cellY_[hit];
    made.cell[2] = cellZ_[hit];
  }
  bin_[hit] = bin;
  ++bins_[bin].end;
}

// The bin of a key; a new key gets the bin after the last.
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

// Orders the hits by their bins.
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
  if (sums_.size() < bins_.size()) sums_.resize(bins_.size());
  runs_.clear();
  begin = 0;
  for (std::size_t b = 0; b < bins_.size(); ++b) {
    Bin& bin = bins_[b];
    const std::uint32_t *const first = order_.data() + begin, *const last = order_.data() + bin.end;
    const std::uint32_t* const split = std::find_if(
        first, last, [&](std::uint32_t i) { return hits.side(i) != hits.side(*first); });
    bin.run = runs_.size();
    runs_.push_back({first, split, &sums_[b], hits.side(*first), true});
    if (split != last) runs_.push_back({split, last, &sums_[b], hits.side(*split), false});
    begin = bin.end;
  }
}

// Sums the hits of the bins from `first` to `last`.
void Binner::sum(const HitColumns& hits, double cell, bool oneSided, std::size_t first,
                 std::size_t last) {
  if (first == last) return;
  for (std::size_t b = first; b < last; ++b) {
    const std::int32_t* const at = bins_[b].cell;
    for (int i = 0; i < 3; ++i) sums_[b].origin[i] = (at[i] + 0.5) * cell;
  }
  const std::size_t begin = bins_[first].run,
                    end = last < bins_.size() ? bins_[last].run : runs_.size();
  const std::span<const HitRun> runs(runs_.data() + begin, end - begin);
  if (oneSided)
    for (const HitRun& run : runs) addHits(hits, gate_.data(), run, cell);
  else
    addRuns(hits, gate_.data(), runs, cell);
  if (hits.anyDeep())
    for (const HitRun& run : runs) addDeep(hits, run);
  for (std::size_t b = first; b < last; ++b) {
    bins_[b].weight = weightOf(sums_[b]);
    bins_[b].faces = facesOf(sums_[b]);
  }
}

// Chains the bins of each cell. Growth looks up 27 cells a bin, mostly empty ones.
void Binner::layOut() {
  box_.assign(cells_, -1);
  for (std::size_t b = 0; b < bins_.size(); ++b) {
    Bin& bin = bins_[b];
    std::int32_t* first = nullptr;
    if (hashed_) {
      const std::uint32_t cell = binOf(ccBinKey(bin.cell[0], bin.cell[1], bin.cell[2], 7));
      if (box_.size() + bins_.size() <= cell) box_.push_back(-1);
      first = &box_[cell - bins_.size()];
    } else {
      first = &box_[placeOf(bin.cell)];
    }
    bin.next = *first;
    *first = static_cast<std::int32_t>(b);
  }
}

std::size_t Binner::placeOf(const std::int32_t* cell) const {
  const int x = cell[0] - low_[0], y = cell[1] - low_[1], z = cell[2] - low_[2];
  return static_cast<std::size_t>(x + span_[0] * (y + span_[1] * z));
}

// The head of a cell's chain of free bins; null if the cell has no bins.
std::int32_t* Binner::chainOf(const std::int32_t* cell) {
  if (!hashed_) return &box_[placeOf(cell)];
  const std::uint64_t key = ccBinKey(cell[0], cell[1], cell[2], 7);
  const std::size_t mask = slots_ - 1;
  for (std::size_t slot = slotOf(key) & mask; table_[slot] >= 0; slot = (slot + 1) & mask)
    if (keys_[static_cast<std::size_t>(table_[slot])] == key)
      return &box_[static_cast<std::size_t>(table_[slot]) - bins_.size()];
  return nullptr;
}

const Binner::Bin* Binner::find(const CcBinOfHit& bin) const {
  if (direct_) {
    const std::int32_t cell[3] = {bin.x, bin.y, bin.z};
    for (int k = 0; k < 3; ++k)
      if (cell[k] < low_[k] || cell[k] >= low_[k] + span_[k]) return nullptr;
    const std::int32_t found =
        table_[kDirections * placeOf(cell) + static_cast<std::size_t>(bin.direction)];
    return found < 0 ? nullptr : &bins_[static_cast<std::size_t>(found)];
  }
  const std::uint64_t key = ccBinKey(bin.x, bin.y, bin.z, bin.direction);
  const std::size_t mask = slots_ - 1;
  for (std::size_t slot = slotOf(key) & mask; table_[slot] >= 0; slot = (slot + 1) & mask)
    if (keys_[static_cast<std::size_t>(table_[slot])] == key)
      return &bins_[static_cast<std::size_t>(table_[slot])];
  return nullptr;
}

std::size_t Binner::patchNear(const CcBinOfHit& bin, int side, const float* own) const {
  if (const Bin* const found = find(bin)) return static_cast<std::size_t>(found->patch);
  const CcVec normal = ccVec(own[0], own[1], own[2]);
  const Bin* best = &bins_.front();
  double least = std::numeric_limits<double>::infinity();
  for (const Bin& one : bins_) {
    const double x = one.cell[0] - bin.x, y = one.cell[1] - bin.y, z = one.cell[2] - bin.z;
    const double length = std::max(one.faces.length[side], 1e-300);
    const double apart =
        x * x + y * y + z * z - 2 * ccDot64(one.faces.normal[side], normal) / length;
    if (apart >= least) continue;
    best = &one;
    least = apart;
  }
  return static_cast<std::size_t>(best->patch);
}

bool Binner::linked(std::size_t bin, std::size_t from, double weight, double close) const {
  if (bins_[bin].weight < CC_LEAST_LINK * weight) return false;  // the first test of ccLinked()
  return ccLinked(&bins_[bin].faces, &bins_[from].faces, bins_[bin].weight, weight,
                  centerOf(sums_[bin]), centerOf(sums_[from]), close) != 0;
}

// Visits the chains of a cell and of its 26 neighbors, x fastest.
template <typename Visit>
void Binner::eachNeighbor(const std::int32_t* cell, const Visit& visit) {
  for (int z = cell[2] - 1; z <= cell[2] + 1; ++z)
    for (int y = cell[1] - 1; y <= cell[1] + 1; ++y) {
      const std::int32_t row[3] = {cell[0] - 1, y, z};
      std::int32_t* const chains = hashed_ ? nullptr : &box_[placeOf(row)];
      for (int x = 0; x < 3; ++x) {
        const std::int32_t at[3] = {row[0] + x, y, z};
        std::int32_t* const chain = chains ? chains + x : chainOf(at);
        if (chain) visit(chain);
      }
    }
}

// Region growing: from its heaviest bin, a patch takes in neighboring bins that face the same way.
// A bin that has a patch leaves its cell's chain.
void Binner::grow(std::size_t seed, CcSums& patch, std::int32_t number, double close) {
  std::int32_t* link = chainOf(bins_[seed].cell);
  while (*link != static_cast<std::int32_t>(seed))
    link = &bins_[static_cast<std::size_t>(*link)].next;
  patch = sums_[seed];
  CcFaces faces = bins_[seed].faces;
  const std::size_t first = queue_.size();
  const auto take = [&](std::int32_t* from) {
    Bin& bin = bins_[static_cast<std::size_t>(*from)];
    queue_.push_back(static_cast<std::uint32_t>(*from));
    *from = bin.next;
    bin.patch = number;
    --free_;
  };
  take(link);
  for (std::size_t next = first; next < queue_.size() && free_ > 0; ++next) {
    const std::size_t from = queue_[next];
    const auto visit = [&](std::int32_t* chain) {
      while (*chain >= 0) {
        const std::size_t b = static_cast<std::size_t>(*chain);
        if (ccAlike(&bins_[b].faces, &faces, CC_AGREE) || linked(b, from, weightOf(patch), close)) {
          take(chain);
          ccJoinSums(&patch, &sums_[b]);
          faces = facesOf(patch);
        } else {
          chain = &bins_[b].next;
        }
      }
    };
    eachNeighbor(bins_[from].cell, visit);
  }
  ends_.push_back(static_cast<std::uint32_t>(queue_.size()));
}

void Binner::openGates(const HitColumns& hits) {
  const float *const depth = hits.columns().depth, *const end = depth + hits.size();
  const bool overlap = std::any_of(depth, end, [](float d) { return d > 0; });
  std::fill_n(gate_.begin(), hits.size(), overlap ? 1.0f : 0.0f);
}

const std::vector<CcSums>& Binner::patches(const HitColumns& hits, double cell, bool oneSided,
                                           bool gated, const TaskRunner* runner) {
  patches_.clear();
  queue_.clear();
  ends_.clear();
  findBins(hits, cell);
  if (!gated) openGates(hits);
  order(hits);
  const int shares = runner ? static_cast<int>(hits.size() / kShareHits) : 1;
  // A task sums the bins whose last hit lies in its part of the hits.
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
    (*runner)(shares, std::cref(sumShare));
  else
    sum(hits, cell, oneSided, 0, bins_.size());
  layOut();
  heaviest_.resize(bins_.size());
  for (std::size_t i = 0; i < heaviest_.size(); ++i) heaviest_[i] = static_cast<std::uint32_t>(i);
  std::sort(heaviest_.begin(), heaviest_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return bins_[a].weight != bins_[b].weight ? bins_[a].weight > bins_[b].weight : a < b;
  });
  free_ = bins_.size();
  for (const std::uint32_t seed : heaviest_) {
    if (bins_[seed].patch >= 0) continue;
    patches_.emplace_back();
    grow(seed, patches_.back(), static_cast<std::int32_t>(patches_.size()) - 1, CC_CLOSE * cell);
  }
  return patches_;
}

}  // namespace cloudcontact
