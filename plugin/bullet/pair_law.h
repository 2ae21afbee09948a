// Which k and c a pair of collision objects gets.
#pragma once

#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/law/automatic_spring.h>

class btCollisionObject;
struct btCollisionObjectWrapper;

namespace cloudcontact {

// The law of one pair for one step.
struct PairLaw {
  Law shared = KelvinVoigt{};  // ContactSettings::law: KelvinVoigt, Foundation or Rigid
  // If no body states a stiffness. The points' stiffnesses are then their shares of this spring.
  std::optional<AutomaticSpring> automatic;
  // A law with a memory, from the settings or a shape, or null; the points share it likewise.
  const Law* remembering = nullptr;
};

// A query may come before the world's first step, which is when Bullet learns the step's length.
inline double knownStep(double step) {
  return step > 0 ? step : 1.0 / 60;
}

// The settings' law, else one body's own law, else the bodies' springs in series, else an automatic
// spring. Rigid if neither body can move: there is nothing to push, but queries still want the
// points. Throws std::runtime_error if both bodies state laws that cannot be put in series.
PairLaw lawOf(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b, double voxel, double step);

// Foundation{}: stiffness and damping come from the bodies (CloudContactSettings::law).
bool takesBodiesSprings(const Law& law);

// 1/kg; 0 for what no contact moves.
double inverseMass(const btCollisionObject& object);

}  // namespace cloudcontact
