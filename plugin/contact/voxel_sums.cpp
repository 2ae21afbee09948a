// Voxels of the touched samples, side by side in lanes: looked up in the other body's field or in
// D, and added to their patches' sums.
#include "contact/voxel_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>

#include "base/simd.h"
#include "contact/field_lanes.h"
#include "contact/hit_search.h"
#include "field/base_vector_bricks.h"

namespace cloudcontact {

namespace {

using search::TouchedSample;
using search::V3;

constexpr float kFarAway = 1e9f;  // [voxels]

Pose gridIn(const Pose& body, const ContactBody& own) {
  return body.inverse() * own.pose * gridPose(own.field->cloud());
}

// The first sample of a level in the brick, or the end.
std::uint32_t firstOf(const SampleSet& set, std::size_t brick, int level) {
  if (brick == set.bricks.runs.size())
    return static_cast<std::uint32_t>(set.levels[level].samples.size());
  std::uint32_t sample = set.bricks.runs[brick].first;
  for (int l = kLevels - 1; l > level; --l)
    sample = set.levels[l].finer[set.levels[l].cellOf[sample]].first;
  return sample;
}

}  // namespace

void VoxelSums::begin(const ContactBody& own, const ContactBody& other, Side side,
                      const PairFrame& frame, const FoundHits& found) {
  own_ = &own, other_ = &other, found_ = &found;
  const FieldData& data = own.field->data();
  dir_ = std::make_unique<search::Direction>(
      search::Direction{wayOf(own, other, frame), data, data.samples(), found.level, side,
                        static_cast<float>(data.cloud().voxelSize())});
  level_ = &ownedVoxels(data).levels[found.level];
  vectors_ = own.paper ? ownedVectors(data, *own.paper->vectors) : nullptr;
  area_ = areaOf(other);
  if (!area_ && other.shape) {
    shape_ = {*other.shape, Pose{}};
    area_ = &shape_;
  }
  const PaperBody* const tool = other.paper ? other.paper : own.paper;
  whole_ = tool && tool->membership == Membership::Whole;
  parts_ = other.paper && !other.paper->parts.empty() ? &other.paper->parts : nullptr;
  ability_ = other.paper ? other.paper->ability : 1;
  hardness_.assign(1, 1.0);
  if (own.paper) hardnessOf(own.paper->vectors->tissues(), own.paper->hardness, hardness_);
  mixed_ = std::find(hardness_.begin(), hardness_.end(), 0.0) != hardness_.end();
  toFrame_ = gridIn(frame.pose, own);
  toOther_ = gridIn(other.pose, own);
  tissues_ = own.tissues && own.tissues->size() > 1;
  sums_.assign(found.binner.patches().size(), {});
  next_.assign(sums_.size(), 0);
  various_ = hardness_.size() > 1 || parts_;
  lanes_.clear();
  std::fill(std::begin(known_), std::end(known_), KnownBin{});
}

void VoxelSums::touchedByArea(std::vector<TouchedSample>& touched) const {
  touched.clear();
  const SampleSet& set = dir_->samples;
  const SampleColumns& samples = set.levels[found_->level].samples;
  const LargeVector<OwnedReach>& reach = level_->reach;
  const double h = own_->field->cloud().voxelSize();
  const bool distance = isDistance(area_->solid);
  const auto inOther = [&](float x, float y, float z) {
    return toOther_.toWorld(h * Vec3(x, y, z));
  };
  for (std::size_t b = 0; b < set.bricks.runs.size(); ++b) {
    const Vec3 middle = inOther(set.bricks.x[b], set.bricks.y[b], set.bricks.z[b]);
    const double away = h * double(set.bricks.radius[b] + search::kOwnedAside);
    if (distance && depthOf(*area_, middle) < -away) continue;
    const std::uint32_t end = firstOf(set, b + 1, found_->level);
    for (std::uint32_t k = firstOf(set, b, found_->level); k < end; ++k) {
      const SolidPoint at = pointOf(*area_, inOther(samples.x[k], samples.y[k], samples.z[k]));
      const auto depth = static_cast<float>(at.depth);
      V3 normal;
      ccTurnBack(dir_->turnToOther, at.normal.cast<float>().eval().data(), normal.data());
      const float facing = normal.dot(V3(samples.nx[k], samples.ny[k], samples.nz[k]));
      if (depth / dir_->voxel + reach[k].deeper(facing) > kLeast)
        touched.push_back({k, depth, at.normal.cast<float>()});
    }
  }
}

std::size_t VoxelSums::patchAt(const TouchedSample& t) {
  if (sums_.size() == 1) return 0;
  if (t.hit != TouchedSample::kNoHit) return found_->binner.patchOf(t.hit);
  const OwnedRun& run = level_->runs[t.sample];
  const V3 at = search::applied(dir_->toFrame, V3(run.at)),
           own = search::turned(dir_->frameFromOwn, V3(run.normal));
  const V3 other = t.other.isZero() ? V3(-own) : search::turned(dir_->frameFromOther, t.other);
  const CcHit hit = ccHitOf(at.data(), own.data(), other.data(), t.depth, 0);
  const CcBinOfHit bin = ccBinOf(hit.position, hit.own, hit.other, hit.facing, t.depth, dir_->side,
                                 static_cast<float>(1 / found_->cell));
  const std::uint64_t key = ccBinKey(bin.x, bin.y, bin.z, bin.direction);
  KnownBin& known = known_[key * 0x9E3779B97F4A7C15u >> 56];
  if (known.key != key) known = {key, found_->binner.patchNear(bin, dir_->side, hit.own)};
  return known.patch;
}

search::OwnedPlane VoxelSums::planeAt(const TouchedSample& touched, const OwnedRun& run) const {
  if (touched.other.isZero()) return {0, 0, 0, 0, -1};  // deep: its own surface tells nothing
  V3 n;
  ccTurnBack(dir_->turnToOther, touched.other.data(), n.data());
  const float here = touched.depth / dir_->voxel + n.dot(V3(run.at));
  return {n.x(), n.y(), n.z(), here, kLeast};
}

void VoxelSums::add(std::span<const TouchedSample> touched) {
  for (const TouchedSample& one : touched) {
    if (pending_ == kPending) lookAtPending();
    pendingSample_[pending_] = one;
    pendingPlane_[pending_++] = planeAt(one, level_->runs[one.sample]);
  }
}

// One stage after the other: the loops' steps do not wait for each other then.
void VoxelSums::lookAtPending() {
  constexpr std::uint32_t kBoxed = OwnedVoxels::kBoxed;
  boxes_.clear();
  for (int i = 0; i < pending_; ++i) {
    const OwnedRun& run = level_->runs[pendingSample_[i].sample];
    const std::uint32_t boxes = (run.size() + kBoxed - 1) / kBoxed;
    for (std::uint32_t b = 0; b < boxes; b += kBoxed) {
      const int some = static_cast<int>(std::min(kBoxed, boxes - b));
      std::uint32_t below = search::boxesBelow(pendingPlane_[i], level_->boxes, run.box + b, some);
      for (std::uint32_t first = run.first + kBoxed * b; below; below >>= 1, first += kBoxed)
        if (below & 1) boxes_.push_back({i, first, std::min(kBoxed, run.last - first), 0});
    }
  }
  for (Box& box : boxes_)
    box.below = search::voxelsBelow(pendingPlane_[box.pending], *level_, box.first,
                                    static_cast<int>(box.count));
  int last = -1;
  for (const Box& box : boxes_) {
    if (box.below == 0) continue;
    if (box.pending != last) patch_ = patchAt(pendingSample_[box.pending]);
    last = box.pending;
    take(box);
  }
  pending_ = 0;
}

// Takes the voxels of a box that are below its plane.
void VoxelSums::take(const Box& box) {
  if (lanes_.count + static_cast<int>(kAtOnce) > search::kLanes) flush();
  std::fill_n(patches_ + lanes_.count, kAtOnce, static_cast<std::uint32_t>(patch_));
  int count = lanes_.count;
#pragma GCC unroll 16
  for (std::uint32_t i = 0; i < kAtOnce; ++i) {
    voxel_[count] = box.first + i;
    count += static_cast<int>(box.below >> i & 1u);
  }
  lanes_.count = count;
}

// Reads the lanes' voxels.
CC_LANES void VoxelSums::loadVoxels() {
  const OwnedVoxel* const voxels = level_->voxels.data();
  OwnedVoxel read[search::kLanes];
  for (int i = 0; i < lanes_.count; ++i) read[i] = voxels[voxel_[i]];
  search::pad(read, lanes_.count);
  const int count = search::padded(lanes_.count);
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    lanes_.own.x[i] = read[i].x();
    lanes_.own.y[i] = read[i].y();
    lanes_.own.z[i] = read[i].z();
    coverage_[i] = read[i].coverage();
  }
}

