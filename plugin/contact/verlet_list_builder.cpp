// Goes level by level as a search does, with each sample a skin deeper.
#include "contact/verlet_list_builder.h"

#include "base/simd.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

using namespace search;

namespace {

constexpr float kFacingNoise =
    0.01f;  // of the sine between two normals (the root of that in ccMayHit())

// What records within the skin say of a sample beside CC_WET and CC_NEARBY, which it may become:
// by its own record where the list is made, finer ones may touch, or may not; it may be divided
// into several hits.
constexpr int kNear = 8, kNotNear = 32, kSeveral = 16;
constexpr float kForever = 1e30f;
constexpr float kSureOfNear = 1e-3f;  // [own voxels] more than the rounding of what follows a depth

// Rounding of a place, a dozen operations, relative to the largest number in them.
constexpr float kRounding = 1e-6f;

float roundingOf(const Direction& dir, const FieldData& other) {
  float most = 0;
  for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(dir.toOther.shift[i]));
  const CcBricks bricks = other.records().bricks();
  return kRounding * (2 * most + 8.0f * static_cast<float>(bricks.nx + bricks.ny + bricks.nz));
}

}  // namespace

struct search::MayTouch {
  CcLimits limits;
  int level;
  float skin;      // [the other's voxels] including rounding
  float rounding;  // [m]
  float voxel;     // [m] the other's
  float turn;      // [rad]

  // Of the kinds above, what the record may say; the ages of the list up to which it says the same
  // of finer samples, and up to which the sample is no hit.
  struct Answer {
    int may;
    float same, dry;
  };

  // `facing`: cosine between the normals. `beside`: ccDepthBeside(); `around`: how far finer
  // samples lie beside [own voxels], which is by how much `beside` changes with a turn.
  Answer operator()(CcVoxel record, float depth, float facing, float width, float rise,
                    float beside, float around) const {
    const std::uint32_t planes = ccPlaneCount(record);
    const float lean = std::sqrt(std::max(1.0f - facing * facing, 0.0f)) + turn + kFacingNoise;
    const float sine =
        planes > 1 ? 1.0f : std::min(lean, 1.0f);  // any of the planes may give the depth
    const float moves = skin * voxel, half = limits.halfWidth * width;
    // A wet sample is a hit if it leans enough. Divided samples count regardless.
    const bool plainly = (level < kLevels - 1) & (planes > 1);
    const float reach = plainly ? half : half * sine, dry = -reach - depth;
    const float near = beside + ccBend(record, level) + rise;
    const float nears = moves * limits.perVoxel + turn * around;
    const float steady = std::abs(near) - kSureOfNear - rounding * limits.perVoxel;
    const int surface = (dry < moves ? CC_WET : 0) | (near + nears > 0.0f ? limits.nearby : 0) |
                        (near > 0.0f ? kNear : kNotNear) | (planes > 1 ? kSeveral : 0);
    const int outside = limits.nearOutside ? CC_NEARBY | kNear : kNotNear;
    const int plain = record.b == CC_DEEP_INSIDE    ? CC_WET | limits.nearby | kNear
                      : record.b == CC_NEAR_OUTSIDE ? outside
                                                    : kNotNear;
    const float never = record.b == CC_DEEP_INSIDE ? 0 : kForever;
    return {planes > 0 ? surface : plain, planes > 0 ? steady / nears : kForever,
            planes > 0 ? (dry - rounding) / moves : never};
  }
};

