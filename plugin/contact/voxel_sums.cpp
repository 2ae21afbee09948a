// Voxels of the touched samples, side by side in lanes: looked up in the other body's field or in
// D, and added to their patches' sums.
#include "contact/voxel_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "base/simd.h"
#include "contact/field_lanes.h"
#include "contact/hit_search.h"
#include "field/base_vector_bricks.h"

namespace cloudcontact {

namespace {

using search::TouchedSample;
using search::V3;

constexpr double kFarAway = std::numeric_limits<double>::infinity();
// [voxels] Some of a voxel is in the other body where its center is less than half a voxel outside.
// What the other's plane at the sample, continued, tells of it may be wrong by this.
constexpr float kInVoxel = 0.5f, kSure = 0.15f;
// Voxels far below a sample lie beside its normal by at most this share of their depth.
constexpr float kFans = 0.5f;
constexpr float kSteep = 0.1f;  // the other's plane ends no run that it meets less steeply
constexpr std::uint32_t kAtOnce = OwnedVoxels::kBeyond;

Vec3 vec(const double* v) {
  return {v[0], v[1], v[2]};
}

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

// A plane: x is here - n.x below it.
struct Plane {
  float nx, ny, nz, here;
};

// Lists those of the first `count` of kAtOnce voxels that are more than `least` below the plane;
// returns how many.
CC_LANES int listBelow(const Plane& plane, float least, const float* x, const float* y,
                       const float* z, int count, std::int32_t* list) {
  const Plane p = plane;
  std::int32_t is[kAtOnce];
  CC_INDEPENDENT
  for (std::uint32_t i = 0; i < kAtOnce; ++i)
    is[i] = p.here - (p.nx * x[i] + p.ny * y[i] + p.nz * z[i]) > least;
  int found = 0;
  for (int i = 0; i < count; ++i) {
    list[found] = i;
    found += is[i];
  }
  return found;
}

}  // namespace

void VoxelSums::begin(const ContactBody& own, const ContactBody& other, Side side,
                      const PairFrame& frame, const FoundHits& found) {
  own_ = &own, other_ = &other, found_ = &found;
  const FieldData& data = own.field->data();
  dir_ = std::make_unique<search::Direction>(
      search::Direction{wayOf(own, other, frame), data, data.samples(), found.level, side,
                        static_cast<float>(data.cloud().voxelSize())});
  owned_ = &ownedVoxels(data);
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
  sums_.assign(found.binner.patches().size(), {});
  lanes_.clear();
  columns_.count = 0;
  std::fill(std::begin(known_), std::end(known_), KnownBin{});
}

void VoxelSums::touchedByArea(std::vector<TouchedSample>& touched) const {
  touched.clear();
  const SampleSet& set = dir_->samples;
  const SampleColumns& samples = set.levels[found_->level].samples;
  const std::vector<OwnedReach>& reach = owned_->levels[found_->level].reach;
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
      if (depth / dir_->voxel + reach[k].deeper(facing) > -kInVoxel - kSure)
        touched.push_back({k, depth, at.normal.cast<float>()});
    }
  }
}

std::size_t VoxelSums::patchAt(const SurfaceSample& s, const TouchedSample& t) {
  if (sums_.size() == 1) return 0;
  const Hit hit = search::hitOf(*dir_, s, t.depth, t.other, t.other.isZero());
  const CcBinOfHit bin = ccBinOf(hit.position.data(), hit.own.data(), hit.other.data(), hit.facing,
                                 hit.depth, dir_->side, static_cast<float>(1 / found_->cell));
  const std::uint64_t key = ccBinKey(bin.x, bin.y, bin.z, bin.direction);
  KnownBin& known = known_[key * 0x9E3779B97F4A7C15u >> 58];
  if (known.key != key) known = {key, found_->binner.patchNear(bin, dir_->side, hit.own.data())};
  return known.patch;
}

VoxelSums::Run VoxelSums::runOf(const TouchedSample& touched, const SurfaceSample& s) const {
  const OwnedVoxels::Level& level = owned_->levels[dir_->level];
  const V3 at(s.position[0], s.position[1], s.position[2]);
  const V3 normal(s.normal[0], s.normal[1], s.normal[2]);
  Run run{
      level.firsts[touched.sample],          level.firsts[touched.sample + 1], V3::Zero(), 0, -1,
      std::numeric_limits<float>::infinity()};
  if (touched.other.isZero()) return run;  // deep: the body's own surface tells nothing
  ccTurnBack(dir_->turnToOther, touched.other.data(), run.other.data());
  const float depth = touched.depth / dir_->voxel;
  run.here = depth + run.other.dot(at);
  run.least = -(kInVoxel + kSure);
  const float facing = -run.other.dot(normal);
  const float slope = std::sqrt(std::max(1 - facing * facing, 0.0f));
  const float steep = facing - kFans * slope;
  if (steep > kSteep)
    run.end = (depth + level.reach[touched.sample].aside * slope - run.least) / steep;
  return run;
}

