// A simulated hand with a haptic device, in place of hardware in tests and demos: a mass on the
// hand's spring and damper that follows a planned path, pushed by the loop's delayed force.
#pragma once

#include <cloudcontact/base/pose.h>

#include <array>

namespace cloudcontact {

// A hand and the device that it holds, for SimulatedHand.
struct HandSettings {
  double mass = 0.1;       // of the device's handle and the hand [kg]
  double stiffness = 300;  // with which the hand follows its plan [N/m]
  double damping = 5;      // of hand and device [N s/m]
  int delay = 0;           // until a force acts, at most 15 [ticks]
  int substeps = 10;       // integration steps per tick
};

class SimulatedHand {
 public:
  // Throws std::invalid_argument where a setting is not valid.
  SimulatedHand(const HandSettings& settings, const Vec3& place);

  // Moves by `step` seconds toward `plan`, under the loop's `force` [N].
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
