// Energies of a Bullet body and of a contact's spring.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btManifoldPoint.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include "scene/bullet_vectors.h"

namespace cloudcontact::program {

// [J] `inertia` [kg m^2] is about the body's own axes; Bullet keeps the inverses, rounded.
inline double kineticEnergy(const btRigidBody& body, double mass, const Vec3& inertia) {
  const Vec3 v = fromBullet(body.getLinearVelocity());
  const Vec3 w =
      fromBullet(body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity());
  return 0.5 * mass * v.squaredNorm() + 0.5 * inertia.dot(w.cwiseAbs2());
}

// [J] that the point's spring stores at a depth [m]; 0 without a spring, or apart.
inline double springEnergy(const btManifoldPoint& point, double depth) {
  if (!(depth > 0) || !(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING))
    return 0;
  return 0.5 * point.m_combinedContactStiffness1 * depth * depth;
}

}  // namespace cloudcontact::program