void VoxelSums::add(const TouchedSample& touched) {
  const SurfaceSample s = dir_->samples.levels[dir_->level].samples[touched.sample];
  const Run run = runOf(touched, s);
  const Plane plane{run.other.x(), run.other.y(), run.other.z(), run.here};
  const std::vector<std::uint32_t>& order = owned_->levels[dir_->level].order;
  const V3 at(s.position[0], s.position[1], s.position[2]),
      n(s.normal[0], s.normal[1], s.normal[2]);
  float x[kAtOnce] = {}, y[kAtOnce] = {}, z[kAtOnce] = {};
  std::int32_t list[kAtOnce];
  bool known = false;
  for (std::uint32_t first = run.first; first < run.last; first += kAtOnce) {
    const int some = static_cast<int>(std::min(kAtOnce, run.last - first));
    const float *px = &owned_->x[first], *py = &owned_->y[first], *pz = &owned_->z[first];
    if (!order.empty()) {
      for (int i = 0; i < some; ++i) {
        const std::uint32_t e = order[first + static_cast<std::uint32_t>(i)];
        x[i] = owned_->x[e], y[i] = owned_->y[e], z[i] = owned_->z[e];
      }
      px = x, py = y, pz = z;
    }
    const int found = listBelow(plane, run.least, px, py, pz, some, list);
    if (found > 0 && !known) patch_ = patchAt(s, touched);
    known = known || found > 0;
    for (int i = 0; i < found; ++i) {
      const std::uint32_t e = first + static_cast<std::uint32_t>(list[i]);
      take(order.empty() ? e : order[e]);
    }
    const int deepest = some - 1;
    if (n.dot(at - V3(px[deepest], py[deepest], pz[deepest])) > run.end) return;
  }
}

void VoxelSums::take(std::uint32_t voxel) {
  const int lane = lanes_.count++;
  voxel_[lane] = voxel;
  patches_[lane] = static_cast<std::uint32_t>(patch_);
  if (lanes_.full()) flush();
}

// Depths of the lanes' voxels in the other body or in D.
void VoxelSums::lookUp() {
  if (area_) {
    const double h = own_->field->cloud().voxelSize();
    for (int i = 0; i < lanes_.count; ++i)
      depth_[i] = depthOf(
          *area_, toOther_.toWorld(h * Vec3(lanes_.own.x[i], lanes_.own.y[i], lanes_.own.z[i])));
    return;
  }
  const FieldData& field = other_->field->data();
  for (float* const column : {lanes_.own.x, lanes_.own.y, lanes_.own.z})
    search::pad(column, lanes_.count);
  findRecords(*dir_, field, lanes_);
  measure(*dir_, field, static_cast<float>(field.cloud().voxelSize()), false, lanes_);
  for (int i = 0; i < lanes_.count; ++i)
    depth_[i] = ccPlaneCount({lanes_.a[i], lanes_.b[i]}) > 0 ? double(lanes_.depth[i])
                : lanes_.b[i] == CC_DEEP_INSIDE              ? kFarAway
                                                             : -kFarAway;
}

void VoxelSums::flush() {
  if (lanes_.count == 0) return;
  lookups_ += static_cast<std::size_t>(lanes_.count);
  for (int i = 0; i < lanes_.count; ++i) {
    const std::uint32_t v = voxel_[i];
    lanes_.own.x[i] = owned_->x[v], lanes_.own.y[i] = owned_->y[v], lanes_.own.z[i] = owned_->z[v];
    coverage_[i] = owned_->coverage[v];
  }
  lookUp();
  findShares();
  const int counted = search::listSet<std::int32_t>(counts_, 1, lanes_.count, nullptr, lanes_.wet);
  for (int k = 0; k < counted; ++k) {
    const int i = lanes_.wet[k];
    const std::uint32_t v = voxel_[i];
    double f[3] = {0, 0, 0};
    if (vectors_) f[0] = vectors_->x[v], f[1] = vectors_->y[v], f[2] = vectors_->z[v];
    put(share_[i], patches_[i], {lanes_.own.x[i], lanes_.own.y[i], lanes_.own.z[i]},
        owned_->material[v], f);
  }
  lanes_.clear();
  sumUp();
}

CC_LANES void VoxelSums::findShares() {
  const double perVoxel = 1 / double(dir_->voxel);
  const bool whole = whole_;
  const int count = lanes_.count;
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const double depth = depth_[i] * perVoxel;
    const double part = std::min(std::max(depth + 0.5, 0.0), 1.0) * coverage_[i] / 255;
    share_[i] = whole ? (depth >= 0 ? 1.0 : 0.0) : part;
    counts_[i] = share_[i] > 0;
  }
}

