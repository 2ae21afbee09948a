// How far a pair has moved since its last search, and its contact moved along.
#include "contact/moved_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "contact/pair_frame.h"

namespace cloudcontact {

namespace {

// What a moved contact may be wrong by, as a depth: noise of the fits [voxels], or a part of the
// depth if that is less, and a part of the motion. On a slope a leaning cube comes to rest with
// parts of 0.02 to 0.1; with a noise of 1e-3 it rocks longer, and without any limit it creeps.
constexpr double kNoise = 2e-4, kNoiseOfDepth = 2e-3, kWrong = 0.05;
// Of its depth, by which a pair may move: on a stiff spring, bodies that sag by a ten thousandth of
// a voxel lift off within a hundredth. A body on an automatic spring sags by a tenth of a voxel.
constexpr double kOfDepth = 0.2;
// [steps] A pair that hardly moves is searched this often, so that it comes to the same rest.
constexpr int kMostAge = 60;
// [voxels] What has moved by less since the search has not: searched again, its places would be
// rounded another way, and the pair would find a new rest.
constexpr double kStill = 1e-5;

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

double forceOf(const ContactPoint& point) {
  return point.stiffness * std::max(0.0, point.depth);
}

Push pushOf(const ContactResult& contact, const Vec3& about, double stiffness) {
  Push push;
  for (const ContactPoint& p : contact.points) {
    const Vec3 force = forceOf(p) / stiffness * p.normal;
    push.force += force;
    push.moment += (p.position - about).cross(force);
    push.deepest = std::max(push.deepest, p.depth);
  }
  return push;
}

// What follows two bodies' motions.
struct Followers {
  Pose byA, byB;

  Vec3 turn() const { return turnOf(byA) - turnOf(byB); }
  // How the bodies have come nearer at a place along a normal [m].
  double nearer(const Vec3& position, const Vec3& normal) const {
    return normal.dot(slide(position));
  }
  // How A has moved against B there [m].
  Vec3 slide(const Vec3& position) const { return byA.toWorld(position) - byB.toWorld(position); }
  Vec3 position(const Vec3& at) const { return (byA.toWorld(at) + byB.toWorld(at)) / 2; }

 private:
  static Vec3 turnOf(const Pose& motion) {
    const Eigen::Quaterniond& q = motion.orientation;
    return (q.w() < 0 ? -2 : 2) * q.vec();
  }
};

// A patch's motion, to first order.
struct PatchMotion {
  const Followers& by;
  const PatchTangent& tangent;
  Vec3 shift, tilt;               // of points and normals, besides moving with the bodies
  Vec3 around, center;            // normals lean by `around` x the way from there, too
  double nearer, nearerAtMiddle;  // at the center of pressure, and of the area [m]

  PatchMotion(const Followers& followers, const Patch& patch)
      : by(followers), tangent(patch.tangent) {
    const Eigen::Vector2d slide = inPlane(by.slide(patch.position)),
                          g = inPlane(patch.normal.cross(by.turn())) +
                              tangent.lean.transpose() * slide;
    nearer = by.nearer(patch.position, patch.normal);
    nearerAtMiddle = nearer + g.dot(tangent.middle);
    shift = inWorld(tangent.roll * g + nearer * tangent.aside);
    tilt = inWorld(tangent.tilt * g - tangent.bend * slide);
    around = tangent.twist * patch.normal.dot(by.turn()) * patch.normal;
    center = patch.position;
  }
  // By which its volume has become more.
  double growth() const { return std::max(0.0, 1 + tangent.perDepth * nearerAtMiddle); }
  Eigen::Vector2d inPlane(const Vec3& v) const {
    return {tangent.along[0].dot(v), tangent.along[1].dot(v)};
  }
  Vec3 inWorld(const Eigen::Vector2d& v) const {
    return v.x() * tangent.along[0] + v.y() * tangent.along[1];
  }
  void move(Vec3& position, Vec3& normal, double& depth) const {
    depth += by.nearer(position, normal);
    normal = (tangent.trustA * (by.byA.orientation * normal) +
              (1 - tangent.trustA) * (by.byB.orientation * normal) + tilt +
              around.cross(position - center))
                 .normalized();
    position = by.position(position) + shift;
  }
};

double forceOf(std::span<const ContactPoint> points) {
  double sum = 0;
  for (const ContactPoint& p : points) sum += forceOf(p);
  return sum;
}

// Moves a patch and its points, each of which has its part of k. Returns their forces' sum.
double moveBy(const PatchMotion& motion, Patch& patch, std::span<ContactPoint> points) {
  double force = 0;
  for (ContactPoint& p : points) {
    const double before = p.depth;
    motion.move(p.position, p.normal, p.depth);
    if (before > 0 && p.depth > 0.5 * before)
      p.stiffness = p.slope + (p.stiffness - p.slope) * (before / p.depth);
    force += forceOf(p);
  }
  motion.move(patch.position, patch.normal, patch.depth);
  return force;
}

// What the patches that touch have together.
struct Whole {
  double force = 0, slope = 0, area = 0;  // before the motion
  double volume = 0;                      // after it, in units in which it was `force` before
  double nearer = 0, nearerAtMiddle = 0;  // times force and area

