// The energy that a haptic loop has taken from the hand, and a bound on its force that keeps it
// from falling below zero (passivity observer and controller: Hannaford and Ryu, IEEE Trans.
// Robotics and Automation 18, 2002).
#pragma once

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// A force acts from one tick to the next, so its work over the hand's motion is exact.
class EnergyWatch {
 public:
  // The hand has come to `hand` under the force of the last allowed() [N].
  void observe(const Vec3& hand);
  // The force on the hand until the next tick: `force` as it is, unless the loop would then have
  // given the hand more than it got, if the hand moves on as in the last tick. Then the part along
  // that motion is what the energy left allows, at most `most` [N] against it.
  Vec3 allowed(const Vec3& force, double most);

  double energy() const { return energy_; }  // net work of the hand so far [J]
  double least() const { return least_; }    // its minimum [J]

 private:
  double energy_ = 0, least_ = 0;
  Vec3 force_ = Vec3::Zero(), hand_ = Vec3::Zero(), motion_ = Vec3::Zero();
  bool started_ = false;
};

}  // namespace cloudcontact
