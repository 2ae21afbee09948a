// Converts vectors and transforms between Bullet and this project.
#pragma once

#include <LinearMath/btTransform.h>
#include <cloudcontact/base/pose.h>

#include <vector>

namespace cloudcontact {

inline Vec3 toVec3(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

inline btVector3 toBullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

// Adds its coordinates to a list.
inline void append(std::vector<double>& coordinates, const btVector3& v) {
  for (int axis = 0; axis < 3; ++axis) coordinates.push_back(v[axis]);
}

// Through the matrix in double, because Bullet's float quaternion is off by 1e-7: too much for a
// part of a millimeter, a meter away from the origin.
inline Pose toPose(const btTransform& t) {
  Eigen::Matrix3d basis;
  for (int row = 0; row < 3; ++row) basis.row(row) = toVec3(t.getBasis()[row]).transpose();
  return {Eigen::Quaterniond(basis).normalized(), toVec3(t.getOrigin())};
}

inline btTransform toBullet(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                  static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())),
                     toBullet(pose.position));
}

}  // namespace cloudcontact
