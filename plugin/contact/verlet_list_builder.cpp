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
  int wanted;   // kinds that matter on this level
  float skin;   // [the other's voxels] including rounding
  float voxel;  // [m] the other's
  float turn;   // [rad]

  // `facing`: cosine between the normals; `around`: how far finer samples lie beside [voxels].
  int operator()(CcVoxel record, float depth, float facing, float width, float rise,
                 float around) const {
    const std::uint32_t planes = ccPlaneCount(record);
    const float lean = std::sqrt(std::max(1.0f - facing * facing, 0.0f)) + turn + kFacingNoise;
    const float sine =
        planes > 1 ? 1.0f : std::min(lean, 1.0f);  // any of the planes may give the depth
    const float deep = depth + skin * voxel, half = limits.halfWidth * width;
    // A wet sample is a hit if it leans enough. Divided samples count regardless.
    const bool plainly = (level < kLevels - 1) & (planes > 1);
    const float reach = plainly ? half : half * sine;
    const float beyond = -deep * limits.perVoxel - CC_MOST_BEND - rise;
    const int surface =
        (deep > -reach ? CC_WET : 0) | (beyond <= around * sine ? limits.nearby : 0);
    const int plain = record.b == CC_DEEP_INSIDE    ? CC_WET | limits.nearby
                      : record.b == CC_NEAR_OUTSIDE ? limits.nearOutside
                                                    : 0;
    return (planes > 0 ? surface : plain) & wanted;
  }
};

namespace {

CC_LANES void mayTouch(const Direction& dir, const MayTouch& test, const Lanes& lanes,
                       std::int32_t* may) {
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
    may[i] = own({lanes.a[i], lanes.b[i]}, lanes.depth[i], ccDot(there, m), width[k], rise, around);
  }
}

}  // namespace

// Collects the samples of the level that a search may look up.
void VerletListBuilder::gather(const Direction& dir, const FieldData& other, float skin) {
  samples_.clear();
  const auto take = [&](SampleRun run) {
    for (std::uint32_t i = 0; i < run.count; ++i) samples_.push_back(run.first + i);
  };
  if (dir.level == kLevels - 1) {
    const float ratio = dir.voxel / static_cast<float>(other.cloud().voxelSize());
    nearBricks(dir, other, skin / ratio, bricks_);
    work_.bricks += dir.samples.bricks.runs.size();
    for (const std::uint32_t brick : bricks_) take(dir.samples.bricks.runs[brick]);
    return;
  }
  const SampleLevel& coarser = dir.samples.levels[dir.level + 1];
  std::uint32_t last = ~0u;
  for (const std::uint32_t sample : near_) {
    const std::uint32_t cell = coarser.cellOf[sample];
    if (cell != last) take(coarser.finer[cell]);
    last = cell;
  }
}

void VerletListBuilder::look(const Direction& dir, const FieldData& other, const Test& test) {
  may_.assign(samples_.size(), 0);
  beside_.count = 0;
  for (std::size_t first = 0; first < samples_.size(); first += kLanes) {
    lanes_.clear();
    for (std::size_t k = first; k < samples_.size() && !lanes_.full(); ++k)
      lanes_.add({samples_[k], 1});
    loadSamples(dir, lanes_);
    findRecords(dir, other, lanes_);
    measure(dir, other, test.voxel, false, lanes_);
    work_.listed += static_cast<std::size_t>(lanes_.count);
    work_.planes += std::exchange(lanes_.planes, 0);
    std::int32_t may[kLanes];
    mayTouch(dir, test, lanes_, may);
    for (int i = 0; i < lanes_.count; ++i) {
      may_[first + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(may[i]);
      const float out =
          std::max({std::abs(lanes_.x[i]), std::abs(lanes_.y[i]), std::abs(lanes_.z[i])});
      if (out + test.skin >= 0.5f && may[i] != test.wanted)
        lookBeside(dir, other, test, i,
                   static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(i));
    }
  }
  flushBeside(dir, other, test);
}

// Looks up the records of other voxels within the skin.
void VerletListBuilder::lookBeside(const Direction& dir, const FieldData& other, const Test& test,
                                   int lane, std::uint32_t place) {
  const SampleColumns& samples = dir.samples.levels[dir.level].samples;
  const std::uint32_t k = lanes_.sample[lane];
  const V3 x = applied(dir.toOther, V3(samples.x[k], samples.y[k], samples.z[k]));
  const FieldRecords& records = other.records();
  for (int corner = 0; corner < 8; ++corner) {
    const V3 aside(corner & 1 ? test.skin : -test.skin, corner & 2 ? test.skin : -test.skin,
                   corner & 4 ? test.skin : -test.skin);
    const V3 there = x + aside;
    const CcPlace p = ccPlaceOf(records.bricks(), there.data());
    const std::int32_t record = records.firsts()[p.brick] + p.cell;
    if (record == lanes_.record[lane]) continue;
    const int at = beside_.count++;
    owner_[at] = place;
    beside_.sample[at] = k;
    beside_.record[at] = record;
    beside_.a[at] = records.records()[record].a;
    beside_.b[at] = records.records()[record].b;
    beside_.x[at] = p.r[0] - aside.x();
    beside_.y[at] = p.r[1] - aside.y();
    beside_.z[at] = p.r[2] - aside.z();
    if (beside_.count == kLanes) flushBeside(dir, other, test);
  }
}

void VerletListBuilder::flushBeside(const Direction& dir, const FieldData& other,
                                    const Test& test) {
  if (beside_.count == 0) return;
  measure(dir, other, test.voxel, false, beside_);
  work_.listed += static_cast<std::size_t>(beside_.count);
  work_.planes += std::exchange(beside_.planes, 0);
  std::int32_t may[kLanes];
  mayTouch(dir, test, beside_, may);
  for (int i = 0; i < beside_.count; ++i) may_[owner_[i]] |= static_cast<std::uint8_t>(may[i]);
  beside_.count = 0;
}

bool VerletListBuilder::keep(int wanted, VerletList& list) {
  near_.clear();
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (may_[i] & CC_NEARBY) near_.push_back(samples_[i]);
    if ((may_[i] & wanted) == 0) continue;
    if (list.samples.size() == list.samples.capacity()) return false;
    list.samples.push_back(samples_[i]);
  }
  return true;
}

bool VerletListBuilder::build(const FieldData& own, const FieldData& other, const Limits& limits,
                              VerletList& list) {
  const float voxel = static_cast<float>(own.cloud().voxelSize());
  Direction dir{list.way, own, own.samples(), kLevels - 1, kA, voxel};
  const float skin = list.skin + roundingOf(dir, other);
  list.samples.clear();
  for (;; --dir.level) {
    list.begin[static_cast<std::size_t>(dir.level)] =
        static_cast<std::uint32_t>(list.samples.size());
    const int wanted = dir.level == limits.level ? CC_WET : CC_WET | CC_NEARBY;
    const Test test{
        dir.limits(), dir.level, wanted, skin, static_cast<float>(other.cloud().voxelSize()),
        limits.turn};
    gather(dir, other, skin);
    look(dir, other, test);
    if (!keep(wanted, list)) return false;
    if (dir.level == limits.level) break;
  }
  for (int level = 0; level < limits.level; ++level)
    list.begin[static_cast<std::size_t>(level)] = static_cast<std::uint32_t>(list.samples.size());
  return true;
}

}  // namespace cloudcontact
