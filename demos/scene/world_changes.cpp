// What a program changes of a running world's bodies (World::change).
#include <stdexcept>

#include "scene/bullet_vectors.h"
#include "scene/running_world.h"
#include "scene/scene_check.h"
#include "scene/world_setup.h"

namespace cloudcontact::program {
namespace {

[[noreturn]] void refuse(const SceneBody& body, const char* what, const char* why) {
  throw std::invalid_argument("body '" + body.name + "': its " + what + " cannot be set; " + why);
}

}  // namespace

const SceneBody& World::described(std::size_t body) const {
  return state_->bodies[body].scene;
}

void World::State::setSpring(Body& body, const SceneBody& like) {
  btRigidBody& rigid = *body.rigid;
  if (like.stiffness)
    rigid.setContactStiffnessAndDamping(btScalar(*like.stiffness),
                                        btScalar(like.damping.value_or(0)));
  else
    rigid.setCollisionFlags(rigid.getCollisionFlags() &
                            ~btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING);
}

// Bullet has the inertia of the same shape.
void World::State::setMass(Body& body, double mass) {
  BodyParts& parts = body.parts;
  parts.inertia *= mass / parts.mass;
  parts.mass = mass;
  body.rigid->setMassProps(btScalar(mass), toBullet(parts.inertia));
  body.rigid->updateInertiaTensor();
}

void World::change(std::size_t index, const SceneBody& like) {
  State& s = *state_;
  State::Body& body = s.bodies[index];
  validate(like);
  const bool newMass = like.mass && *like.mass != body.parts.mass;
  if (newMass && (!isPullable(index) || body.cuts))
    refuse(like, "mass", "it is static, driven, soft or cut");
  if (like.drive.has_value() != body.scene.drive.has_value())
    refuse(like, "drive", "only of a body that is driven from the start");
  if (like.damping && !like.stiffness) refuse(like, "damping", "it needs a stiffness beside it");
  if (body.soft || body.cut.gone) refuse(like, "surface", "it is soft or cut away");
  s.dispatcher.set(index, surfaceOf(like));
  body.rigid->setRestitution(btScalar(like.restitution.value_or(like.isFree() ? 0 : 1)));
  if (s.solver.newton) s.setSpring(body, like);  // of clouds
  if (newMass) s.setMass(body, *like.mass);
  if (like.drive) {
    body.scene.pose = pose(index);
    body.driveFrom = s.time;
  }
  body.scene.friction = like.friction, body.scene.restitution = like.restitution;
  body.scene.stiffness = like.stiffness, body.scene.damping = like.damping;
  body.scene.mass = like.mass, body.scene.drive = like.drive;
  if (like.isFree()) body.rigid->activate(true);
}

}  // namespace cloudcontact::program
