// Restitution as Bullet's rows have it, with the touch between two steps; stops, and leaving.
#include "bullet/step_adjustments.h"

#include <algorithm>
#include <cmath>

#include "contact/first_touch.h"

namespace cloudcontact {

namespace {

// [m/s] Slower touches do not bounce. With Bullet's 0.2 (m_restitutionVelocityThreshold) a ball of
// restitution 0.9 that falls by half a meter ends its bounces 5.5 % early at any step.
constexpr double kBouncesFrom = 0.05;
// [m/s] Bullet's rows bounce at no lower speed before a step. A touch within a step may be faster.
constexpr double kRowBouncesFrom = 0.2;

bool isBare(const btManifoldPoint& point) {
  return !(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
}

// No push but that of the impact, and none from the last step's.
void makeBare(const BareRow& row, const PairSides& sides, btManifoldPoint& point) {
  point.m_contactPointFlags &= ~BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  point.m_combinedRestitution = static_cast<btScalar>(row.restitution);
  point.m_distance1 = static_cast<btScalar>(row.gap);
  point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
  if (row.opens) {
    point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
    point.m_contactERP = 1;
  }
  if (row.slips) point.m_combinedFriction = 0;
  if (!row.atCenters) return;
  point.m_positionWorldOnA = sides.wrapA->getCollisionObject()->getWorldTransform().getOrigin();
  point.m_positionWorldOnB = sides.wrapB->getCollisionObject()->getWorldTransform().getOrigin();
}

// The square of the speed with which surfaces touch: of bodies that touch already, that with which
// they did. Negative if the pull has not brought them here.
double touchSquare(double closing, double depth, double pull, double step) {
  return closing * closing + pull * step * closing - 2 * pull * depth;
}

// Moves the bodies' centers apart or, where the depth is negative, lets the gap close.
std::optional<BareRow> leave(const StepPoint& p, const btManifoldPoint&) {
  const double most = p.settings.leavingSpeed, step = p.settings.step;
  if (!(most > 0)) return std::nullopt;
  const double speed = p.source.depth > 0 ? most : p.source.depth / step;
  return BareRow{.gap = -speed * step, .opens = true, .atCenters = true, .slips = true};
}

std::optional<BareRow> bounce(const StepPoint& p, const btManifoldPoint&) {
  const WriteSettings& settings = p.settings;
  if (settings.leavingSpeed > 0 || settings.rigid || settings.shared || p.sides.touch)
    return std::nullopt;
  const double step = settings.step;
  if (!(p.restitution > 0) || !(step > 0) || p.source.damping > 0) return std::nullopt;
  const double closing = p.closing(), pull = p.pull.dot(p.source.normal);
  if (closing <= 0 && p.source.depth > 0)
    return p.before && isBare(*p.before) ? std::optional(BareRow()) : std::nullopt;
  const double way = p.way();
  if (p.source.depth + way + p.late <= 0) return std::nullopt;
  const double depth = std::max(p.source.depth, -way);
  if (touchSquare(closing, depth, pull, step) < kBouncesFrom * kBouncesFrom) return std::nullopt;
  if (p.waits) return BareRow{.gap = way};
  const double speed = bounceSpeed(p.restitution, closing, depth, pull, step);
  if (speed <= 0) return BareRow{.gap = way};
  if (closing < kRowBouncesFrom) return BareRow{.gap = -speed * step, .opens = true};
  return BareRow{.restitution = speed / closing};
}

// What has not bounced and closes too far ends the step at the touch, or where it is, if it
// touches.
std::optional<BareRow> stop(const StepPoint& p, const btManifoldPoint& row) {
  if (isBare(row) || !(p.settings.step * p.closing() > p.settings.stopsFrom)) return std::nullopt;
  return BareRow{.gap = std::max(row.m_distance1, btScalar(0))};
}

// If the bodies' centers come nearer by more than twice that in the step, one point of a patch
// stops these instead, without a lever. Rows with levers let a body turn about its corner, and its
// center go on through a thin wall in the same step.
std::optional<BareRow> stopCenters(const StepPoint& p, const btManifoldPoint&) {
  const PairSides& sides = p.sides;
  const double closing = (sides.motionA.linear - sides.motionB.linear).dot(p.source.normal);
  if (!p.first || !(p.settings.step * closing > 2 * p.settings.stopsFrom)) return std::nullopt;
  double gap = std::max(0.0, -p.source.depth);
  if (sides.touch) gap += sides.touch->time * (closing - sides.touch->checked.dot(p.source.normal));
  return BareRow{.gap = gap, .atCenters = true};
}

// `row`: what is written so far.
using Adjustment = std::optional<BareRow> (*)(const StepPoint& point, const btManifoldPoint& row);
constexpr Adjustment kAdjustments[] = {leave, bounce, stop, stopCenters};

}  // namespace

double StepPoint::closing() const {
  const Vec3 meeting = sides.motionA.at(source.position) - sides.motionB.at(source.position);
  return meeting.dot(source.normal);
}

double StepPoint::way() const {
  return settings.step * (closing() + settings.step * pull.dot(source.normal));
}

bool StepPoint::touchesLate() const {
  const double moves = way(), deep = source.depth + moves;
  return source.depth < 0 && deep > 0 && deep < std::min(0.5 * moves, settings.sinks);
}

// With the speed v and the gap x at a step's start, Bullet's steps keep v^2 / 2 + a x + a h v / 2
// on the way down and, with v and x after a step's solution and move, the same on the way up. The
// touch is at x = 0, with the speed that this leaves. A slow body may not get back above a gap
// within the step.
double bounceSpeed(double restitution, double closing, double depth, double pull, double step) {
  const double half = 0.5 * pull * step;
  const double touch = std::max(0.0, touchSquare(closing, depth, pull, step));
  const double square = restitution * restitution * touch + half * half + 2 * pull * depth;
  return square > 0 ? std::max(0.0, std::sqrt(square) - half) : 0;
}

void adjust(const StepPoint& point, btManifoldPoint& row) {
  for (const Adjustment adjustment : kAdjustments)
    if (const auto bare = adjustment(point, row)) makeBare(*bare, point.sides, row);
}

}  // namespace cloudcontact
