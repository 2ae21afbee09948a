// Restitution as Bullet's rows have it, with the touch between two steps.
#include "bullet/impact.h"

#include <algorithm>
#include <cmath>

#include "bullet/object_motion.h"
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

// No push but that of the impact, and none from the last step's. `gap` [m]: that may close.
void makeBare(btManifoldPoint& point, double restitution, btScalar gap = 0) {
  point.m_contactPointFlags &= ~BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  point.m_combinedRestitution = static_cast<btScalar>(restitution);
  point.m_distance1 = gap;
  point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
}

// Bare, and leaving at `speed` [m/s] after the step.
void makeLeaving(btManifoldPoint& point, double speed, double step) {
  makeBare(point, 0, static_cast<btScalar>(-speed * step));
  point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
  point.m_contactERP = 1;
}

// The square of the speed with which surfaces touch: of bodies that touch already, that with which
// they did. Negative if the pull has not brought them here.
double touchSquare(double closing, double depth, double pull, double step) {
  return closing * closing + pull * step * closing - 2 * pull * depth;
}

}  // namespace

double closingOf(const ContactPoint& source, const PairSides& sides) {
  const Vec3 meeting = sides.motionA.at(source.position) - sides.motionB.at(source.position);
  return meeting.dot(source.normal);
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

Impact::Impact(const PairSides& sides, double step) : sides_(sides), step_(step) {
  pull_ =
      gravityOf(*sides.wrapA->getCollisionObject()) - gravityOf(*sides.wrapB->getCollisionObject());
}

double Impact::wayOf(const ContactPoint& source) const {
  return step_ * (closingOf(source, sides_) + step_ * pull_.dot(source.normal));
}

void Impact::take(const ContactPoint& source, const btManifoldPoint* before, double restitution,
                  double late, btManifoldPoint& point) const {
  if (!(restitution > 0) || !(step_ > 0) || source.damping > 0) return;
  const double closing = closingOf(source, sides_), pull = pull_.dot(source.normal);
  if (closing <= 0 && source.depth > 0) {
    if (before && isBare(*before)) makeBare(point, 0);
    return;
  }
  const double way = wayOf(source);
  if (source.depth + way + late <= 0) return;
  const double depth = std::max(source.depth, -way);
  if (touchSquare(closing, depth, pull, step_) < kBouncesFrom * kBouncesFrom) return;
  const double speed = bounceSpeed(restitution, closing, depth, pull, step_);
  if (speed <= 0)
    makeBare(point, 0, static_cast<btScalar>(way));
  else if (closing < kRowBouncesFrom)
    makeLeaving(point, speed, step_);
  else
    makeBare(point, speed / closing);
}

void Impact::stop(const ContactPoint& source, double most, btManifoldPoint& point) const {
  if (isBare(point) || !(step_ * closingOf(source, sides_) > most)) return;
  makeBare(point, 0, std::max(point.m_distance1, btScalar(0)));
}

void Impact::stopCenters(const ContactPoint& source, double most, btManifoldPoint& point) const {
  const double closing = (sides_.motionA.linear - sides_.motionB.linear).dot(source.normal);
  if (!(step_ * closing > 2 * most)) return;
  double gap = std::max(0.0, -source.depth);
  if (sides_.touch)
    gap += sides_.touch->time * (closing - sides_.touch->checked.dot(source.normal));
  makeBare(point, 0, static_cast<btScalar>(gap));
  moveToCenters(point);
}

void Impact::moveToCenters(btManifoldPoint& point) const {
  const auto center = [](const btCollisionObjectWrapper& wrap) {
    return wrap.getCollisionObject()->getWorldTransform().getOrigin();
  };
  point.m_positionWorldOnA = center(*sides_.wrapA);
  point.m_positionWorldOnB = center(*sides_.wrapB);
}

void Impact::moveApart(const ContactPoint& source, double speed, btManifoldPoint& point) const {
  makeLeaving(point, source.depth > 0 ? speed : source.depth / step_, step_);
  point.m_combinedFriction = 0;
  moveToCenters(point);
}

}  // namespace cloudcontact
