// The joints of a running world: how they are made, read and driven (World::joint, setMotor).
#include <cmath>
#include <stdexcept>

#include "io/errors.h"
#include "scene/bullet_vectors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {
namespace {

// Where a joint's axes are at the start: z along the first, x along the second of a universal one.
Pose frameOf(const SceneJoint& joint) {
  Pose frame = joint.pose;
  frame.orientation = shortestTurn(Vec3::UnitZ(), joint.axis);
  if (joint.kind != SceneJoint::Kind::Universal) return frame;
  const Vec3 z = joint.axis.normalized();
  const Vec3 x = (joint.second.axis - joint.second.axis.dot(z) * z).normalized();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  frame.orientation = Eigen::Quaterniond(axes);
  return frame;
}

bool isUsable(const JointMotor& motor) {
  const bool finite = std::isfinite(motor.position) && std::isfinite(motor.velocity) &&
                      std::isfinite(motor.stiffness) && std::isfinite(motor.force);
  return finite && motor.stiffness >= 0 && motor.damping >= 0 && motor.most >= 0;
}

}  // namespace

void World::State::addJoint(const SceneJoint& joint) {
  for (const int body : {joint.parent, joint.child})
    if (body >= 0 && bodies[body].soft)
      throw BadInput("joint '" + joint.name + "': body '" + bodies[body].scene.name +
                     "' deforms; hold its sides instead (<cloudcontact:soft held=\"...\">)");
  const auto centerOf = [&](int body) {
    return body < 0 ? Pose() : bodies[body].scene.pose * bodies[body].parts.frame;
  };
  const Pose child = centerOf(joint.child);
  Pose frame = frameOf(joint);
  // A fixed joint may be anywhere; at the center of mass no lever magnifies the solver's error.
  if (joint.kind == SceneJoint::Kind::Fixed && joint.child >= 0) frame.position = child.position;
  const auto rigidOf = [&](int body) -> btRigidBody& {
    return body < 0 ? ground : *bodies[body].rigid;
  };
  auto made = std::make_unique<JointConstraint>(joint, rigidOf(joint.parent), rigidOf(joint.child),
                                                toBullet(centerOf(joint.parent).inverse() * frame),
                                                toBullet(child.inverse() * frame));
  made->setOrigin(toBullet(child.toLocal(joint.pose.position)));
  joints.push_back({joint, std::move(made)});
  world.addConstraint(joints.back().rows.get(), true);
  joined.insert(std::minmax(joint.parent, joint.child));
}

// Constraint frames lie in the frame of the rigid body, which a cut moves.
void World::State::moveJoints(std::size_t body, const Pose& movedFrame) {
  const btTransform back = toBullet(movedFrame.inverse());
  for (const Joint& joint : joints) joint.rows->moveFrame(*bodies[body].rigid, back);
}

std::size_t World::jointCount() const {
  return state_->joints.size();
}

const SceneJoint& World::describedJoint(std::size_t joint) const {
  return state_->joints.at(joint).scene;
}

JointState World::joint(std::size_t joint) const {
  return state_->joints.at(joint).rows->state();
}

const World::State::Joint& World::State::movingAxis(std::size_t joint, std::size_t axis) const {
  const Joint& moved = joints.at(joint);
  if (axis < moved.scene.axes()) return moved;
  throw std::out_of_range("joint '" + moved.scene.name + "': has " +
                          std::to_string(moved.scene.axes()) + " axes that move; there is none " +
                          std::to_string(axis));
}

AxisState World::axis(std::size_t joint, std::size_t axis) const {
  return state_->movingAxis(joint, axis).rows->axis(axis);
}

const JointMotor& World::motor(std::size_t joint, std::size_t axis) const {
  return state_->movingAxis(joint, axis).rows->motor(axis);
}

void World::setMotor(std::size_t joint, std::size_t axis, const JointMotor& motor) {
  const State::Joint& moved = state_->movingAxis(joint, axis);
  if (!isUsable(motor))
    throw std::invalid_argument("joint '" + moved.scene.name +
                                "': a motor's gains and most must be 0 or more, and all but "
                                "damping and most finite");
  for (const int body : {moved.scene.parent, moved.scene.child})
    if (body >= 0) state_->bodies[body].rigid->activate();
  moved.rows->setMotor(axis, motor);
}

}  // namespace cloudcontact::program
