// Fixed, revolute and prismatic joints.
#include "scene/scene_joints.h"

namespace cloudcontact::program {

namespace {

// Slides along the frame's z, between its limits, on its spring. Bullet measures the place of the
// second body's frame in the first's.
std::unique_ptr<btTypedConstraint> sliderOf(const SceneJoint& joint, btRigidBody& parent,
                                            btRigidBody& child, const btTransform& inParent,
                                            const btTransform& inChild) {
  constexpr int kAxis = 2;
  auto slider = std::make_unique<btGeneric6DofSpring2Constraint>(parent, child, inParent, inChild);
  slider->setAngularLowerLimit(btVector3(0, 0, 0));
  slider->setAngularUpperLimit(btVector3(0, 0, 0));
  const bool limited = joint.lower && joint.upper;
  // Lower above upper: free.
  slider->setLinearLowerLimit(btVector3(0, 0, limited ? btScalar(*joint.lower) : btScalar(1)));
  slider->setLinearUpperLimit(btVector3(0, 0, limited ? btScalar(*joint.upper) : btScalar(-1)));
  if (joint.spring > 0) {
    slider->enableSpring(kAxis, true);
    slider->setStiffness(kAxis, btScalar(joint.spring), false);
    slider->setDamping(kAxis, btScalar(joint.damping), false);
    slider->setEquilibriumPoint(kAxis, btScalar(joint.rest));
  }
  return slider;
}

}  // namespace

std::unique_ptr<btTypedConstraint> makeJoint(const SceneJoint& joint, btRigidBody& parent,
                                             btRigidBody& child, const btTransform& inParent,
                                             const btTransform& inChild) {
  if (joint.kind == SceneJoint::Kind::Fixed)
    return std::make_unique<btFixedConstraint>(parent, child, inParent, inChild);
  if (joint.kind == SceneJoint::Kind::Prismatic)
    return sliderOf(joint, parent, child, inParent, inChild);
  auto hinge = std::make_unique<btHingeConstraint>(parent, child, inParent, inChild, true);
  if (joint.lower && joint.upper) hinge->setLimit(btScalar(*joint.lower), btScalar(*joint.upper));
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
