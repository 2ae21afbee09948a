// Fixed, revolute and prismatic joints.
#include "scene/scene_joints.h"

#include <algorithm>

namespace cloudcontact::program {

namespace {

bool hasDynamics(const SceneJoint& joint) {
  return joint.spring > 0 || joint.damping > 0 || joint.friction > 0;
}

// A place on the joint as this constraint counts it: angles are those of the first body in the
// second, places those of the second in the first.
double countedOf(const SceneJoint& joint, double place) {
  return joint.kind == SceneJoint::Kind::Revolute ? -place : place;
}

// The axis moves between its limits; a missing one is as far off as the axis goes.
void limit(btGeneric6DofSpring2Constraint& six, int axis, const SceneJoint& joint) {
  if (!joint.lower && !joint.upper) return six.setLimit(axis, 1, -1);  // lower above upper: free
  const double far = joint.kind == SceneJoint::Kind::Revolute ? 3.14 : 1e6;
  const double one = countedOf(joint, joint.lower.value_or(-far)),
               other = countedOf(joint, joint.upper.value_or(far));
  six.setLimit(axis, btScalar(std::min(one, other)), btScalar(std::max(one, other)));
}

// Slides along the frame's z, or turns about it. Damping beyond what stops the bodies in a step is
// cut to that, for Bullet applies the damping of the step's start.
std::unique_ptr<btTypedConstraint> sixOf(const SceneJoint& joint, btRigidBody& parent,
                                         btRigidBody& child, const btTransform& inParent,
                                         const btTransform& inChild) {
  const int axis = joint.kind == SceneJoint::Kind::Revolute ? 5 : 2;
  auto six = std::make_unique<btGeneric6DofSpring2Constraint>(parent, child, inParent, inChild);
  for (int i = 0; i < 6; ++i) six->setLimit(i, 0, 0);
  limit(*six, axis, joint);
  if (joint.spring > 0 || joint.damping > 0) {
    six->enableSpring(axis, true);
    six->setStiffness(axis, btScalar(joint.spring), false);
    six->setDamping(axis, btScalar(joint.damping), true);
    six->setEquilibriumPoint(axis, btScalar(countedOf(joint, joint.rest)));
  }
  if (joint.friction > 0) {
    six->enableMotor(axis, true);
    six->setTargetVelocity(axis, 0);
    six->setMaxMotorForce(axis, btScalar(joint.friction));
  }
  return six;
}

}  // namespace

std::unique_ptr<btTypedConstraint> makeJoint(const SceneJoint& joint, btRigidBody& parent,
                                             btRigidBody& child, const btTransform& inParent,
                                             const btTransform& inChild) {
  if (joint.kind == SceneJoint::Kind::Fixed)
    return std::make_unique<btFixedConstraint>(parent, child, inParent, inChild);
  if (joint.kind == SceneJoint::Kind::Prismatic || hasDynamics(joint))
    return sixOf(joint, parent, child, inParent, inChild);
  auto hinge = std::make_unique<btHingeConstraint>(parent, child, inParent, inChild, true);
  constexpr double kTurn = 3.14;  // a missing limit: as far as a hinge goes
  if (joint.lower || joint.upper)
    hinge->setLimit(btScalar(joint.lower.value_or(-kTurn)), btScalar(joint.upper.value_or(kTurn)));
  return hinge;
}

void moveJoint(btTypedConstraint& joint, const btRigidBody& body, const btTransform& back) {
  const bool isA = &joint.getRigidBodyA() == &body, isB = &joint.getRigidBodyB() == &body;
  if (!isA && !isB) return;
  const auto move = [&](auto& constraint, const btTransform& a, const btTransform& b) {
    constraint.setFrames(isA ? back * a : a, isA ? b : back * b);
  };
  if (auto* hinge = dynamic_cast<btHingeConstraint*>(&joint))
    move(*hinge, btTransform(hinge->getAFrame()), btTransform(hinge->getBFrame()));
  else if (auto* six = dynamic_cast<btGeneric6DofSpring2Constraint*>(&joint))  // fixed, too
    move(*six, btTransform(six->getFrameOffsetA()), btTransform(six->getFrameOffsetB()));
}

}  // namespace cloudcontact::program
