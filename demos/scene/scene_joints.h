// The joints of a scene as rows of Bullet's solver.
//
// One class has all kinds. A kind is a count of directions in which the child's frame stays with
// the parent's: of the three ways to shift and the three to turn. Each is a row that takes its
// error back as Bullet's own joints do. Then come, for each axis that moves, its limits and what
// pushes it: spring, friction and motor are one law (JointMotor), each a row.
//
// Rows push both bodies at one point, the child's origin, so no joint makes angular momentum. A
// limit is a row before it is reached, too, and lets the axis come to it and no further; Bullet's
// own joints pass it first and are pushed back.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>

#include "scene/scene_joint.h"

namespace cloudcontact::program {

class JointConstraint : public btTypedConstraint {
 public:
  // `inParent`, `inChild`: the joint's frame in the frames of the two bodies, z along its axis and,
  // of a universal joint, x along its second one.
  JointConstraint(const SceneJoint& joint, btRigidBody& parent, btRigidBody& child,
                  const btTransform& inParent, const btTransform& inChild);

  AxisState axis(std::size_t i) const;
  // In the latest step.
  JointState state() const;
  const JointMotor& motor(std::size_t i) const { return motors_[i]; }
  void setMotor(std::size_t i, const JointMotor& motor) { motors_[i] = motor; }
  // Of the latest step, to be kept.
  JointLoad load() const;
  void setLoad(const JointLoad& load);
  // Places with their turns, which poses do not tell.
  const std::array<double, 2>& places() const { return places_; }
  void setPlaces(const std::array<double, 2>& places) { places_ = places; }
  // Keeps the joint in its place after the frame of `body` has moved, by the inverse of `back`.
  void moveFrame(const btRigidBody& body, const btTransform& back);
  // A fixed joint's frame need not be where the scene puts it: that place, in the child.
  void setOrigin(const btVector3& inChild) { origin_ = inChild; }

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;
  // Bullet's parameters of constraints; it has none of them.
  void setParam(int, btScalar, int) override {}
  btScalar getParam(int, int) const override { return 0; }

 private:
  struct Frames;
  class Rows;
  Frames frames() const;
  double placeOf(std::size_t i, const Frames& at) const;
  void holdShifts(const Frames& at, Rows& rows) const;
  void holdTurns(const Frames& at, Rows& rows) const;
  void push(std::size_t i, const Frames& at, Rows& rows) const;

  SceneJoint joint_;
  btTransform inParent_, inChild_;
  btVector3 origin_;
  std::array<double, 2> places_ = {};
  std::array<JointMotor, 2> motors_;
  btJointFeedback feedback_ = {};
  btVector3 arm_{0, 0, 0};  // from the child's center of mass to the joint, in the latest step
};

}  // namespace cloudcontact::program
