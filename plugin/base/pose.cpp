// The part of poses that is better compiled once.
#include <cloudcontact/base/pose.h>

namespace cloudcontact {

Eigen::Quaterniond shortestTurn(const Vec3& from, const Vec3& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace cloudcontact
