// What a pair's motion within the step changes of its contact. closesLightly(): faces that are
// about to meet. The rest: pairs that turn while they slide. A solver's row is a line over the
// step, along the normal at its beginning. But the normal turns with a body while the other moves
// along it, and the gap closes or opens by more than the row tells. Each next query sees that, but
// no row's damping does. So such a pair gets the contact that it has at the step's end if it moves
// on as it does, brought back to its beginning (Touch).
#pragma once

#include "bullet/pair_query.h"

namespace cloudcontact {

// Where a pair turns, and what presses it there.
struct TurningPlace {
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
  double depth = 0, push = 0;  // [m, N]

  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(position, normal, depth, push);
  }
};

// Whether a pair that touches turns so far within a step of `step` seconds that its contact,
// `found` now, is better looked up at the step's end. Not what rolls, bounces, meets at a speed, or
// is deep in each other.
bool turnsWithin(double step, const PairQuery& query, const ContactResult& found,
                 const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);

// Whether bodies that touch lightly close by so much within the step that what has not touched yet
// may touch as well. `gains`: speed that A gains over B in the step.
bool closesLightly(double step, const Vec3& gains, const PairQuery& query,
                   const ContactResult& found);
// Of a contact that turns: the place where it does most.
TurningPlace turningPlace(double step, const PairQuery& query, const ContactResult& found);
// Whether a pair that turned there in the last step is likely to do so in this one, and to touch at
// its end.
bool goesOnTurning(double step, const PairQuery& query, const TurningPlace& last,
                   const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);

// The step's end as a touch, with `a` and `b` moved to where they are then.
Touch endOf(double step, ContactBody& a, ContactBody& b);

// A pair that is looked up at the step's end: where it was before.
struct Turn {
  Pose poses[2];
  Motion motions[2];
};
// Moves the query's bodies to the step's end and back again.
Turn turnOn(double step, PairQuery& query, std::optional<Touch>& touch);
void turnBack(const Turn& turn, PairQuery& query, std::optional<Touch>& touch);

}  // namespace cloudcontact
