// Loads, velocities and places that a program gives bodies of a running world (World::setLoad,
// setMotion, place).
#include <stdexcept>

#include "scene/bullet_vectors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {
namespace {

void require(const World& world, std::size_t body, bool finite, const char* what) {
  if (!world.isPullable(body))
    throw std::invalid_argument("body '" + world.name(body) + "': its " + what +
                                " cannot be set; it is static, driven, soft or cut away");
  if (!finite)
    throw std::invalid_argument("body '" + world.name(body) + "': its " + what + " must be finite");
}

// Bodies that touch it may have lost what they stand on.
void wakeThoseAt(const btRigidBody& body, const btDispatcher& dispatcher) {
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold =
        *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
    if (manifold.getBody0() == &body) manifold.getBody1()->activate();
    if (manifold.getBody1() == &body) manifold.getBody0()->activate();
  }
}

}  // namespace

// At the start of the step, as gravity is.
void World::State::load() {
  for (const Body& body : bodies) {
    if (body.load.force.isZero(0) && body.load.torque.isZero(0)) continue;
    if (body.cut.gone) continue;
    body.rigid->activate(true);
    body.rigid->applyCentralForce(toBullet(body.load.force));
    body.rigid->applyTorque(toBullet(body.load.torque));
  }
}

void World::setLoad(std::size_t body, const BodyLoad& load) {
  require(*this, body, load.force.allFinite() && load.torque.allFinite(), "load");
  state_->bodies[body].load = load;
}

const BodyLoad& World::load(std::size_t body) const {
  return state_->bodies[body].load;
}

void World::setMotion(std::size_t body, const Vec3& velocity, const Vec3& angularVelocity) {
  require(*this, body, velocity.allFinite() && angularVelocity.allFinite(), "velocity");
  btRigidBody& rigid = *state_->bodies[body].rigid;
  const Vec3 arm = fromBullet(rigid.getCenterOfMassPosition()) - pose(body).position;
  rigid.activate(true);
  rigid.setLinearVelocity(toBullet(Vec3(velocity + angularVelocity.cross(arm))));
  rigid.setAngularVelocity(toBullet(angularVelocity));
}

// Drops the contacts cached for the body: they were found at its old place.
void World::place(std::size_t body, const Pose& pose) {
  require(*this, body, pose.position.allFinite() && pose.orientation.coeffs().allFinite(), "pose");
  const State::Body& moved = state_->bodies[body];
  btRigidBody& rigid = *moved.rigid;
  btDiscreteDynamicsWorld& world = state_->world;
  wakeThoseAt(rigid, *world.getDispatcher());
  rigid.activate(true);
  rigid.setCenterOfMassTransform(toBullet(pose * moved.parts.frame));
  rigid.setInterpolationWorldTransform(rigid.getCenterOfMassTransform());
  world.getPairCache()->cleanProxyFromPairs(rigid.getBroadphaseProxy(), world.getDispatcher());
  world.updateSingleAabb(&rigid);
  state_->poses.clear();
}

}  // namespace cloudcontact::program
