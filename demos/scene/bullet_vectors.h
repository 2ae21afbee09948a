// Converts vectors and poses to Bullet's types and back.
#pragma once

#include <LinearMath/btTransform.h>
#include <cloudcontact/base/pose.h>

namespace cloudcontact::program {

inline btVector3 toBullet(const Vec3& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

inline btTransform toBullet(const Pose& pose) {
  const auto& q = pose.orientation;
  return btTransform(
      btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())),
      toBullet(pose.position));
}

inline Vec3 fromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

inline Pose fromBullet(const btTransform& t) {
  // Through the matrix that Bullet integrates: Bullet's own conversion to a quaternion may round to
  // float.
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = t.getBasis()[r][c];
  return {Eigen::Quaterniond(m).normalized(), fromBullet(t.getOrigin())};
}

}  // namespace cloudcontact::program