namespace {

CC_LANES void mayTouch(const Direction& dir, const MayTouch& test, const Lanes& lanes,
                       std::int32_t* may, float* same, float* dry) {
  const SampleColumns& samples = dir.samples.levels[dir.level].samples;
  const float* const nx = samples.nx.data();
  const float* const ny = samples.ny.data();
  const float* const nz = samples.nz.data();
  const float* const width = samples.width.data();
  const ClusterColumns* const clusters =
      dir.level > 0 ? &dir.samples.levels[dir.level].clusters : nullptr;
  const int count = lanes.count;
  const MayTouch own = test;
  float turn[9];
  for (int i = 0; i < 9; ++i) turn[i] = dir.turnToOther[i];
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const std::int32_t k = static_cast<std::int32_t>(lanes.sample[i]);
    const float n[3] = {nx[k], ny[k], nz[k]}, m[3] = {lanes.nx[i], lanes.ny[i], lanes.nz[i]};
    float there[3];
    ccTurn(turn, n, there);
    float rise = 0, around = 0;
    if (clusters) {
      const CcCluster e = (*clusters)[static_cast<std::size_t>(k)];
      rise = e.rise;
      around = std::sqrt(e.spread[0] + e.spread[1] + e.spread[2]);
    }
    const MayTouch::Answer says = own({lanes.a[i], lanes.b[i]}, lanes.depth[i], ccDot(there, m),
                                      width[k], rise, clusters ? lanes.beside[i] : 0, around);
    may[i] = says.may;
    same[i] = says.same;
    dry[i] = says.dry;
  }
}

// The most hits that a body's samples can be.
std::size_t mostHits(const SampleSet& from, int level, std::span<const std::uint32_t> samples,
                     std::span<const std::uint8_t> may) {
  const LargeVector<float>& width = from.levels[level].samples.width;
  std::size_t most = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if ((may[i] & CC_WET) == 0) continue;
    const bool divides = level < kLevels - 1 && (may[i] & kSeveral);  // the coarsest are not
    const int along = divides ? std::max(ccPartsAlong(width[samples[i]]), 1) : 1;
    most += static_cast<std::size_t>(along * along);
  }
  return most;
}

}  // namespace

// Collects the samples of the level that a search may look up.
void VerletListBuilder::gather(const Direction& dir, const FieldData& other, float skin,
                               Side& side) {
  if (dir.level == kLevels - 1) {
    const float ratio = dir.voxel / static_cast<float>(other.cloud().voxelSize());
    nearBricks(dir, other, skin / ratio, bricks_);
    work_.bricks += dir.samples.bricks.runs.size();
    side.runs.clear();
    for (const std::uint32_t brick : bricks_) side.runs.push_back(dir.samples.bricks.runs[brick]);
  }
  side.samples.clear();
  for (const SampleRun& run : side.runs)
    for (std::uint32_t i = 0; i < run.count; ++i) side.samples.push_back(run.first + i);
}

void VerletListBuilder::look(const Direction& dir, const FieldData& other, const Test& test,
                             Side& side) {
  const std::size_t all = side.samples.size();
  side.may.resize(all), side.same.resize(all), side.dry.resize(all);
  beside_.count = 0;
  for (std::size_t first = 0; first < all; first += kLanes) {
    lanes_.clear();
    for (std::size_t k = first; k < all && !lanes_.full(); ++k) lanes_.add({side.samples[k], 1});
    loadSamples(dir, true, lanes_);
    findRecords(dir, other, lanes_);
    measure(dir, other, test.voxel, dir.level > 0, lanes_);
    work_.listed += static_cast<std::size_t>(lanes_.count);
    work_.planes += std::exchange(lanes_.planes, 0);
    std::int32_t may[kLanes];
    mayTouch(dir, test, lanes_, may, side.same.data() + first, side.dry.data() + first);
    for (int i = 0; i < lanes_.count; ++i) {
      const std::size_t place = first + static_cast<std::size_t>(i);
      side.may[place] = static_cast<std::uint8_t>(may[i]);
      const float out =
          std::max({std::abs(lanes_.x[i]), std::abs(lanes_.y[i]), std::abs(lanes_.z[i])});
      if (out + test.skin < 0.5f) continue;
      side.may[place] |= kSeveral;
      lookBeside(dir, other, test, i, static_cast<std::uint32_t>(place), side);
    }
  }
  flushBeside(dir, other, test, side);
}