  void add(const Patch& patch, const PatchMotion& motion, std::span<const ContactPoint> points,
           double before) {
    for (const ContactPoint& p : points) slope += p.slope;
    force += before;
    area += patch.area;
    volume += before * motion.growth();
    nearer += before * motion.nearer;
    nearerAtMiddle += patch.area * motion.nearerAtMiddle;
  }
  // The pair's force after the motion. Under one spring it grows by k as the depth d does. That is
  // M2 / M1 times (1 + b/2), M1 being the volume and M2 the sum of area times depth squared
  // (docs/force.md, "Depth of the pair"): M1 grows by the approach at the area's center, M2 by
  // twice the volume's at the center of pressure.
  double forceAfter(double b, bool byArea) const {
    if (byArea || !(force > 0)) return volume;
    const double deeper = (2 + b) * nearer / force - (1 + b) * nearerAtMiddle / area;
    return std::max(0.0, force + slope * deeper);
  }
};

// Moves a contact to first order. Patches that touch share the pair's force by their volumes; what
// was near and has come in is pressed point by point.
void moveWith(const Followers& followers, bool byArea, ContactResult& contact) {
  Whole whole;
  const auto pointsOf = [&](const Patch& patch) {
    return std::span(contact.points)
        .subspan(std::size_t(patch.firstPoint), std::size_t(patch.points));
  };
  const auto forceBefore = [&](const Patch& patch) {
    return patch.depth > 0 ? forceOf(pointsOf(patch)) : 0;
  };
  for (const Patch& patch : contact.patches)
    if (const double before = forceBefore(patch); before > 0)
      whole.add(patch, {followers, patch}, pointsOf(patch), before);
  const double force = whole.forceAfter(contact.pointed, byArea);
  for (Patch& patch : contact.patches) {
    const PatchMotion motion(followers, patch);
    const double before = forceBefore(patch), after = moveBy(motion, patch, pointsOf(patch)),
                 share = whole.volume > 0 ? before * motion.growth() / whole.volume : 0;
    patch.stiffness = 0;
    for (ContactPoint& p : pointsOf(patch)) {
      if (after > 0 && before > 0) p.stiffness *= force * share / after;
      patch.stiffness += p.stiffness;
    }
  }
}

// How much a contact, moved, differs from another of the same bodies in force, moment and gap, as a
// depth [m].
double differenceOf(ContactResult one, const Followers& followers, bool byArea,
                    const ContactResult& other, double voxel) {
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
  moveWith(followers, byArea, one);
  const Push x = pushOf(one, middle, stiffness), y = pushOf(other, middle, stiffness);
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
  const double wrong = differenceOf(found_, followers, byArea_, found, voxel);
  const double depth = depthOf(found), noise = found.samples > 0
                                                   ? std::min(kNoise * voxel, kNoiseOfDepth * depth)
                                                   : kNoise * voxel;
  const bool right = wrong <= noise + kWrong * far;
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
  limit_ = found.samples > 0 ? kOfDepth * std::max(0.0, depthOf(found)) : most;
  found_ = found;
  still_ = kStill * voxel;
  byArea_ = std::holds_alternative<Foundation>(settings.law);
  kept_ = true;
}

double MovedContact::error(double voxel) const {
  return kNoise * voxel + kWrong * std::min(tolerance_, limit_);
}

bool MovedContact::holds(const ContactBody& a, const ContactBody& b, double margin) const {
  if (!kept_) return false;
  const double far = moved(a, b);
  if (age_ >= kMostAge && far > still_) return false;
  if (found_.points.empty()) return margin + far <= free_ + tolerance_;
  return far <= std::min(tolerance_, limit_);
}

void MovedContact::move(const ContactBody& a, const ContactBody& b, ContactResult& there) const {
  const Followers followers{motionOf(poses_[0], a.pose), motionOf(poses_[1], b.pose)};
  there = found_;
  moveWith(followers, byArea_, there);
}

}  // namespace cloudcontact
