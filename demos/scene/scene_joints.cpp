// Rows of a joint: what holds, limits and pushes it (scene_joints.h).
#include "scene/scene_joints.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "scene/bullet_vectors.h"

namespace cloudcontact::program {
namespace {

using Kind = SceneJoint::Kind;

// In how many directions of its frame a kind holds the child, from x on.
struct Held {
  int shifts, turns;
};
Held heldBy(Kind kind) {
  switch (kind) {
    case Kind::Fixed:
      return {3, 3};
    case Kind::Revolute:
      return {3, 2};
    case Kind::Prismatic:
      return {2, 3};
    case Kind::Screw:
      return {3, 2};  // along z as it turns
    case Kind::Ball:
      return {3, 0};
    case Kind::Universal:
      return {3, 1};
  }
  return {3, 3};
}

// What pushes an axis beside its limits, in the order of the rows.
std::array<JointMotor, 3> drivesOf(const SceneAxis& axis, const JointMotor& motor) {
  JointMotor own = motor;
  own.most = std::min(own.most, axis.effort);
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const JointMotor brake{.damping = axis.friction > 0 ? kAll : 0, .most = axis.friction};
  return {JointMotor{.position = axis.rest, .stiffness = axis.spring, .damping = axis.damping},
          brake, own};
}

// The angle nearest to `to` that is `angle` but for whole turns.
double nearest(double angle, double to) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return angle + kTurn * std::round((to - angle) / kTurn);
}

constexpr std::pair<Kind, const char*> kNames[] = {
    {Kind::Fixed, "fixed"}, {Kind::Revolute, "revolute"}, {Kind::Prismatic, "prismatic"},
    {Kind::Screw, "screw"}, {Kind::Ball, "ball"},         {Kind::Universal, "universal"}};
}  // namespace

const char* nameOf(Kind kind) {
  return std::find_if(std::begin(kNames), std::end(kNames),
                      [&](const auto& known) { return known.first == kind; })
      ->second;
}

Kind jointKind(const std::string& name) {
  for (const auto& [kind, known] : kNames)
    if (name == known) return kind;
  throw std::invalid_argument(
      "kind: '" + name +
      "' is not known; give fixed, revolute, prismatic, screw, ball or universal");
}

// The joint's frames now: the parent's, and the child's.
struct JointConstraint::Frames {
  btTransform parent, child;
  btVector3 x() const { return parent.getBasis().getColumn(0); }
  btVector3 z() const { return parent.getBasis().getColumn(2); }
  // The axis that a joint's child turns about, or slides along.
  btVector3 line(std::size_t i) const { return i == 0 ? z() : child.getBasis().getColumn(0); }
};

// Writes rows. A row's speed is that of the child as seen from the parent.
class JointConstraint::Rows {
 public:
  Rows(btConstraintInfo2& info, const btRigidBody& parent, const btRigidBody& child,
       const btVector3& point)
      : info_(info),
        parent_(parent),
        child_(child),
        armParent_(point - parent.getCenterOfMassPosition()),
        armChild_(point - child.getCenterOfMassPosition()) {}

  double step() const { return 1 / double(info_.fps); }
  // A shift and a turn that stay 0; `error`: what they are.
  void hold(const btVector3& shift, const btVector3& turn, double error) {
    write(shift, turn, -double(info_.erp) / step() * error, 0, -HUGE_VAL, HUGE_VAL);
  }
  // A place that is to stay above 0 along `side` (1) or below (-1).
  void limit(const btVector3& shift, const btVector3& turn, double place, int side) {
    const bool passed = side * place < 0;
    write(shift, turn, -(passed ? double(info_.erp) : 1.0) / step() * place, 0,
          side > 0 ? 0 : -HUGE_VAL, side > 0 ? HUGE_VAL : 0);
  }
  // With the row's speed u at the step's end, h (f + k (e - h u / 2) + c (v - u)): a row of the
  // softness 1 / (h (h k / 2 + c)). The spring's work is then the energy that it loses, in steps of
  // any length, and bodies lose m (v' - v)^2 / 2 a step, which is Bullet's own. Bullet's springs
  // are those of the step's start, which gain energy, and explode in long steps; those of its end,
  // as contacts are, would lose twice as much.
  void drive(const btVector3& shift, const btVector3& turn, double place, const JointMotor& by) {
    const double h = step(), per = 0.5 * h * by.stiffness + by.damping;
    const double most = h * by.most;
    if (!(per > 0)) {
      const double push = std::clamp(h * by.force, -most, most);
      return write(shift, turn, 0, 0, push, push);
    }
    const double start = by.force + by.stiffness * (by.position - place);
    const double wanted = std::isinf(per) ? by.velocity : (start + by.damping * by.velocity) / per;
    write(shift, turn, wanted, 1 / (h * per), -most, most);
  }