// Puts a voxel into the columns. `f`: its base vector.
void VoxelSums::put(double share, std::size_t patch, const Vec3& center, std::uint8_t material,
                    const double* f) {
  Columns& c = columns_;
  const int i = c.count++;
  c.share[i] = share;
  c.patch[i] = static_cast<std::uint32_t>(patch);
  const TissueTable* const tissues = own_->tissues;
  const Tissue* const tissue = tissues ? &(*tissues)[tissues->size() > 1 ? material : 0] : nullptr;
  c.stiffness[i] = tissue ? tissue->stiffness : 0;
  c.damping[i] = tissue ? tissue->damping : 0;
  c.x[i] = center.x(), c.y[i] = center.y(), c.z[i] = center.z();
  c.fx[i] = f[0], c.fy[i] = f[1], c.fz[i] = f[2];
  c.length[i] = std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  double ability = ability_;
  if (parts_)
    ability =
        abilityAt(ability_, *parts_, toOther_.toWorld(own_->field->cloud().voxelSize() * center));
  const double hardness = hardness_.size() > 1 ? hardness_[material] : hardness_[0];
  c.weight[i] = ccWeightOf(share, hardness, ability);
}

// Adds the columns to their patches' sums.
void VoxelSums::sumUp() {
  const Columns& c = columns_;
  for (int first = 0, last = 0; first < c.count; first = last) {
    while (last < c.count && c.patch[last] == c.patch[first]) ++last;
    Sum& sum = sums_[c.patch[first]];
    addTo(sum.hard, c, c.weight, first, last);
    if (mixed_) addTo(sum.plain, c, c.share, first, last);
  }
  columns_.count = 0;
}

// Eight voxels at once, in a fixed order.
CC_LANES void VoxelSums::addTo(double* sum, const Columns& c, const double* weights, int first,
                               int last) {
  const double* const columns[] = {c.share, weights, c.stiffness, c.damping, c.x,     c.y,
                                   c.z,     c.fx,    c.fy,        c.fz,      c.length};
  CcEight all[kTerms] = {}, v[std::size(columns)];
  for (int i = first; i < last; i += 8) {
    for (std::size_t k = 0; k < std::size(columns); ++k)
      std::memcpy(&v[k], columns[k] + i, sizeof *v);
    for (int k = last - i; k < 8; ++k) v[0][k] = v[1][k] = 0;
    const CcEight share = v[0], w = v[1], x = v[4], y = v[5], z = v[6];
    const CcEight fx = w * v[7], fy = w * v[8], fz = w * v[9];
    all[kCount] += share;
    all[kStiffness] += share * v[2], all[kDamping] += share * v[3];
    all[kWeight] += w, all[kLength] += w * v[10];
    all[kVector] += fx, all[kVector + 1] += fy, all[kVector + 2] += fz;
    all[kMoment] += y * fz - z * fy;
    all[kMoment + 1] += z * fx - x * fz;
    all[kMoment + 2] += x * fy - y * fx;
  }
  for (int k = 0; k < kTerms; ++k)
    for (int lane = 0; lane < 8; ++lane) sum[k] += all[k][lane];
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
    Vec3 f = Vec3::Zero();
    if (vectors_) f = own_->paper->vectors->at(v).toRepresentative / h;
    put(share, found_->binner.patchOf(i), v.cast<double>() + Vec3::Constant(0.5),
        cloud.material(v.x(), v.y(), v.z()), f.data());
    if (columns_.count == search::kLanes) sumUp();
  }
  sumUp();
}

void VoxelSums::finish(std::vector<PatchMatter>& matter) {
  flush();
  double weight = 0;
  for (const Sum& sum : sums_) weight += sum.hard[kWeight];
  // (5), where nothing that is touched has a hardness.
  const bool plain = mixed_ && !(weight > 0);
  const int side = dir_->side;
  const double h = own_->field->cloud().voxelSize(), sign = side == kA ? 1 : -1;
  const Eigen::Matrix3d turn = toFrame_.orientation.toRotationMatrix();
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    const double* const from = plain ? sums_[k].plain : sums_[k].hard;
    PatchMatter& to = matter[k];
    to.count[side] += from[kCount];
    to.stiffness[side] += from[kStiffness];
    to.damping[side] += from[kDamping];
    const Vec3 f = sign * h * turn * vec(from + kVector);
    to.vectors += f;
    to.moment += sign * h * h * turn * vec(from + kMoment) + toFrame_.position.cross(f);
    to.lengths += h * from[kLength];
  }
}

}  // namespace cloudcontact
