// WorldHand: the hand of a HapticLoop in a running Bullet world. It pushes a rigid body through its
// tool and is pushed back: what the hand gives the body receives, so momentum is kept.
#pragma once

#include <cloudcontact/workpiece/haptic_loop.h>

#include <memory>

class btRigidBody;

namespace cloudcontact {

// The loop runs in the frame of the body, which may move and turn. Its tool has no mass.
class WorldHand {
 public:
  // `matter`: the body's base vectors, which the loop cuts if it has a cutter; `place`: their frame
  // in the body's frame (CuttableBody: its frame's inverse changes with each cut, so give
  // moveMatter() the new one). Both must outlive the hand. Throws as HapticLoop does.
  WorldHand(btRigidBody& body, BaseVectorField& matter, const Pose& place,
            const HapticSettings& settings);
  ~WorldHand();
  WorldHand(const WorldHand&) = delete;
  WorldHand& operator=(const WorldHand&) = delete;

  void moveMatter(const Pose& place);

  // Call before each step of the world, which is as long as HapticSettings::step. Pose and velocity
  // of the hand in the world; so is the result. Pushes the body with the reaction for one step.
  const HapticOutput& tick(const HapticInput& hand);

  Vec3 given() const;              // impulse that the body has received from the hand [N s]
  const HapticLoop& loop() const;  // in the frame of the matter

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
