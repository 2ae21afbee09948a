// A joint of a scene as plain values: its kind, its axes, what pushes along them, and its state.
#pragma once

#include <cloudcontact/base/pose.h>

#include <cstddef>
#include <limits>
#include <optional>
#include <string>

namespace cloudcontact::program {

// A line that the child slides along, or turns about, as it is seen from the parent. What moves
// does so in rad or m, and is pushed by N m or N.
struct SceneAxis {
  Vec3 axis = Vec3::UnitZ();         // in the world, at the start
  std::optional<double> lower = {};  // [rad, m]
  std::optional<double> upper = {};
  // A spring that pulls to `rest`, its damper, and a friction that holds still up to this push.
  // [N m/rad, N m s/rad, rad, N m] or [N/m, N s/m, m, N]
  double spring = 0, damping = 0, rest = 0, friction = 0;
  double effort = std::numeric_limits<double>::infinity();  // the most that a motor pushes
};

struct SceneJoint : SceneAxis {
  // Screw: the child goes on by `pitch` as it turns once. Ball: it turns as it likes. Universal: it
  // turns about `axis`, which the parent holds, and about `second`, which it holds itself.
  enum class Kind { Fixed, Revolute, Prismatic, Screw, Ball, Universal };
  std::string name;
  Kind kind = Kind::Fixed;
  int parent = -1, child = -1;                 // index into bodies, -1: the world
  Pose pose;                                   // of its frame in the world, at the start
  double pitch = 0;                            // of a screw [m], above 0 a right-handed one
  SceneAxis second = {.axis = Vec3::UnitX()};  // of a universal joint, across the first

  // How many axes it moves along that have limits, motors and a place.
  std::size_t axes() const {
    return kind == Kind::Universal ? 2 : kind == Kind::Fixed || kind == Kind::Ball ? 0 : 1;
  }
  const SceneAxis& at(std::size_t i) const { return i == 0 ? *this : second; }
  bool turns() const { return kind != Kind::Prismatic; }
};

// "revolute" ...
const char* nameOf(SceneJoint::Kind kind);
// Of such a name. Throws std::invalid_argument.
SceneJoint::Kind jointKind(const std::string& name);

// What drives an axis: it pushes by force + stiffness (position - place) + damping (velocity -
// speed), by `most` at most. So one law is a servo, a speed or a force. The spring is that of the
// step's middle and the damper that of its end, so no gain is too high for a step. An infinite
// damping moves the axis at `velocity` as long as `most` is enough.
struct JointMotor {
  double position = 0, velocity = 0;  // [rad, m], a second
  double stiffness = 0, damping = 0;  // [N m/rad, N m s/rad] or [N/m, N s/m]
  double force = 0;                   // [N m, N]
  double most = std::numeric_limits<double>::infinity();
  bool pushes() const { return stiffness > 0 || damping > 0 || force != 0; }
};

// Of an axis. A place counts turns on, from that of the start: 2 pi is a whole turn.
struct AxisState {
  double place = 0, speed = 0;     // of the child as seen from the parent [rad, m], a second
  Vec3 direction = Vec3::UnitZ();  // in the world
};

// What a joint carried in a step: a push on its child at the child's center of mass, as Bullet has
// it, and the way from there to the joint then [N, N m, m]. All 0: nothing, as of a body that is
// cut away.
struct JointLoad {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero(), arm = Vec3::Zero();
};

// What a joint does, and where it is.
struct JointState {
  Vec3 origin = Vec3::Zero();  // of its frame, on the child [m]
  // On the child from the parent in the latest step, with motors, springs and friction, about the
  // origin of then [N, N m].
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

}  // namespace cloudcontact::program
