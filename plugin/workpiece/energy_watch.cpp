// Nothing is damped while the energy is positive: the controller only takes what would be missing.
#include <cloudcontact/workpiece/energy_watch.h>

#include <algorithm>

namespace cloudcontact {

void EnergyWatch::observe(const Vec3& hand) {
  motion_ = started_ ? Vec3(hand - hand_) : Vec3::Zero();
  energy_ -= force_.dot(motion_);
  least_ = std::min(least_, energy_);
  hand_ = hand;
  force_.setZero();
  started_ = true;
}

Vec3 EnergyWatch::allowed(const Vec3& force, double most) {
  force_ = force;
  const double way = motion_.norm(), work = force.dot(motion_);
  if (way > 0 && work > 0 && work > energy_) {
    const double along = std::max(energy_ / way, -most);
    force_ += (along - work / way) / way * motion_;
  }
  return force_;
}

}  // namespace cloudcontact