// Looks up the records of other voxels within the skin: of the next ones on the axes on which the
// skin reaches them. Beyond the grid a place is in no voxel.
void VerletListBuilder::lookBeside(const Direction& dir, const FieldData& other, const Test& test,
                                   int lane, std::uint32_t place, Side& side) {
  const V3 own(lanes_.own.x[lane], lanes_.own.y[lane], lanes_.own.z[lane]);
  const V3 x = applied(dir.toOther, own), r(lanes_.x[lane], lanes_.y[lane], lanes_.z[lane]);
  const FieldRecords& records = other.records();
  const CcBricks bricks = records.bricks();
  const bool beyond = ccPlaceOf(bricks, x.data()).brick == bricks.nx * bricks.ny * bricks.nz;
  const V3 low = V3::Constant(beyond ? -test.skin : 0);
  V3 high = V3::Constant(test.skin);
  for (int k = 0; k < 3 && !beyond; ++k)
    high[k] = std::abs(r[k]) + test.skin < 0.5f ? 0 : std::copysign(test.skin, r[k]);
  for (int corner = 0; corner < 8; ++corner) {
    V3 by;
    float far = 0;  // to where the record begins
    for (int k = 0; k < 3; ++k) {
      by[k] = corner >> k & 1 ? high[k] : low[k];
      if (!beyond && by[k] != 0) far = std::max(far, 0.5f - std::abs(r[k]));
    }
    const V3 there = x + by;
    const CcPlace p = ccPlaceOf(bricks, there.data());
    const std::int32_t record = records.firsts()[p.brick] + p.cell;
    if (record == lanes_.record[lane]) continue;
    const int at = beside_.count++;
    owner_[at] = place;
    begins_[at] = (far - test.rounding / test.voxel) / test.skin;
    beside_.sample[at] = lanes_.sample[lane];
    beside_.record[at] = record;
    beside_.a[at] = records.records()[record].a;
    beside_.b[at] = records.records()[record].b;
    beside_.x[at] = p.r[0] - by.x();
    beside_.y[at] = p.r[1] - by.y();
    beside_.z[at] = p.r[2] - by.z();
    beside_.own.rise[at] = dir.level > 0 ? lanes_.own.rise[lane] : 0;
    for (int s = 0; s < 6; ++s)
      beside_.own.spread[s][at] = dir.level > 0 ? lanes_.own.spread[s][lane] : 0;
    if (beside_.count == kLanes) flushBeside(dir, other, test, side);
  }
}

void VerletListBuilder::flushBeside(const Direction& dir, const FieldData& other, const Test& test,
                                    Side& side) {
  if (beside_.count == 0) return;
  measure(dir, other, test.voxel, dir.level > 0, beside_);
  work_.listed += static_cast<std::size_t>(beside_.count);
  work_.planes += std::exchange(beside_.planes, 0);
  std::int32_t may[kLanes];
  float same[kLanes], dry[kLanes];
  mayTouch(dir, test, beside_, may, same, dry);
  for (int i = 0; i < beside_.count; ++i) {
    const std::uint32_t place = owner_[i];
    const bool differs = (may[i] & kNear) ? side.may[place] & kNotNear : side.may[place] & kNear;
    side.same[place] = std::min(side.same[place], std::max(differs ? 0 : same[i], begins_[i]));
    side.dry[place] = std::min(side.dry[place], std::max(dry[i], begins_[i]));
    side.may[place] |= static_cast<std::uint8_t>(may[i] & ~(kNear | kNotNear));
  }
  beside_.count = 0;
}

namespace {

template <typename Numbers>
bool isFull(const Numbers& of) {
  return of.size() == of.capacity();
}

}  // namespace

