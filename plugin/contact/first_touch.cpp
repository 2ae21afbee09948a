// Advancement by bounds, then by searches, then by halves.
#include "contact/first_touch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "contact/pair_frame.h"
#include "field/field_data.h"
#include "kernels/contact/search.h"

namespace cloudcontact {

namespace {

constexpr double kNear = 2;  // [voxels] of gap: bodies are searched
// [voxels] deeper than before. A corner that is less deep in a wall has no sure normal.
constexpr double kTouches = 0.5;
constexpr double kStands = 0.05;    // [voxels] of gap: bodies touch at the start
constexpr double kExact = 0.05;     // [voxels] of motion
constexpr std::size_t kMost = 500;  // searches before motions grow, of bodies that graze
constexpr int kSweeps = 8;          // over the points of bodies that touch already

// The nearest that the surface of `body` can be to a point of its frame [m].
double leastDistance(const ContactBody& body, const Vec3& local) {
  if (body.shape) {
    if (std::holds_alternative<SurfaceSolid>(*body.shape))
      return std::abs(solidAt(*body.shape, local).depth);
    if (isDistance(*body.shape)) return -solidAt(*body.shape, local).depth;
    return boundsOf(*body.shape).exteriorDistance(local);
  }
  const FieldData& field = body.field->data();
  const double outside = field.bounds().exteriorDistance(local);
  const double voxel = field.cloud().voxelSize();
  const Vec3 grid = (local - field.cloud().origin()) / voxel;
  const Vec3 size = field.cloud().size().cast<double>();
  if ((grid.array() < 0).any() || (grid.array() >= size.array()).any()) return outside;
  const Eigen::Vector3f x = grid.cast<float>();
  const CcPlace place = ccPlaceOf(field.records().bricks(), x.data());
  if (place.brick >= field.cloud().bricks().prod()) return outside;  // rounded up to the edge
  return std::max(outside, voxel * field.records().between()[place.brick]);
}

// A lower bound of the gap between the surface of `own`, a field, and `other` [m].
double leastGap(const ContactBody& own, const ContactBody& other) {
  const SampleBricks& bricks = own.field->data().samples().bricks;
  const Cloud& cloud = own.field->cloud();
  const Pose toOther = other.pose.inverse() * own.pose;
  const Eigen::AlignedBox3d box = own.field->bounds();
  const double whole =
      leastDistance(other, toOther.toWorld(box.center())) - box.diagonal().norm() / 2;
  if (whole > box.diagonal().norm()) return whole;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < bricks.x.size(); ++k) {
    const Vec3 grid(bricks.x[k], bricks.y[k], bricks.z[k]);
    const Vec3 x = toOther.toWorld(cloud.origin() + cloud.voxelSize() * grid);
    least = std::min(least, leastDistance(other, x) - cloud.voxelSize() * bricks.radius[k]);
    if (least <= 0) break;
  }
  return least;
}

double leastGapOf(const ContactBody& a, const ContactBody& b) {
  if (!a.field) return leastGap(b, a);
  if (!b.field) return leastGap(a, b);
  const auto bricks = [](const ContactBody& body) {
    return body.field->data().samples().bricks.x.size();
  };
  return bricks(a) <= bricks(b) ? leastGap(a, b) : leastGap(b, a);
}

double voxelOf(const ContactBody& a, const ContactBody& b) {
  double size = std::numeric_limits<double>::infinity();
  for (const ContactBody* body : {&a, &b})
    if (body->field) size = std::min(size, body->field->cloud().voxelSize());
  return size;
}

void moveTo(double time, const ContactBody& start, ContactBody& body) {
  body.pose = movedOn(start.pose, start.motion, time);
  body.motion.center = start.motion.center + time * start.motion.linear;
}

}  // namespace

double spinSpeed(const ContactBody& body, const ContactBody& other) {
  const double rate = body.motion.angular.norm();
  if (!(rate > 0)) return 0;
  const auto boxOf = [](const ContactBody& of) {
    return of.field ? of.field->bounds() : boundsOf(*of.shape);
  };
  const auto farthest = [&](const ContactBody& of) {
    const Eigen::AlignedBox3d box = boxOf(of);
    const Vec3 center = of.pose.toLocal(body.motion.center);
    return (box.max() - center).cwiseAbs().cwiseMax((box.min() - center).cwiseAbs()).norm();
  };
  const double reach = farthest(body);
  return rate * (std::isfinite(reach) ? reach : farthest(other));
}

double closingSpeed(const ContactBody& a, const ContactBody& b) {
  return (a.motion.linear - b.motion.linear).norm() + spinSpeed(a, b) + spinSpeed(b, a);
}

FirstTouch::FirstTouch(std::shared_ptr<ContactWorkspace> workspace)
    : finder_(std::move(workspace)) {}

void FirstTouch::place(double time) {
  moveTo(time - start_, startA_, a_);
  moveTo(time - start_, startB_, b_);
}

void FirstTouch::search() {
  finder_.search(a_, b_, settings_, found_);
  ++searches_;
}

// [m] Minus infinity: nothing is near.
double FirstTouch::deepest() const {
  double depth = -std::numeric_limits<double>::infinity();
  for (const ContactPoint& point : found_.points) depth = std::max(depth, point.depth);
  return depth;
}

// Takes the part of A's velocity away that drives it into B where they touch at the start.
void FirstTouch::keepApart() {
  limit_ = std::max(0.0, deepest()) + kTouches * voxel_;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (const ContactPoint& point : found_.points) {
      if (point.depth < -kStands * voxel_) continue;
      const Vec3 meeting = startA_.motion.at(point.position) - startB_.motion.at(point.position);
      const double closing = meeting.dot(point.normal);
      if (closing > 0) startA_.motion.linear -= closing * point.normal;
    }
  a_.motion = startA_.motion;
  speed_ = closingSpeed(a_, b_);
}

Touch FirstTouch::between(double apart, double touching) {
  while ((touching - apart) * speed_ > kExact * voxel_) {
    const double middle = 0.5 * (apart + touching);
    if (!(middle > apart && middle < touching)) break;
    place(middle);
    search();
    (deepest() > limit_ ? touching : apart) = middle;
  }
  place(touching);
  return {touching, a_.pose * fromA_, b_.pose * fromB_, checked()};
}

std::optional<Touch> FirstTouch::find(const ContactBody& a, const ContactBody& b, double from,
                                      double until) {
  startA_ = a_ = a, startB_ = b_ = b;
  velocity_ = a.motion.linear;
  fromA_ = a.pose.inverse(), fromB_ = b.pose.inverse();
  start_ = 0;
  place(from);
  startA_ = a_, startB_ = b_, start_ = from;
  searches_ = 0;
  voxel_ = voxelOf(a, b);
  settings_.margin = kNear * voxel_;
  limit_ = kTouches * voxel_;
  speed_ = closingSpeed(a, b);
  bool first = from == 0;
  for (double time = from, apart = from; speed_ > 0 && std::isfinite(speed_); first = false) {
    place(time);
    double way = leastGapOf(a_, b_);
    if (way <= kNear * voxel_) {
      search();
      if (first) keepApart();
      if (deepest() > limit_) return between(apart, time);
      way = std::clamp(-deepest(), voxel_, kNear * voxel_);
      if (searches_ > kMost) way *= double(searches_) / kMost;
    }
    if (time >= until || speed_ <= 0) break;
    apart = time;
    time = std::min(until, time + way / speed_);
    if (!(time > apart)) break;
  }
  return std::nullopt;
}

}  // namespace cloudcontact
