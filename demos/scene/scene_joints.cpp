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

// Bullet pulls with the spring of the step's start, which gains energy where a step is not short
// beside the swing, and explodes where it is long. This joint pulls with the spring of the step's
// middle and the damper of its end: with the row's velocity u, stiffness k, damping c, way e out of
// rest, and step h, the impulse is h (k (e - h u / 2) - c u). The spring's work is then the energy
// that it loses, in steps of any length, and bodies lose m (v' - v)^2 / 2 a step, which is Bullet's
// own. The spring of the step's end, as of contacts, would lose twice that. It needs
// NewtonSolver.
class SpringJoint : public btGeneric6DofSpring2Constraint {
 public:
  SpringJoint(const SceneJoint& joint, btRigidBody& parent, btRigidBody& child,
              const btTransform& inParent, const btTransform& inChild)
      : btGeneric6DofSpring2Constraint(parent, child, inParent, inChild),
        turns_(joint.kind == SceneJoint::Kind::Revolute),
        stiffness_(joint.spring),
        damping_(joint.damping),
        rest_(countedOf(joint, joint.rest)) {
    enableSpring(turns_ ? 5 : 2, true);
  }

  void getInfo1(btConstraintInfo1* info) override {
    btGeneric6DofSpring2Constraint::getInfo1(info);
    rows_ = info->m_numConstraintRows;
  }

  // The spring's row is the last of its axis, and angles come before places.
  void getInfo2(btConstraintInfo2* info) override {
    btGeneric6DofSpring2Constraint::getInfo2(info);
    const int row = turns_ ? rows_ - 4 : rows_ - 1, at = row * info->rowskip;
    const double h = 1 / double(info->fps), per = 0.5 * h * stiffness_ + damping_;
    const double away = double(turns_ ? getAngle(2) : getRelativePivotPosition(2)) - rest_;
    info->m_constraintError[at] = btScalar((turns_ ? -away : away) * stiffness_ / per);
    info->cfm[at] = btScalar(1 / (h * per) / inverseMassOf(*info, at));
    info->m_lowerLimit[at] = -SIMD_INFINITY;
    info->m_upperLimit[at] = SIMD_INFINITY;
  }

 private:
  // Of the bodies along a row.
  double inverseMassOf(const btConstraintInfo2& info, int at) const {
    const auto vector = [at](const btScalar* v) { return btVector3(v[at], v[at + 1], v[at + 2]); };
    const auto of = [&](const btRigidBody& body, const btVector3& line, const btVector3& turn) {
      return double(line.length2() * body.getInvMass() +
                    turn.dot(body.getInvInertiaTensorWorld() * turn));
    };
    return of(m_rbA, vector(info.m_J1linearAxis), vector(info.m_J1angularAxis)) +
           of(m_rbB, vector(info.m_J2linearAxis), vector(info.m_J2angularAxis));
  }

  bool turns_;
  double stiffness_, damping_, rest_;
  int rows_ = 0;
};

// Slides along the frame's z, or turns about it.
std::unique_ptr<btTypedConstraint> sixOf(const SceneJoint& joint, btRigidBody& parent,
                                         btRigidBody& child, const btTransform& inParent,
                                         const btTransform& inChild) {
  const int axis = joint.kind == SceneJoint::Kind::Revolute ? 5 : 2;
  const bool springs = joint.spring > 0 || joint.damping > 0;
  std::unique_ptr<btGeneric6DofSpring2Constraint> six;
  if (springs)
    six = std::make_unique<SpringJoint>(joint, parent, child, inParent, inChild);
  else
    six = std::make_unique<btGeneric6DofSpring2Constraint>(parent, child, inParent, inChild);
  for (int i = 0; i < 6; ++i) six->setLimit(i, 0, 0);
  limit(*six, axis, joint);
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
