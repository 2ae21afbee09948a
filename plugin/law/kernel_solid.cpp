// Solids with a fixed count of numbers.
#include "law/kernel_solid.h"

namespace cloudcontact {

namespace {

using Plain = std::optional<CcSolid>;

Plain plain(const HalfSpace& plane) {
  const Vec3& n = plane.normal;
  return CcSolid{CC_HALF_SPACE, 0, {n.x(), n.y(), n.z(), plane.offset}};
}
Plain plain(const Sphere& s) {
  return CcSolid{CC_SPHERE, 0, {s.radius}};
}
Plain plain(const Box& b) {
  return CcSolid{CC_BOX, 1, {b.halfExtents.x(), b.halfExtents.y(), b.halfExtents.z()}};
}
Plain plain(const Ellipsoid& e) {
  return CcSolid{CC_ELLIPSOID, 0, {e.semiAxes.x(), e.semiAxes.y(), e.semiAxes.z()}};
}
Plain plain(const Capsule& c) {
  return CcSolid{CC_CAPSULE, 0, {c.radius, c.halfHeight}};
}
Plain plain(const Cylinder& c) {
  return CcSolid{CC_CYLINDER, 1, {c.radius, c.halfHeight}};
}
Plain plain(const Cone& c) {
  return CcSolid{CC_CONE, 1, {c.radius, c.halfHeight, c.margin}};
}
template <typename Kind>
Plain plain(const Kind&) {
  return {};
}

}  // namespace

std::optional<CcSolid> plainSolid(const Solid& solid) {
  return std::visit([](const auto& kind) { return plain(kind); }, solid);
}

}  // namespace cloudcontact
