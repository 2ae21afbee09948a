// Where a body stands and how it moves: the two value types that every query takes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cloudcontact {

using Vec3 = Eigen::Vector3d;

// A rigid placement: world = orientation * local + position. Metres.
struct Pose {
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 position = Vec3::Zero();

  Vec3 toWorld(const Vec3& local) const { return orientation * local + position; }
  Vec3 toLocal(const Vec3& world) const { return orientation.conjugate() * (world - position); }
  // The pose `inner` (given in this frame) seen from the world.
  Pose operator*(const Pose& inner) const {
    return {orientation * inner.orientation, toWorld(inner.position)};
  }
  Pose inverse() const {
    const Eigen::Quaterniond q = orientation.conjugate();
    return {q, q * -position};
  }
};

// The velocity of a rigid body: linear of `center` [m/s], angular [rad/s], all in the world.
struct Motion {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
  Vec3 center = Vec3::Zero();

  Vec3 at(const Vec3& world) const { return linear + angular.cross(world - center); }
};

}  // namespace cloudcontact
