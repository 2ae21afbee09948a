// Impact: how points bounce where a restitution is stated and no damping.
//
// A stiff spring is over within a step, so no damping gives it a stated restitution. A point that
// meets faster than Bullet's threshold becomes a bare row for which Bullet's solver finds the speed
// after the impact, and stays one, without a push, until it stops leaving; then the law's spring
// goes on. A point acts in the step in which the surfaces would touch, on either side of the touch:
// the speed after it is that from which the body passes the touch at the right speed, in Bullet's
// steps.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include "bullet/pair_law.h"

namespace cloudcontact {

class Impact {
 public:
  Impact(const PairSides& sides, double step);  // [s]

  // Whether a point touches in this step.
  bool touches(const ContactPoint& source) const { return source.depth + wayOf(source) > 0; }
  // Makes a written point a bare row if it bounces or leaves. `late` [m]: it also does if it misses
  // the touch by less. `before`: last step's point, or null.
  // `restitution`: the pair's, as Bullet combines it, or a callback's.
  void take(const ContactPoint& source, const btManifoldPoint* before, double restitution,
            double late, btManifoldPoint& point) const;
  // Makes a written point that has not bounced and would close by more than `most` [m] in the step
  // a bare row: it ends the step at the touch, or where it is, if it touches.
  void stop(const ContactPoint& source, double most, btManifoldPoint& point) const;
  // Of one point of a patch: if the bodies' centers would come nearer by more than twice `most` in
  // the step, the point stops these instead, without a lever. Rows with levers let a body turn
  // about its corner, and its center go on through a thin wall in the same step.
  void stopCenters(const ContactPoint& source, double most, btManifoldPoint& point) const;
  // Makes a written point a bare row that moves the bodies' centers apart at `speed` [m/s] or,
  // where the depth is negative, lets the gap close.
  void moveApart(const ContactPoint& source, double speed, btManifoldPoint& point) const;

 private:
  double wayOf(const ContactPoint& source) const;  // by which a point closes in the step [m]
  void moveToCenters(btManifoldPoint& point) const;

  const PairSides& sides_;
  double step_;
  Vec3 pull_;  // gravity of A over that of B [m/s^2]
};

// How fast the bodies approach each other at a point [m/s].
double closingOf(const ContactPoint& source, const PairSides& sides);

// The speed after an impact at which bodies met with the speed `closing` [m/s]. `depth` [m]: where
// the step begins, negative before the touch; `pull` [m/s^2] in the direction of closing. 0 where
// the bodies are too slow to be above the touch at the end of the step.
double bounceSpeed(double restitution, double closing, double depth, double pull, double step);

}  // namespace cloudcontact
