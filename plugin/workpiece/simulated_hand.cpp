// The hand's motion, by semi-implicit Euler in substeps.
#include <cloudcontact/workpiece/simulated_hand.h>

#include <cmath>
#include <stdexcept>

namespace cloudcontact {

SimulatedHand::SimulatedHand(const HandSettings& settings, const Vec3& place)
    : settings_(settings), position_(place) {
  if (!(settings.mass > 0) || !(settings.stiffness >= 0) || !(settings.damping >= 0) ||
      !std::isfinite(settings.mass + settings.stiffness + settings.damping))
    throw std::invalid_argument(
        "HandSettings: the mass must be positive, stiffness and damping zero or more, all finite");
  if (settings.delay < 0 || settings.delay >= kDelays)
    throw std::invalid_argument("HandSettings: the delay must be 0 to 15 ticks");
  if (settings.substeps < 1)
    throw std::invalid_argument("HandSettings: at least one substep a tick");
  forces_.fill(Vec3::Zero());
}

void SimulatedHand::advance(const Vec3& plan, const Vec3& force, double step) {
  forces_[static_cast<std::size_t>(now_)] = force;
  const int past = (now_ + kDelays - settings_.delay) % kDelays;
  const Vec3& felt = forces_[static_cast<std::size_t>(past)];
  now_ = (now_ + 1) % kDelays;
  const double h = step / settings_.substeps;
  for (int k = 0; k < settings_.substeps; ++k) {
    const Vec3 all =
        settings_.stiffness * (plan - position_) - settings_.damping * velocity_ + felt;
    velocity_ += h / settings_.mass * all;
    position_ += h * velocity_;
  }
}

}  // namespace cloudcontact
