// Bins in a flat table, and the patches that grow from the heaviest of them.
#include "bins.h"

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

float gateOf(const Hit& hit) {
  return std::clamp(hit.facing / kFacing, 0.0f, 1.0f);
}

// The six axis directions, of the other body's normal less the own one's share.
std::int32_t directionOf(const Hit& hit, float gate) {
  // Seen from A to B whoever's sample it is, so that both bodies' samples meet in one bin.
  const Eigen::Vector3f v = (hit.other - gate * hit.own) * (hit.side == kA ? -1.0f : 1.0f);
  int axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (v[axis] < 0 ? 1 : 0);
}

// As std::floor, which is a call where no newer instructions than SSE2 are asked for.
std::int32_t floorOf(double x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole - (x < static_cast<double>(whole) ? 1 : 0);
}

double weightOf(const Sums& sums) {
  return sums.side[0].size + sums.side[1].size;
}

}  // namespace

void Sums::add(const Hit& hit, bool oneSided) {
  const double gate = gateOf(hit), pressed = hit.area * hit.depth1, faced = gate * pressed;
  const double square = gate * hit.area * hit.depth2, cube = gate * hit.area * hit.depth3;
  const Vec3 x = hit.position.cast<double>() - origin;
  const Vec3 n[2] = {(hit.side == kA ? hit.own : hit.other).cast<double>(),
                     (hit.side == kA ? hit.other : hit.own).cast<double>()};
  for (int s = 0; s < 2; ++s) {
    if (s != hit.side && !oneSided) continue;
    SideSums& sum = side[s];
    const Vec3 push = pressed * n[s];
    sum.push += push;
    sum.moment += x.cross(push);
    sum.size += pressed;
    if (gate < 1) sum.wall += (1 - gate) * push;
    sum.depth[0] += faced;
    sum.depth[1] += square;
    sum.depth[2] += cube;
  }
  deepest = std::max(deepest, static_cast<double>(hit.depth));
  if (hit.deep) deep += pressed;
  ++hits;
  const double w = gate * hit.area * hit.share;
  if (w == 0) return;
  const Vec3 wx = w * x;
  area += w;
  width += w * hit.area;
  facing += faced;
  first += wx;
  place += faced * x;
  middle += faced * hit.depth;
  apart += faced * (n[0] + n[1]);
  opening += faced * (n[0] + n[1]).dot(x);
  second.noalias() += x * wx.transpose();
  for (int s = 0; s < 2; ++s) {
    normal[s] += w * n[s];
    normalBy[s].noalias() += n[s] * wx.transpose();
  }
}

void Sums::add(const Sums& other) {
  const Vec3 shift = other.origin - origin;
  for (int s = 0; s < 2; ++s) {
    side[s].push += other.side[s].push;
    side[s].moment += other.side[s].moment + shift.cross(other.side[s].push);
    side[s].wall += other.side[s].wall;
    side[s].size += other.side[s].size;
    for (int k = 0; k < 3; ++k) side[s].depth[k] += other.side[s].depth[k];
    normal[s] += other.normal[s];
    normalBy[s] += other.normalBy[s] + other.normal[s] * shift.transpose();
  }
  second += other.second + other.first * shift.transpose() + shift * other.first.transpose() +
            other.area * shift * shift.transpose();
  first += other.first + other.area * shift;
  area += other.area;
  width += other.width;
  facing += other.facing;
  place += other.place + other.facing * shift;
  middle += other.middle;
  apart += other.apart;
  opening += other.opening + shift.dot(other.apart);
  deep += other.deep;
  deepest = std::max(deepest, other.deepest);
  hits += other.hits;
}

std::int32_t Binner::find(const std::int32_t* cell) const {
  const std::uint32_t hash = static_cast<std::uint32_t>(cell[0]) * 73856093u ^
                             static_cast<std::uint32_t>(cell[1]) * 19349663u ^
                             static_cast<std::uint32_t>(cell[2]) * 83492791u;
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = (hash ^ hash >> 15) & mask;
  while (table_[slot] >= 0) {
    if (std::equal(cell, cell + 3, bins_[static_cast<std::size_t>(table_[slot])].cell))
      return table_[slot];
    slot = (slot + 1) & mask;
  }
  return -1 - static_cast<std::int32_t>(slot);
}

std::size_t Binner::binOf(const Hit& hit, double cell) {
  std::int32_t at[3];
  for (int i = 0; i < 3; ++i) at[i] = floorOf(static_cast<double>(hit.position[i]) * perCell_);
  const std::int32_t direction = directionOf(hit, gateOf(hit));
  std::int32_t first = find(at);
  for (std::int32_t i = first; i >= 0; i = bins_[static_cast<std::size_t>(i)].next)
    if (bins_[static_cast<std::size_t>(i)].direction == direction)
      return static_cast<std::size_t>(i);
  const std::int32_t made = static_cast<std::int32_t>(bins_.size());
  Bin bin{{at[0], at[1], at[2]}, direction, -1, -1, {}};
  bin.sums.origin = Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5) * cell;
  if (first >= 0) {
    bin.next = bins_[static_cast<std::size_t>(first)].next;
    bins_[static_cast<std::size_t>(first)].next = made;
  } else {
    if ((++cells_) * 2 > table_.size()) {
      enlarge();
      first = find(at);
    }
    table_[static_cast<std::size_t>(-1 - first)] = made;
  }
  bins_.push_back(bin);
  return static_cast<std::size_t>(made);
}

