// The way between two convex bodies that are apart (Gilbert, Johnson, Keerthi 1988).
#pragma once

#include "law/convex_solid.h"

namespace cloudcontact {

// A solid in the frame in which a pair is solved.
struct PlacedConvex {
  const Solid* solid = nullptr;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Vec3 at = Vec3::Zero();
  double scale = 1;  // of the solid, about `at`

  Vec3 support(const Vec3& direction) const {
    return turn * (scale * supportOf(*solid, turn.transpose() * direction)) + at;
  }
  double reach(const Vec3& unit) const {  // from `at`
    return scale * reachOf(*solid, turn.transpose() * unit);
  }
};

// The unit vector from A's nearest point to B's, or empty if they are nearer than a thousand times
// `precision` [m], to which the distance is exact.
std::optional<Vec3> wayBetween(const PlacedConvex& a, const PlacedConvex& b, double precision);

}  // namespace cloudcontact
