// What a step adds to a pair's points in place of their springs: a list of named adjustments, each
// a pure function of a point and its step. A later one goes over an earlier.
//
// Bounces: where a restitution is stated and no damping. A stiff spring is over within a step, so
// no damping gives it a stated restitution. A point that meets faster than Bullet's threshold
// becomes a bare row for which Bullet's solver finds the speed after the impact, and stays one,
// without a push, until it stops leaving; then the law's spring goes on. A point acts in the step
// in which the surfaces would touch, on either side of the touch: the speed after it is that from
// which the body passes the touch at the right speed, in Bullet's steps. Of the two steps that end
// and begin beside the touch it is the nearer one, if the bodies hardly sink in until then: else
// each bounce would come up to two steps early, and a series of them would end too soon.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <limits>
#include <optional>

#include "bullet/pair_law.h"

namespace cloudcontact {

// Of a pair's step.
struct WriteSettings {
  bool rigid = false;  // no spring: bare contact rows
  double step = 0;     // [s]
  // The points' stiffnesses are their shares of this spring. Empty: they are in [N/m].
  std::optional<AutomaticSpring> automatic;
  // Or their shares of this row (PairMemory).
  std::optional<KelvinVoigt> shared;
  // [m] Of a patch that bounces, points that miss the touch by less in this step bounce, too: which
  // of a face's points touch first is noise below that, and those alone would turn the body.
  double together = 0;
  // [m] What bounces may be that deep before it does.
  double sinks = 0;
  // [m] Of a swept pair: points that would close by more in the step are stopped at the touch by
  // bare rows, since a spring lets a fast body through a thin wall. Infinite: none.
  double stopsFrom = std::numeric_limits<double>::infinity();
  // Of a pair that is moved apart (Leaving): how fast [m/s]. 0: none.
  double leavingSpeed = 0;
};

// A point in its step.
struct StepPoint {
  const ContactPoint& source;
  const PairSides& sides;
  const WriteSettings& settings;
  Vec3 pull = Vec3::Zero();                 // gravity of A over that of B [m/s^2]
  double late = 0;                          // [m] WriteSettings::together, where its patch bounces
  bool waits = false;                       // the pair bounces in the next step
  bool first = false;                       // of its patch
  const btManifoldPoint* before = nullptr;  // last step's point, or null
  double restitution = 0;                   // the pair's, as Bullet combines it, or a callback's

  double closing() const;  // how fast the bodies approach each other there [m/s]
  double way() const;      // by which it closes in the step [m]
  bool touches() const { return source.depth + way() > 0; }  // within the step
  bool touchesLate() const;  // nearer to the step's end, and is hardly deep there
};

// A row without a spring.
struct BareRow {
  double gap = 0;          // [m] that may close; negative with `opens`
  double restitution = 0;  // Bullet's
  bool opens = false;      // the gap opens within the step
  bool atCenters = false;  // of the bodies, without a lever
  bool slips = false;      // without friction
};

// Gives a written point the rows of all adjustments that it needs, in their order.
void adjust(const StepPoint& point, btManifoldPoint& row);

// The speed after an impact at which bodies met with the speed `closing` [m/s]. `depth` [m]: where
// the step begins, negative before the touch; `pull` [m/s^2] in the direction of closing. 0 where
// the bodies are too slow to be above the touch at the end of the step.
double bounceSpeed(double restitution, double closing, double depth, double pull, double step);

}  // namespace cloudcontact
