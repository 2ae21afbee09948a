// Between this project's vectors and poses, in double, and Bullet's.
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
  // From the matrix that Bullet integrates, so that nothing is lost on the way.
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = t.getBasis()[r][c];
  return {Eigen::Quaterniond(m).normalized(), fromBullet(t.getOrigin())};
}

}  // namespace cloudcontact::program
