// Velocities and accelerations of rigid bodies and of links.
#include "bullet/object_motion.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <cmath>

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

struct Velocity {
  btVector3 angular, linear;  // [rad/s], [m/s] of the center of mass
};

// In the link's own frame: its parent's, carried over to its center of mass, and its joint's. Walks
// to the base and back. btMultiBody::compTreeLinkVelocities() does so for all links at once, into
// arrays of the caller's.
Velocity localVelocity(const btMultiBody& body, int link) {
  if (link < 0) {
    const btQuaternion& toBase = body.getWorldToBaseRot();
    return {quatRotate(toBase, body.getBaseOmega()), quatRotate(toBase, body.getBaseVel())};
  }
  const btMultibodyLink& joint = body.getLink(link);
  const Velocity parent = localVelocity(body, joint.m_parent);
  Velocity own;
  own.angular = quatRotate(joint.m_cachedRotParentToThis, parent.angular);
  own.linear = quatRotate(joint.m_cachedRotParentToThis, parent.linear) +
               own.angular.cross(joint.m_cachedRVector);
  const btScalar* const speeds = body.getJointVelMultiDof(link);
  for (int axis = 0; axis < joint.m_dofCount; ++axis) {
    own.angular += speeds[axis] * joint.getAxisTop(axis);
    own.linear += speeds[axis] * joint.getAxisBottom(axis);
  }
  return own;
}

Motion linkMotion(const btMultiBodyLinkCollider& collider, const Vec3& center) {
  const Velocity local = localVelocity(*collider.m_multiBody, collider.m_link);
  const btMatrix3x3& toWorld = collider.getWorldTransform().getBasis();
  return {toVec3(toWorld * local.linear), toVec3(toWorld * local.angular), center};
}

Vec3 fallOf(const btMultiBody& body) {
  if (body.hasFixedBase()) return Vec3::Zero();
  Vec3 force = toVec3(body.getBaseForce());
  double mass = body.getBaseMass();
  for (int link = 0; link < body.getNumLinks(); ++link) {
    force += toVec3(body.getLinkForce(link));
    mass += body.getLink(link).m_mass;
  }
  return mass > 0 ? Vec3(force / mass) : Vec3::Zero();
}

}  // namespace

Motion motionOf(const btCollisionObject& object) {
  const Vec3 center = toVec3(object.getWorldTransform().getOrigin());
  if (const auto* rigid = btRigidBody::upcast(&object))
    return {toVec3(rigid->getLinearVelocity()), toVec3(rigid->getAngularVelocity()), center};
  if (const auto* link = btMultiBodyLinkCollider::upcast(&object)) return linkMotion(*link, center);
  return {Vec3::Zero(), Vec3::Zero(), center};
}

Vec3 accelerationOf(const btCollisionObject& object) {
  if (object.isStaticOrKinematicObject()) return Vec3::Zero();
  if (const auto* rigid = btRigidBody::upcast(&object))
    return toVec3(rigid->getTotalForce()) * double(rigid->getInvMass());
  if (const auto* link = btMultiBodyLinkCollider::upcast(&object))
    return fallOf(*link->m_multiBody);
  return Vec3::Zero();
}

double inverseInertiaOf(const btCollisionObject& object) {
  if (object.isStaticOrKinematicObject()) return 0;
  const auto mean = [](const btVector3& v) {
    const double of = double(v.x() + v.y() + v.z()) / 3;
    return of > 0 && std::isfinite(of) ? of : 0;
  };
  if (const auto* rigid = btRigidBody::upcast(&object))
    return mean(rigid->getInvInertiaDiagLocal() * rigid->getAngularFactor().absolute());
  const auto* link = btMultiBodyLinkCollider::upcast(&object);
  if (!link) return 0;
  const btMultiBody& body = *link->m_multiBody;
  const bool isBase = link->m_link < 0;
  if (isBase && body.hasFixedBase()) return 0;
  const double inertia =
      mean(isBase ? body.getBaseInertia() : body.getLink(link->m_link).m_inertiaLocal);
  return inertia > 0 ? 1 / inertia : 0;
}

Vec3 gravityOf(const btCollisionObject& object) {
  const auto* rigid = btRigidBody::upcast(&object);
  if (!rigid) return accelerationOf(object);
  return rigid->getInvMass() > 0 ? toVec3(rigid->getGravity()) : Vec3::Zero();
}

}  // namespace cloudcontact