// Depths of the lanes' voxels in the other body or in D.
void VoxelSums::lookUp() {
  const double h = own_->field->cloud().voxelSize();
  if (area_) {
    for (int i = 0; i < lanes_.count; ++i) {
      const Vec3 center(lanes_.own.x[i], lanes_.own.y[i], lanes_.own.z[i]);
      depth_[i] = static_cast<float>(depthOf(*area_, toOther_.toWorld(h * center)) / h);
    }
    return;
  }
  const FieldData& field = other_->field->data();
  findRecords(*dir_, field, lanes_);
  measure(*dir_, field, static_cast<float>(field.cloud().voxelSize()), false, lanes_);
  const float perVoxel = 1 / dir_->voxel;
  for (int i = 0; i < lanes_.count; ++i)
    depth_[i] = ccPlaneCount({lanes_.a[i], lanes_.b[i]}) > 0 ? lanes_.depth[i] * perVoxel
                : lanes_.b[i] == CC_DEEP_INSIDE              ? kFarAway
                                                             : -kFarAway;
}

void VoxelSums::flush() {
  if (lanes_.count == 0) return;
  lookups_ += static_cast<std::size_t>(lanes_.count);
  loadVoxels();
  lookUp();
  findShares();
  const int counted = search::listSet<std::int32_t>(counts_, 1, lanes_.count, nullptr, lanes_.wet);
  sortByPatch(counted);
  put(counted);
  if (various_ || tissues_) weigh(counted);
  lanes_.clear();
  sumUp();
}

CC_LANES void VoxelSums::findShares() {
  const bool whole = whole_;
  const int count = search::padded(lanes_.count);
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float part = ccMin(ccMax(depth_[i] + 0.5f, 0.0f), 1.0f) * coverage_[i];
    share_[i] = whole ? (depth_[i] >= 0 ? 1.0f : 0.0f) : part;
    counts_[i] = share_[i] > 0;
  }
}

void VoxelSums::addNear() {
  const Cloud& cloud = own_->field->cloud();
  const double h = cloud.voxelSize();
  for (std::size_t i = 0; i < found_->hits.size(); ++i) {
    if (found_->hits.side(i) != dir_->side) continue;
    const Hit hit = found_->hits[i];
    const double back = 0.5 * (h - double(hit.depth) + found_->gap);
    const Vec3 inside = toFrame_.toLocal((hit.position - float(back) * hit.own).cast<double>());
    const VoxelIndex v = (inside / h).array().floor().cast<int>();
    if (cloud.coverage(v.x(), v.y(), v.z()) == 0) continue;
    const double share = double(hit.area) / (h * h) * std::min(double(hit.depth) / h + 0.5, 1.0);
    addOne(found_->binner.patchOf(i), share, v);
  }
}

}  // namespace cloudcontact
