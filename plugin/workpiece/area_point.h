// Depth and normal of one kind of area at a point: area.h without the choice of kind, for loops
// that make it once.
#pragma once

#include <cloudcontact/workpiece/area.h>

#include <type_traits>

namespace cloudcontact {

double depthOf(const SphereArea& area, const Vec3& point);
double depthOf(const BoxArea& area, const Vec3& point);
double depthOf(const EllipsoidArea& area, const Vec3& point);
double depthOf(const CloudArea& area, const Vec3& point);

Vec3 normalOf(const BoxArea& area, const Vec3& point);
Vec3 normalOf(const EllipsoidArea& area, const Vec3& point);
Vec3 normalOf(const CloudArea& area, const Vec3& point);

// Whether the depth changes by no more than the way from one point to another.
template <typename Kind>
constexpr bool kIsDistance = !std::is_same_v<Kind, EllipsoidArea>;

inline double depthOf(const SphereArea& area, const Vec3& point) {
  return area.radius - (point - area.center).norm();
}
inline Vec3 normalOf(const SphereArea& area, const Vec3& point) {
  const Vec3 from = point - area.center;
  const double length = from.norm();
  return length > 0 ? Vec3(from * (1 / length)) : Vec3::UnitZ();
}

}  // namespace cloudcontact
