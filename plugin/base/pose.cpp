// The part of poses that is better compiled once.
#include <cloudcontact/base/pose.h>

#include <cmath>

namespace cloudcontact {

// As Eigen's Quaternion::setFromTwoVectors(), which takes an SVD where the two are opposite, and
// with it five seconds to compile: there any axis across will do.
Eigen::Quaterniond shortestTurn(const Vec3& from, const Vec3& to) {
  constexpr double kOpposite = 1e-12 - 1;  // cosine
  const Vec3 a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  Eigen::Quaterniond turn;
  if (cosine < kOpposite) {
    turn.w() = 0;  // right to 1.4e-6 rad
    turn.vec() = a.unitOrthogonal();
    return turn;
  }
  const double twice = std::sqrt((1 + cosine) * 2);
  turn.w() = twice * 0.5;
  turn.vec() = 1 / twice * a.cross(b);
  return turn;
}

}  // namespace cloudcontact