 private:
  // `wanted`: the row's speed; `soft`: what it gives way by a unit of impulse; the impulse's
  // limits.
  void write(const btVector3& shift, const btVector3& turn, double wanted, double soft, double low,
             double high) {
    const btVector3 onParent = armParent_.cross(shift) + turn,
                    onChild = armChild_.cross(shift) + turn;
    const int at = row_++ * info_.rowskip;
    for (int k = 0; k < 3; ++k) {
      info_.m_J1linearAxis[at + k] = -shift[k];
      info_.m_J2linearAxis[at + k] = shift[k];
      info_.m_J1angularAxis[at + k] = -onParent[k];
      info_.m_J2angularAxis[at + k] = onChild[k];
    }
    info_.m_constraintError[at] = btScalar(wanted);
    // Bullet takes it relative to how easily the bodies move along the row.
    const double eases = easeOf(parent_, shift, onParent) + easeOf(child_, shift, onChild);
    info_.cfm[at] = eases > 0 ? btScalar(soft / eases) : 0;
    info_.m_lowerLimit[at] = std::isinf(low) ? -SIMD_INFINITY : btScalar(low);
    info_.m_upperLimit[at] = std::isinf(high) ? SIMD_INFINITY : btScalar(high);
  }
  static double easeOf(const btRigidBody& body, const btVector3& shift, const btVector3& turn) {
    return double(shift.length2() * body.getInvMass() +
                  turn.dot(body.getInvInertiaTensorWorld() * turn));
  }

  btConstraintInfo2& info_;
  const btRigidBody &parent_, &child_;
  btVector3 armParent_, armChild_;
  int row_ = 0;
};

JointConstraint::JointConstraint(const SceneJoint& joint, btRigidBody& parent, btRigidBody& child,
                                 const btTransform& inParent, const btTransform& inChild)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, parent, child),
      joint_(joint),
      inParent_(inParent),
      inChild_(inChild),
      origin_(inChild.getOrigin()) {
  setJointFeedback(&feedback_);
}

JointConstraint::Frames JointConstraint::frames() const {
  return {m_rbA.getCenterOfMassTransform() * inParent_,
          m_rbB.getCenterOfMassTransform() * inChild_};
}

// With the second axis, that of the child's x, across the first, the child is the parent turned
// about z by the first angle and then about its own x by the second.
double JointConstraint::placeOf(std::size_t i, const Frames& at) const {
  const btMatrix3x3 &p = at.parent.getBasis(), &c = at.child.getBasis();
  if (joint_.kind == Kind::Prismatic)
    return double((at.child.getOrigin() - at.parent.getOrigin()).dot(at.z()));
  const btVector3 x = c.getColumn(0), z = p.getColumn(2);
  const double angle =
      i == 0 ? std::atan2(double(x.dot(p.getColumn(1))), double(x.dot(p.getColumn(0))))
             : std::atan2(double(z.dot(c.getColumn(1))), double(z.dot(c.getColumn(2))));
  return nearest(angle, places_[i]);
}

AxisState JointConstraint::axis(std::size_t i) const {
  const Frames at = frames();
  AxisState state;
  state.place = placeOf(i, at);
  const btVector3 line = at.line(i), point = at.child.getOrigin();
  if (joint_.turns())
    state.speed = double((m_rbB.getAngularVelocity() - m_rbA.getAngularVelocity()).dot(line));
  else
    state.speed = double((m_rbB.getVelocityInLocalPoint(point - m_rbB.getCenterOfMassPosition()) -
                          m_rbA.getVelocityInLocalPoint(point - m_rbA.getCenterOfMassPosition()))
                             .dot(line));
  state.direction = fromBullet(line);
  return state;
}

JointLoad JointConstraint::load() const {
  return {fromBullet(feedback_.m_appliedForceBodyB), fromBullet(feedback_.m_appliedTorqueBodyB),
          fromBullet(arm_)};
}

