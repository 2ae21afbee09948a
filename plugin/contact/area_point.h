// Depth and normal of one kind of area at a point: area.h without the choice of kind, for loops
// that make it once.
#pragma once

#include <cloudcontact/area.h>

namespace cloudcontact {

double depthOf(const SphereArea& area, const Vec3& point);
double depthOf(const BoxArea& area, const Vec3& point);
double depthOf(const EllipsoidArea& area, const Vec3& point);
double depthOf(const CloudArea& area, const Vec3& point);

// What areaDepth() gives changes by no more than the way from one point to another.
constexpr bool isDistance(const SphereArea&) {
  return true;
}
constexpr bool isDistance(const BoxArea&) {
  return true;
}
constexpr bool isDistance(const EllipsoidArea&) {
  return false;
}
constexpr bool isDistance(const CloudArea&) {
  return false;
}

inline double depthOf(const SphereArea& area, const Vec3& point) {
  return area.radius - (point - area.center).norm();
}

}  // namespace cloudcontact
