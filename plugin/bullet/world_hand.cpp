// A tick sees the hand from the body, as if that were at rest; the body gets the reaction as an
// impulse at the place of contact.
#include <cloudcontact/bullet/world_hand.h>

#include "bullet/convert.h"
#include "bullet/object_motion.h"

namespace cloudcontact {

struct WorldHand::State {
  btRigidBody& body;
  Pose place;  // of the matter in the body
  HapticLoop loop;
  double step;
  HapticOutput output;
  Vec3 given = Vec3::Zero();

  Pose matter() const { return toPose(body.getWorldTransform()) * place; }
};

WorldHand::WorldHand(btRigidBody& body, BaseVectorField& matter, const Pose& place,
                     const HapticSettings& settings)
    : state_(new State{body, place, HapticLoop(matter, Pose{}, settings), settings.step, {}, {}}) {
  state_->given.setZero();
}
WorldHand::~WorldHand() = default;

void WorldHand::moveMatter(const Pose& place) {
  state_->place = place;
}

const HapticOutput& WorldHand::tick(const HapticInput& hand) {
  State& s = *state_;
  const Pose matter = s.matter();
  const Motion motion = motionOf(s.body);
  HapticInput seen;
  seen.hand = matter.inverse() * hand.hand;
  seen.velocity = matter.orientation.conjugate() * (hand.velocity - motion.at(hand.hand.position));
  s.output = s.loop.tick(seen);
  HapticOutput& out = s.output;
  out.tool = matter * out.tool;
  out.onHand.force = matter.orientation * out.onHand.force;
  out.onHand.torque = matter.orientation * out.onHand.torque;
  if (out.onHand.force.isZero()) return out;
  const Collision& collision = s.loop.collision();
  const Vec3 at = collision.empty() ? out.tool.position : matter.toWorld(collision.center);
  const Vec3 impulse = -s.step * out.onHand.force;
  s.body.applyImpulse(toBullet(impulse), toBullet(Vec3(at - motion.center)));
  s.body.activate();
  s.given += impulse;
  return out;
}

Vec3 WorldHand::given() const {
  return state_->given;
}

const HapticLoop& WorldHand::loop() const {
  return state_->loop;
}

}  // namespace cloudcontact
