// Depth of voxels' centers in a field or a solid.
#include "contact/touched_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/contact/search.h"

namespace cloudcontact {

namespace {

constexpr double kOutside = -std::numeric_limits<double>::infinity();

const BrickCoverage& solidBrick() {
  static const BrickCoverage kFull = [] {
    BrickCoverage full;
    full.fill(255);
    return full;
  }();
  return kFull;
}

}  // namespace

TouchedVoxels::TouchedVoxels(const ContactBody& own, const ContactBody& other,
                             const PairFrame& frame, const PlacedSolid* area, double shift)
    : own_(own.field->data()),
      way_(wayOf(own, other, frame)),
      toFrame_(frame.pose.inverse() * own.pose * gridPose(own.field->cloud())),
      toOther_(other.pose.inverse() * own.pose * gridPose(own.field->cloud())),
      turn_((frame.pose.orientation.conjugate() * other.pose.orientation).toRotationMatrix()),
      voxel_(own.field->cloud().voxelSize()),
      shift_(shift) {
  if (area)
    solid_ = *area;
  else if (other.shape)
    solid_ = {*other.shape, Pose{}};
  else
    field_ = &other.field->data();
}

TouchedVoxels::Range TouchedVoxels::bricksNear(const HitColumns& hits, double reach,
                                               std::vector<std::uint8_t>& near) const {
  const auto c = hits.columns();
  const Vec3 around = Vec3::Constant(reach / voxel_);
  const Eigen::Vector3i last = own_.cloud().bricks() - Eigen::Vector3i::Ones();
  const auto bricksAt = [&](std::size_t i) {
    const Vec3 at = toFrame_.toLocal(Vec3(c.x[i], c.y[i], c.z[i])) / voxel_;
    const auto brickOf = [&](const Vec3& x) -> Eigen::Vector3i {
      const Vec3 inside = (x / kBrickEdge).cwiseMax(0.0).cwiseMin(last.cast<double>());
      return inside.cast<int>();
    };
    return Range{brickOf(at - around), brickOf(at + around)};
  };
  Range range = bricksAt(0);
  for (std::size_t i = 1; i < hits.size(); ++i) {
    const Range one = bricksAt(i);
    range.low = range.low.cwiseMin(one.low);
    range.high = range.high.cwiseMax(one.high);
  }
  const Eigen::Vector3i n = range.high - range.low + Eigen::Vector3i::Ones();
  near.assign(static_cast<std::size_t>(n.prod()), 0);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Range one = bricksAt(i);
    for (int z = one.low.z(); z <= one.high.z(); ++z)
      for (int y = one.low.y(); y <= one.high.y(); ++y)
        for (int x = one.low.x(); x <= one.high.x(); ++x)
          near[gridIndex(Eigen::Vector3i(x, y, z) - range.low, n)] = 1;
  }
  return range;
}

bool TouchedVoxels::within(const Eigen::Vector3i& brick) const {
  const Vec3 middle = (kBrickEdge * brick).cast<double>() + Vec3::Constant(0.5 * kBrickEdge);
  const float at[3] = {float(middle.x()), float(middle.y()), float(middle.z())};
  Vec3 normal;
  return (field_ ? depthInField(at, normal) : depthInSolid(at, normal)) > 0;
}

const std::uint8_t* TouchedVoxels::coverageOf(const Eigen::Vector3i& brick) const {
  const Cloud::Voxels& voxels = own_.cloud().voxels();
  const std::int32_t entry = voxels.table[gridIndex(brick, voxels.bricks)];
  if (entry == kEmptyBrick) return nullptr;
  return (entry == kSolidBrick ? solidBrick() : voxels.coverage[static_cast<std::size_t>(entry)])
      .data();
}

bool TouchedVoxels::farFrom(const Eigen::Vector3i& brick) const {
  constexpr double kRadius = kBrickEdge * kHalfDiagonal;
  const Vec3 middle = (kBrickEdge * brick).cast<double>() + Vec3::Constant(0.5 * kBrickEdge);
  if (!field_) {
    if (!isDistance(solid_.solid)) return false;
    return depthOf(solid_, toOther_.toWorld(voxel_ * middle)) < -(kRadius + 0.5) * voxel_ - shift_;
  }
  const double otherVoxel = field_->cloud().voxelSize();
  const float at[3] = {float(middle.x()), float(middle.y()), float(middle.z())};
  const double reach = kRadius + 0.5 + shift_ / voxel_;
  return !ccBrickTouches(&way_.toOther, at, static_cast<float>(reach),
                         static_cast<float>(voxel_ / otherVoxel), field_->records().bricks(),
                         field_->records().between());
}

double TouchedVoxels::depthInField(const float* at, Vec3& normal) const {
  float there[3], turned[3];
  ccApply(&way_.toOther, at, there);
  const CcPlace place = ccPlaceOf(field_->records().bricks(), there);
  const CcVoxel record =
      field_->records().records()[field_->records().firsts()[place.brick] + place.cell];
  normal.setZero();
  const double voxel = field_->cloud().voxelSize();
  if (ccPlaneCount(record) == 0)
    return record.b == CC_DEEP_INSIDE ? double(CC_BEYOND_BAND) * voxel : kOutside;
  const CcDepth found = ccVoxelDepth(record, field_->planes(), place.r);
  ccTurn(way_.frameFromOther, found.normal, turned);
  normal = {turned[0], turned[1], turned[2]};
  return static_cast<double>(found.depth) * voxel;
}

double TouchedVoxels::depthInSolid(const float* at, Vec3& normal) const {
  const Vec3 point = toOther_.toWorld(voxel_ * Vec3(at[0], at[1], at[2]));
  const double depth = depthOf(solid_, point);
  if (depth + shift_ > -0.5 * voxel_) normal = turn_ * normalOf(solid_, point);
  return depth;
}

bool TouchedVoxels::lookUp(const VoxelIndex& v, std::uint8_t coverage, TouchedVoxel& found) const {
  const float at[3] = {float(v.x()) + 0.5f, float(v.y()) + 0.5f, float(v.z()) + 0.5f};
  const double depth =
      (field_ ? depthInField(at, found.other) : depthInSolid(at, found.other)) + shift_;
  if (!(depth > -0.5 * voxel_)) return false;
  found.voxel = v;
  found.share = std::min(depth / voxel_ + 0.5, 1.0) * coverage / 255;
  found.at = toFrame_.toWorld(voxel_ * Vec3(at[0], at[1], at[2]));
  return true;
}

}  // namespace cloudcontact
