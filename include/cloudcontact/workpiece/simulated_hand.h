// A hand and a haptic device by numbers: stands in for hardware, for tests and demos. A mass on
// the hand's spring and damper, drawn along a planned path and pushed by the loop's force, which
// arrives late.
#pragma once

#include <cloudcontact/base/pose.h>

#include <array>

namespace cloudcontact {

struct HandSettings {
  double mass = 0.1;       // [kg] of the device's handle and the hand that moves with it
  double stiffness = 300;  // [N/m] with which the hand follows its plan
  double damping = 5;      // [N s/m] of hand and device
  int delay = 0;           // [ticks] until a force acts, 15 at most
  int substeps = 10;       // of a tick: the device moves on while the loop computes
};

class SimulatedHand {
 public:
  // Throws std::invalid_argument where a setting is not usable.
  SimulatedHand(const HandSettings& settings, const Vec3& place);

  // Moves on by `step` seconds, drawn to `plan`, with `force` told by the loop.
  void advance(const Vec3& plan, const Vec3& force, double step);

  const Vec3& position() const { return position_; }
  const Vec3& velocity() const { return velocity_; }

 private:
  static constexpr int kDelays = 16;
  HandSettings settings_;
  Vec3 position_, velocity_ = Vec3::Zero();
  std::array<Vec3, kDelays> forces_;
  int now_ = 0;
};

}  // namespace cloudcontact
