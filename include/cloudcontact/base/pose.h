// Pose and Motion: where a body is and how it moves.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cloudcontact {

// A place, a direction or three lengths; in meters unless stated otherwise.
using Vec3 = Eigen::Vector3d;

// A rigid transform, world = orientation * local + position. Lengths in meters.
struct Pose {
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 position = Vec3::Zero();

  Vec3 toWorld(const Vec3& local) const { return orientation * local + position; }
  Vec3 toLocal(const Vec3& world) const { return orientation.conjugate() * (world - position); }
  // The world pose of `inner`, which is given in this frame.
  Pose operator*(const Pose& inner) const {
    return {orientation * inner.orientation, toWorld(inner.position)};
  }
  Pose inverse() const {
    const Eigen::Quaterniond q = orientation.conjugate();
    return {q, q * -position};
  }
};

// The shortest rotation that turns `from` towards `to`, whose lengths do not matter; one of them
// where they are opposite. As Eigen's FromTwoVectors(), which takes seconds to compile.
Eigen::Quaterniond shortestTurn(const Vec3& from, const Vec3& to);

// The velocity of a rigid body, in world coordinates.
struct Motion {
  Vec3 linear = Vec3::Zero();   // of `center` [m/s]
  Vec3 angular = Vec3::Zero();  // [rad/s]
  Vec3 center = Vec3::Zero();   // [m]

  // Velocity of the point of the body that is at `world` [m/s].
  Vec3 at(const Vec3& world) const { return linear + angular.cross(world - center); }
};

// Where a body is after `seconds` of constant velocity: its center moves on a line while it turns
// about it.
inline Pose movedOn(const Pose& pose, const Motion& motion, double seconds) {
  const Vec3 turn = seconds * motion.angular;
  const double angle = turn.norm();
  const Eigen::Quaterniond by = angle > 0
                                    ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))
                                    : Eigen::Quaterniond::Identity();
  return {(by * pose.orientation).normalized(),
          motion.center + seconds * motion.linear + by * (pose.position - motion.center)};
}

}  // namespace cloudcontact
