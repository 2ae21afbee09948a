// How much a pair's gap changes by turning: at most step^2 spin speed, by the speed along the
// surface. A part that rolls has no such speed.
#include "bullet/turning.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <algorithm>
#include <utility>

namespace cloudcontact {

namespace {

// [voxels] The gap must change by more than the first by turning, and must close by no more than
// the second. The tip that a spike of a ton slides down at 5 m/s while it turns at 3 rad/s goes
// 0.06 voxel deeper in each step of 10 ms than any row can see: it was 0.80 voxel deep without,
// 0.43 with. A nut runs down its bolt at 240 Hz by 3.0 to 3.2 rad without, by 3.4 to 3.5 with, and
// by 3.58 in theory; with 0.001 it gains energy at times, with 0.01 it is held back.
constexpr double kTurns = 0.005, kCloses = 0.5;
// [voxels] Deeper pairs may have to leave (leaving.h), by where they are.
constexpr double kDeep = 2;

// What the contact's push alone would add to the bodies' speed within the step, over the speed at
// which they slide. A pair that is thrown about does not move on as it does: without this limit a
// peg that rattles in its hole at 60 Hz jams. A nut on its thread needs 4, since what presses its
// flanks holds itself in balance.
constexpr double kSteady = 6;

// [voxels] Pairs that touch by less than the first and close by more than the second in a step get
// points for what is about to touch beside what does (ContactFinder::lookAround()). Slower ones
// turn by less than the fits' noise until they are seen again.
constexpr double kLightly = 0.1, kClosesLightly = 0.01;

struct Turning {
  double by = 0, closes = 0, depth = 0;  // [m]
  double along = 0;                      // [m/s]
};

// [N]
double pushOf(const PairQuery& query, const ContactResult& contact) {
  if (query.law.automatic) return query.law.automatic->force(depthOf(contact));
  double sum = 0;
  for (const ContactPoint& point : contact.points)
    sum += point.stiffness * std::max(0.0, point.depth);
  return sum;
}

Turning turningAt(const TurningPlace& at, const PairQuery& query, double step) {
  const double spin = std::max(query.a.motion.angular.norm(), query.b.motion.angular.norm());
  const Vec3 meeting = query.a.motion.at(at.position) - query.b.motion.at(at.position);
  const double closing = meeting.dot(at.normal);
  const double along = (meeting - closing * at.normal).norm();
  return {step * step * spin * along, step * std::abs(closing), at.depth, along};
}

TurningPlace placeOf(const Patch& patch) {
  return {patch.position, patch.normal, patch.depth, 0};
}

Turning turningOf(const PairQuery& query, const ContactResult& contact, double step) {
  Turning most;
  for (const Patch& patch : contact.patches) {
    if (patch.beside) continue;
    const Turning at = turningAt(placeOf(patch), query, step);
    most = {std::max(most.by, at.by), std::max(most.closes, at.closes),
            std::max(most.depth, at.depth), std::max(most.along, at.along)};
  }
  return most;
}

// What bounces is met where it touches (step_adjustments.h).
bool bounces(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  return gCalculateCombinedRestitutionCallback(a.getCollisionObject(), b.getCollisionObject()) > 0;
}

bool turnsSo(const Turning& turning, double push, double step, const PairQuery& query,
             const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  return turning.by >= kTurns * query.voxel && turning.closes <= kCloses * query.voxel &&
         turning.depth <= kDeep * query.voxel &&
         step * push <= kSteady * query.mass * turning.along && !bounces(a, b);
}

}  // namespace

bool turnsWithin(double step, const PairQuery& query, const ContactResult& found,
                 const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  return turnsSo(turningOf(query, found, step), pushOf(query, found), step, query, a, b);
}

bool closesLightly(double step, const Vec3& gains, const PairQuery& query,
                   const ContactResult& found) {
  double deepest = -1e30, closes = 0;
  for (const ContactPoint& point : found.points) {
    const Vec3 meeting =
        query.a.motion.at(point.position) - query.b.motion.at(point.position) + gains;
    deepest = std::max(deepest, point.depth);
    closes = std::max(closes, step * meeting.dot(point.normal));
  }
  return deepest < kLightly * query.voxel && closes > 0.5 * deepest &&
         closes > kClosesLightly * query.voxel;
}

TurningPlace turningPlace(double step, const PairQuery& query, const ContactResult& found) {
  TurningPlace place;
  double most = -1;
  for (const Patch& patch : found.patches) {
    if (patch.beside) continue;
    const double by = turningAt(placeOf(patch), query, step).by;
    if (by > std::exchange(most, std::max(most, by))) place = placeOf(patch);
  }
  place.push = pushOf(query, found);
  return place;
}

bool goesOnTurning(double step, const PairQuery& query, const TurningPlace& last,
                   const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  const Vec3 meeting = query.a.motion.at(last.position) - query.b.motion.at(last.position);
  return last.depth + step * meeting.dot(last.normal) > 0 &&
         turnsSo(turningAt(last, query, step), last.push, step, query, a, b);
}

Touch endOf(double step, ContactBody& a, ContactBody& b) {
  Touch end;
  end.time = step;
  const auto move = [step](ContactBody& body) {
    const Pose from = body.pose;
    body.pose = movedOn(from, body.motion, step);
    body.motion.center += step * body.motion.linear;
    return body.pose * from.inverse();
  };
  end.a = move(a);
  end.b = move(b);
  return end;
}

Turn turnOn(double step, PairQuery& query, std::optional<Touch>& touch) {
  const Turn turn{{query.a.pose, query.b.pose}, {query.a.motion, query.b.motion}};
  touch = endOf(step, query.a, query.b);
  return turn;
}

void turnBack(const Turn& turn, PairQuery& query, std::optional<Touch>& touch) {
  query.a.pose = turn.poses[0], query.b.pose = turn.poses[1];
  query.a.motion = turn.motions[0], query.b.motion = turn.motions[1];
  touch.reset();
}

}  // namespace cloudcontact
