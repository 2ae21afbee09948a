// Which k and c a pair of collision objects gets.
#pragma once

#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/law/automatic_spring.h>

class btCollisionObject;
struct btCollisionObjectWrapper;

namespace cloudcontact {

// The law of one pair for one step.
struct PairLaw {
  LawForm form = LawForm::Paper;
  Material pair;
  // Where nobody states a stiffness: the contacts share this out as their parts of `pair` are.
  std::optional<AutomaticSpring> automatic;
  // Another law, which the contacts share out likewise; the settings' or a shape's own, or null.
  const ViscoelasticLaw* viscoelastic = nullptr;
};

// A query may come before the world's first step, which is when Bullet learns the step's length.
inline double knownStep(double step) {
  return step > 0 ? step : 1.0 / 60;
}

// The settings' law or pair, else one body's own law, else the bodies' materials in series, else an
// automatic spring. Rigid where neither body can move: there is nothing to push, but queries still
// want the points. Throws std::runtime_error where both bodies state a law that cannot be put in
// series.
PairLaw lawOf(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b, double voxel, double step);

// 1/kg; 0 for what no contact moves.
double inverseMass(const btCollisionObject& object);

}  // namespace cloudcontact