void Binner::enlarge() {
  std::vector<std::int32_t> old(table_.size() * 2, -1);
  std::swap(old, table_);
  for (const std::int32_t first : old)
    if (first >= 0)
      table_[static_cast<std::size_t>(-1 - find(bins_[static_cast<std::size_t>(first)].cell))] =
          first;
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
  for (int i = 0; i < 3; ++i) all *= static_cast<double>(high[i]) - low_[i] + 1;
  if (all > kMostBox) return;
  for (int i = 0; i < 3; ++i) span_[i] = high[i] - low_[i] + 1;
  box_.assign(static_cast<std::size_t>(all), -1);
  for (const std::int32_t first : table_) {
    if (first < 0) continue;
    const std::int32_t* const c = bins_[static_cast<std::size_t>(first)].cell;
    const int at = (c[0] - low_[0]) + span_[0] * ((c[1] - low_[1]) + span_[1] * (c[2] - low_[2]));
    box_[static_cast<std::size_t>(at)] = first;
  }
}

std::int32_t Binner::firstIn(const std::int32_t* cell) const {
  if (box_.empty()) return find(cell);
  const int x = cell[0] - low_[0], y = cell[1] - low_[1], z = cell[2] - low_[2];
  if (x < 0 || y < 0 || z < 0 || x >= span_[0] || y >= span_[1] || z >= span_[2]) return -1;
  return box_[static_cast<std::size_t>(x + span_[0] * (y + span_[1] * z))];
}

bool Binner::alike(const Sums& a, const Sums& b, double agree) {
  double cosine[2];
  for (int s = 0; s < 2; ++s) {
    const double length = a.normal[s].norm() * b.normal[s].norm();
    cosine[s] = length > 0 ? a.normal[s].dot(b.normal[s]) / length : 1.0;
  }
  return std::max(cosine[0], cosine[1]) >= agree && std::min(cosine[0], cosine[1]) >= kDisagree;
}

// Where edges cross, each face of one body meets two of the other: four bins, of which the last
// shares no face with the first, but one with either neighbour. Only close by, or all of a thread's
// turn would hang together.
bool Binner::linked(const Bin& bin, const Bin& from, const Sums& patch, double close) const {
  if (weightOf(bin.sums) < kLeastLink * weightOf(patch) || !alike(bin.sums, from.sums, kLink))
    return false;
  return (bin.sums.center() - from.sums.center()).norm() < close;
}

// Grows a patch from its heaviest bin over neighbouring bins that look the same way.
void Binner::grow(std::size_t seed, Sums& patch, std::int32_t number, double close) {
  patch = bins_[seed].sums;
  bins_[seed].patch = number;
  queue_.assign(1, static_cast<std::uint32_t>(seed));
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    for (int n = 0; n < 27; ++n) {
      const Bin& from = bins_[queue_[next]];
      const std::int32_t cell[3] = {from.cell[0] + n % 3 - 1, from.cell[1] + n / 3 % 3 - 1,
                                    from.cell[2] + n / 9 - 1};
      for (std::int32_t i = firstIn(cell); i >= 0; i = bins_[static_cast<std::size_t>(i)].next) {
        Bin& bin = bins_[static_cast<std::size_t>(i)];
        if (bin.patch >= 0) continue;
        if (!alike(bin.sums, patch, kAgree) && !linked(bin, from, patch, close)) continue;
        bin.patch = number;
        patch.add(bin.sums);
        queue_.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
}

const std::vector<Sums>& Binner::patches(const HitColumns& hits, double cell, bool oneSided) {
  bins_.clear();
  patches_.clear();
  cells_ = 0;
  perCell_ = 1 / cell;
  if (table_.empty()) table_.resize(256);
  std::fill(table_.begin(), table_.end(), -1);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Hit hit = hits[i];
    bins_[binOf(hit, cell)].sums.add(hit, oneSided);
  }
  layOut();
  order_.resize(bins_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::uint32_t>(i);
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double wa = weightOf(bins_[a].sums), wb = weightOf(bins_[b].sums);
    return wa != wb ? wa > wb : a < b;
  });
  for (const std::uint32_t seed : order_) {
    if (bins_[seed].patch >= 0) continue;
    patches_.emplace_back();
    grow(seed, patches_.back(), static_cast<std::int32_t>(patches_.size()) - 1, kClose * cell);
  }
  return patches_;
}

}  // namespace cloudcontact
