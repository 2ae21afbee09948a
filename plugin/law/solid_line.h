// Lines through solids: where a line enters and leaves, and a solid's farthest point along a
// direction. Lengths in meters, in the frame of the solid's owner.
#pragma once

#include <cloudcontact/law/solid.h>

#include <optional>

namespace cloudcontact {

// The part of the line point + t * way that lies in a solid.
struct LineSpan {
  double from, to;  // [m]
};

// Parallel lines through a solid, which must outlive this. `way` is a unit vector. Exact for solids
// without a margin. Clouds and solids with a margin are followed from a point on, in steps of their
// depth but at least `step`: the span begins at 0 or where the line first enters, and ends where it
// first leaves.
class SolidLines {
 public:
  SolidLines(const PlacedSolid& area, const Vec3& way, double step);
  // Empty where the line through `point` misses the solid.
  std::optional<LineSpan> through(const Vec3& point) const;

 private:
  const PlacedSolid* area_;
  Vec3 way_, localWay_;
  Eigen::Matrix3d toLocal_;
  double step_;
  bool followed_;
};

// The solid's point with the greatest product with `way`; one of them where there are several.
// Empty for a half-space and a cloud.
std::optional<Vec3> farthestOf(const PlacedSolid& area, const Vec3& way);

}  // namespace cloudcontact
