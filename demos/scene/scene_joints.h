// The joints of a scene as Bullet's constraints.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>

#include "scene/scene.h"

namespace cloudcontact::program {

// `inParent`, `inChild`: the joint's frame in the frames of the two bodies, z along its axis.
std::unique_ptr<btTypedConstraint> makeJoint(const SceneJoint& joint, btRigidBody& parent,
                                             btRigidBody& child, const btTransform& inParent,
                                             const btTransform& inChild);

// Keeps a joint of `body` in its place after the body's own frame has moved, by the inverse of
// `back`. Does nothing if the joint is not one of the body's.
void moveJoint(btTypedConstraint& joint, const btRigidBody& body, const btTransform& back);

}  // namespace cloudcontact::program
