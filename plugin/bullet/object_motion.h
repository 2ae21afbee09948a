// The motion of a Bullet object.
#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include "bullet/convert.h"

namespace cloudcontact {

// As it is now: without this step's gravity, which Bullet adds in its solver. An object that is no
// rigid body rests.
inline Motion motionOf(const btCollisionObject& object) {
  const Vec3 center = toVec3(object.getWorldTransform().getOrigin());
  if (const auto* rigid = btRigidBody::upcast(&object))
    return {toVec3(rigid->getLinearVelocity()), toVec3(rigid->getAngularVelocity()), center};
  return {Vec3::Zero(), Vec3::Zero(), center};
}

// By the forces that wait for the step, gravity among them [m/s^2].
inline Vec3 accelerationOf(const btCollisionObject& object) {
  const auto* rigid = btRigidBody::upcast(&object);
  if (!rigid || object.isStaticOrKinematicObject()) return Vec3::Zero();
  return toVec3(rigid->getTotalForce()) * double(rigid->getInvMass());
}

}  // namespace cloudcontact
