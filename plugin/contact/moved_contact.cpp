// How far a pair has moved since its last search, and its contact moved along.
#include "contact/moved_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/pair_frame.h"

namespace cloudcontact {

namespace {

// What a moved contact may be wrong by, as a depth: noise of the fits [voxels], and a part of the
// motion. On a slope a leaning cube comes to rest with parts of 0.02 to 0.1; with a noise of 1e-3
// it rocks longer, and without any limit it creeps.
constexpr double kNoise = 2e-4, kWrong = 0.05;
// [steps] A pair that does not move is searched this often, so that it comes to the same rest.
constexpr int kMostAge = 60;
Eigen::AlignedBox3d boxOf(const ContactBody& body) {
  return body.field ? body.field->bounds() : boundsOf(*body.shape);
}

bool isBounded(const Eigen::AlignedBox3d& box) {
  return box.min().allFinite() && box.max().allFinite() && !box.isEmpty();
}

// The motion of a body from one pose to another, in the world.
Pose motionOf(const Pose& from, const Pose& to) {
  return to * from.inverse();
}

// A contact's force and moment without damping, over its stiffness.
struct Push {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  // [m], [m^2]
  double deepest = -std::numeric_limits<double>::infinity();
};

template <typename Moved>
Push pushOf(const ContactResult& contact, const Vec3& about, double stiffness, const Moved& moved) {
  Push push;
  for (const ContactPoint& point : contact.points) {
    const ContactPoint p = moved(point);
    const Vec3 force = p.stiffness / stiffness * std::max(0.0, p.depth) * p.normal;
    push.force += force;
    push.moment += (p.position - about).cross(force);
    push.deepest = std::max(push.deepest, p.depth);
  }
  return push;
}

// Points and patches that follow two bodies' motions.
struct Followers {
  Pose byA, byB;

  void follow(Vec3& position, Vec3& normal, double& depth) const {
    const Vec3 onA = byA.toWorld(position), onB = byB.toWorld(position);
    normal = (byA.orientation * normal + byB.orientation * normal).normalized();
    depth += normal.dot(onA - onB);
    position = (onA + onB) / 2;
  }
  ContactPoint operator()(ContactPoint point) const {
    const double before = point.depth;
    follow(point.position, point.normal, point.depth);
    // Its force grows by its slope.
    if (before > 0 && point.depth > 0.5 * before)
      point.stiffness = point.slope + (point.stiffness - point.slope) * (before / point.depth);
    return point;
  }
};

// How much a contact, moved, differs from another of the same bodies in force, moment and gap, as a
// depth [m].
double differenceOf(const ContactResult& one, const Followers& moved, const ContactResult& other,
                    double voxel) {
  if (one.points.size() != other.points.size() || one.patches.size() != other.patches.size())
    return std::numeric_limits<double>::infinity();
  if (other.points.empty()) return 0;
  Vec3 middle = Vec3::Zero();
  double stiffness = 0, spread = 0;
  for (const ContactPoint& p : other.points) middle += p.position / double(other.points.size());
  for (const ContactPoint& p : other.points) {
    spread = std::max(spread, (p.position - middle).norm());
    stiffness += p.stiffness;
  }
  const Push x = pushOf(one, middle, stiffness, moved),
             y = pushOf(other, middle, stiffness, [](const ContactPoint&p) { return p; });
  if (x.deepest <= 0 && y.deepest <= 0) return std::abs(x.deepest - y.deepest);
  return std::max((x.force - y.force).norm(),
                  (x.moment - y.moment).norm() / std::max(spread, voxel));
}

}  // namespace

// Where the other body's box, made wider by `around`, meets the own one.
MovedContact::Reach MovedContact::reachOf(const ContactBody& own, const ContactBody& other,
                                          double around) {
  Eigen::AlignedBox3d box = boxOf(own);
  const Eigen::AlignedBox3d others = boxOf(other);
  const Pose toOwn = own.pose.inverse() * other.pose;
  if (isBounded(others)) {
    const Vec3 center = toOwn.toWorld(others.center());
    const Vec3 half = toOwn.orientation.toRotationMatrix().cwiseAbs() * (others.sizes() / 2) +
                      Vec3::Constant(around);
    const Eigen::AlignedBox3d seen(center - half, center + half);
    const Eigen::AlignedBox3d both = isBounded(box) ? box.intersection(seen) : seen;
    if (!both.isEmpty()) box = both;
  }
  if (!isBounded(box))
    return {Vec3::Zero(), Vec3::Constant(std::numeric_limits<double>::infinity())};
  return {box.center(), box.sizes() / 2};
}

// How far a motion takes the points of a box. It is affine, so that a corner moves farthest.
double MovedContact::farthest(const Reach& reach, const Pose& motion) {
  const Eigen::Matrix3d turn = motion.orientation.toRotationMatrix() - Eigen::Matrix3d::Identity();
  const Vec3 middle = turn * reach.center + motion.position;
  const Eigen::Matrix3d edge = turn * reach.half.asDiagonal();
  double most = 0;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner = middle + (k & 1 ? 1 : -1) * edge.col(0) + (k & 2 ? 1 : -1) * edge.col(1) +
                        (k & 4 ? 1 : -1) * edge.col(2);
    most = std::max(most, corner.squaredNorm());
  }
  return std::sqrt(most);
}