// Keeps the cells of the side's samples from `begin` to `end`. Returns false if they do not fit.
bool VerletListBuilder::keepCells(const SampleLevel& from, int level, bool passed,
                                  std::size_t begin, std::size_t end, const Side& side,
                                  VerletList& list) {
  SampleLevel& to = list.set.levels[level];
  VerletList::Passed& cells = list.passed[level];
  const int kept = passed ? CC_NEARBY : CC_WET | CC_NEARBY;
  while (begin < end) {
    const std::uint32_t cell = from.cellOf[side.samples[begin]];
    std::size_t next = begin;
    int all = 0;
    bool sure = false;
    for (; next < end && from.cellOf[side.samples[next]] == cell; ++next) {
      all |= side.may[next];
      sure |= (side.may[next] & kNear) && side.same[next] > 1;
    }
    const std::size_t first = std::exchange(begin, next);
    if ((all & kept) == 0) continue;
    SampleRun asked{static_cast<std::uint32_t>(to.samples.size()), 0};
    for (std::size_t i = first; i < next; ++i) {
      if ((side.may[i] & kept) == 0 || (passed && sure)) continue;
      if (isFull(to.samples.x)) return false;
      to.samples.push_back(from.samples[side.samples[i]]);
      to.clusters.push_back(from.clusters[side.samples[i]]);
      to.cellOf.push_back(static_cast<std::uint32_t>(finer_.size()));
      cells.near.push_back((side.may[i] & kNear) != 0);
      cells.until.push_back(side.same[i]);
      ++asked.count;
    }
    if (isFull(cells.cells)) return false;
    if (passed) cells.cells.push_back(asked);
    finer_.push_back(all & CC_NEARBY ? from.finer[cell] : SampleRun{});
  }
  return true;
}

// Keeps the samples from `begin` to `end` that may be hits. Returns false if they do not fit.
bool VerletListBuilder::keepWet(const SampleColumns& from, std::size_t begin, std::size_t end,
                                const Side& side, SampleColumns& to, VerletList& list) {
  for (std::size_t i = begin; i < end; ++i) {
    if ((side.may[i] & CC_WET) == 0) continue;
    if (isFull(to.x)) return false;
    to.push_back(from[side.samples[i]]);
    list.dry.push_back(side.dry[i]);
  }
  return true;
}

// Keeps what the lists need of a level. Then the runs are those of the next finer level.
bool VerletListBuilder::keep(const SampleSet& from, int level, bool last, bool passed, Side& side,
                             VerletList& list) {
  const SampleLevel& all = from.levels[level];
  SampleColumns& to = list.set.levels[level].samples;
  const auto entries = [&] { return passed ? list.passed[level].cells.size() : to.size(); };
  finer_.clear();
  std::size_t begin = 0;
  for (const SampleRun& run : side.runs) {
    const std::size_t first = entries(), end = begin + run.count;
    if (!(last ? keepWet(all.samples, begin, end, side, to, list)
               : keepCells(all, level, passed, begin, end, side, list)))
      return false;
    begin = end;
    if (level == kLevels - 1) continue;
    LargeVector<SampleRun>& finer = list.set.levels[level + 1].finer;
    if (isFull(finer)) return false;
    finer.push_back(
        {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(entries() - first)});
  }
  side.runs.assign(finer_.begin(), finer_.end());
  return true;
}

bool VerletListBuilder::build(const FieldData* const* fields, const Limits& limits,
                              VerletList* lists, std::array<bool, kLevels>& passes) {
  for (int k = 0; k < 2; ++k) lists[k].clear();
  for (int level = kLevels - 1; level >= limits.level; --level) {
    std::size_t most = 0;
    for (int k = 0; k < 2; ++k) {
      const FieldData &own = *fields[k], &other = *fields[1 - k];
      const float voxel = static_cast<float>(own.cloud().voxelSize());
      const Direction dir{lists[k].way, own, own.samples(), level, kA, voxel};
      const float skin = lists[k].skin + roundingOf(dir, other);
      const float others = static_cast<float>(other.cloud().voxelSize());
      const float rounding = (skin - lists[k].skin) * others;
      const Test test{dir.limits(), level, skin, rounding, others, lists[k].turn};
      gather(dir, other, skin, sides_[k]);
      look(dir, other, test, sides_[k]);
      most += mostHits(own.samples(), level, sides_[k].samples, sides_[k].may);
    }
    const bool last = level == limits.level,
               passed = !last && most < neededOf(level, limits.enough);
    passes[static_cast<std::size_t>(level)] = passed;
    for (int k = 0; k < 2; ++k)
      if (!keep(fields[k]->samples(), level, last, passed, sides_[k], lists[k])) return false;
  }
  return true;
}

}  // namespace cloudcontact
