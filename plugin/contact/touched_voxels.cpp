// Depth of voxels' centers in a field or a solid.
#include "contact/touched_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/grid_index.h"
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

TouchedVoxels::Range TouchedVoxels::rangeOf(const Eigen::AlignedBox3d& box) const {
  Eigen::AlignedBox3d grid;
  for (int k = 0; k < 8; ++k)
    grid.extend(toFrame_.toLocal(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))) /
                voxel_);
  const Vec3 top = own_.cloud().size().cast<double>() - Vec3::Ones();
  const auto voxelOf = [&](const Vec3& x) -> Eigen::Vector3i {
    return x.cwiseMax(0.0).cwiseMin(top).cast<int>();
  };
  return {voxelOf(grid.min()), voxelOf(grid.max())};
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
