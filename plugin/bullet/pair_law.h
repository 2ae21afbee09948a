// Which k and c a pair of collision objects gets.
#pragma once

#include <cloudcontact/bullet/registration.h>

class btCollisionObject;
struct btCollisionObjectWrapper;

namespace cloudcontact {

// The law of one pair for one step.
struct PairLaw {
  LawForm form = LawForm::Paper;
  Material pair;
  // The pair states no stiffness per area: its contacts share out `pair` [N/m] as their areas are.
  bool shareOut = false;
};

// The settings' pair, else the bodies' materials in series, else as hard as `step` [s] allows.
// Rigid where neither body can move: there is nothing to push, but queries still want the points.
PairLaw lawOf(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b, double step);

// 1/kg; 0 for what no contact moves.
double inverseMass(const btCollisionObject& object);

}  // namespace cloudcontact