void JointConstraint::setLoad(const JointLoad& load) {
  feedback_.m_appliedForceBodyB = toBullet(load.force);
  feedback_.m_appliedTorqueBodyB = toBullet(load.torque);
  arm_ = toBullet(load.arm);
}

// Bullet has torques about the centers of mass.
JointState JointConstraint::state() const {
  const JointLoad now = load();
  return {fromBullet(m_rbB.getCenterOfMassTransform() * origin_), now.force,
          now.torque - now.arm.cross(now.force)};
}

void JointConstraint::moveFrame(const btRigidBody& body, const btTransform& back) {
  if (&body == &m_rbA) inParent_ = back * inParent_;
  if (&body != &m_rbB) return;
  inChild_ = back * inChild_;
  origin_ = back * origin_;
}

void JointConstraint::getInfo1(btConstraintInfo1* info) {
  const Held held = heldBy(joint_.kind);
  int rows = held.shifts + held.turns;
  for (std::size_t i = 0; i < joint_.axes(); ++i) {
    const SceneAxis& axis = joint_.at(i);
    rows += axis.lower.has_value() + axis.upper.has_value();
    for (const JointMotor& by : drivesOf(axis, motors_[i])) rows += by.pushes();
  }
  info->m_numConstraintRows = rows;
  info->nub = 0;
}

void JointConstraint::getInfo2(btConstraintInfo2* info) {
  const Frames at = frames();
  for (std::size_t i = 0; i < joint_.axes(); ++i) places_[i] = placeOf(i, at);
  arm_ = m_rbB.getCenterOfMassTransform().getBasis() * origin_;
  Rows rows(*info, m_rbA, m_rbB, at.child.getOrigin());
  holdShifts(at, rows);
  holdTurns(at, rows);
  for (std::size_t i = 0; i < joint_.axes(); ++i) push(i, at, rows);
}

void JointConstraint::holdShifts(const Frames& at, Rows& rows) const {
  const btVector3 apart = at.child.getOrigin() - at.parent.getOrigin(), none(0, 0, 0);
  const double lead = joint_.pitch / (2 * std::numbers::pi);
  for (int k = 0; k < heldBy(joint_.kind).shifts; ++k) {
    const btVector3 line = at.parent.getBasis().getColumn(k);
    const bool threads = joint_.kind == Kind::Screw && k == 2;
    rows.hold(line, threads ? btVector3(btScalar(-lead) * line) : none,
              double(apart.dot(line)) - (threads ? lead * places_[0] : 0));
  }
}

void JointConstraint::holdTurns(const Frames& at, Rows& rows) const {
  const btVector3 none(0, 0, 0);
  const int turns = heldBy(joint_.kind).turns;
  if (turns == 0) return;
  if (turns == 1) {  // the second axis stays across the first
    const btVector3 line = at.z().cross(at.line(1));
    if (line.length2() > 0.01)
      return rows.hold(none, line.normalized(), -double(at.z().dot(at.line(1))));
    return rows.hold(none, at.x(), 0);
  }
  btVector3 turned = at.z().cross(at.child.getBasis().getColumn(2));
  if (turns == 3) {
    btQuaternion between = at.child.getRotation() * at.parent.getRotation().inverse();
    if (between.w() < 0) between = -between;
    turned = 2 * btVector3(between.x(), between.y(), between.z());
  }
  for (int k = 0; k < turns; ++k) {
    const btVector3 line = at.parent.getBasis().getColumn(k);
    rows.hold(none, line, double(turned.dot(line)));
  }
}

void JointConstraint::push(std::size_t i, const Frames& at, Rows& rows) const {
  const SceneAxis& axis = joint_.at(i);
  const btVector3 none(0, 0, 0), line = at.line(i);
  const btVector3 &shift = joint_.turns() ? none : line, &turn = joint_.turns() ? line : none;
  if (axis.lower) rows.limit(shift, turn, places_[i] - *axis.lower, 1);
  if (axis.upper) rows.limit(shift, turn, places_[i] - *axis.upper, -1);
  for (const JointMotor& by : drivesOf(axis, motors_[i]))
    if (by.pushes()) rows.drive(shift, turn, places_[i], by);
}

}  // namespace cloudcontact::program