// Of the two bounds, one in each body's frame, the smaller, so that the order of the bodies does
// not matter.
double MovedContact::moved(const ContactBody& a, const ContactBody& b) const {
  const Pose before = poses_[0].inverse() * poses_[1], now = a.pose.inverse() * b.pose;
  const Pose beforeB = poses_[1].inverse() * poses_[0], nowB = b.pose.inverse() * a.pose;
  const double ofA = farthest(reaches_[0], motionOf(before, now));
  const double ofB = farthest(reaches_[1], motionOf(beforeB, nowB));
  // Infinity times no rotation is NaN.
  return std::isnan(ofA) ? ofB : std::isnan(ofB) ? ofA : std::min(ofA, ofB);
}

// Before a newly searched contact is kept: how well the old one, moved, foretells it. A model that
// is less stiff than the contact lags behind it, and a lag drives vibrations. It must stay below
// what the contact's damping takes out, whatever the tolerance.
void MovedContact::learn(const ContactBody& a, const ContactBody& b, double most, double voxel,
                         const ContactResult& found) {
  if (!kept_) {
    tolerance_ = 0;
    return;
  }
  const double far = moved(a, b);
  if (!(far <= 2 * most)) return;
  const Followers followers{motionOf(poses_[0], a.pose), motionOf(poses_[1], b.pose)};
  const double wrong = differenceOf(found_, followers, found, voxel);
  const bool right = wrong <= kNoise * voxel + kWrong * far;
  tolerance_ = right ? std::min(most, 2 * tolerance_ + most / 16) : tolerance_ / 4;
  if (tolerance_ < most / 64) tolerance_ = 0;
}

void MovedContact::keep(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                        double most, double voxel, const ContactResult& found) {
  learn(a, b, most, voxel, found);
  age_ = 0;
  poses_[0] = a.pose;
  poses_[1] = b.pose;
  const double around = settings.margin + most;
  reaches_[0] = reachOf(a, b, around);
  reaches_[1] = reachOf(b, a, around);
  free_ = marginOf(a, b, voxel, settings.margin);
  found_ = found;
  kept_ = true;
}

bool MovedContact::holds(const ContactBody& a, const ContactBody& b, double margin) const {
  if (!kept_ || age_ >= kMostAge) return false;
  const double far = moved(a, b);
  if (found_.points.empty()) return margin + far <= free_ + tolerance_;
  return far <= tolerance_;
}

void MovedContact::move(const ContactBody& a, const ContactBody& b, ContactResult& there) const {
  const Followers followers{motionOf(poses_[0], a.pose), motionOf(poses_[1], b.pose)};
  there = found_;
  for (Patch& patch : there.patches) followers.follow(patch.position, patch.normal, patch.depth);
  for (ContactPoint& point : there.points) point = followers(point);
}

}  // namespace cloudcontact
