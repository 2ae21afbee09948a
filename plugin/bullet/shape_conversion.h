// Plain Bullet shapes as Solid: what a cloud meets on the other side.
#pragma once

#include <LinearMath/btVector3.h>
#include <cloudcontact/law/solid.h>

#include <optional>

class btCollisionShape;

namespace cloudcontact {

// A shape and where its own frame (axis along z) stands in the Bullet shape's frame.
struct PlacedShape {
  Solid shape;
  Pose frame;
};

// The plane, box, sphere, capsule, cylinder, cone and hull exactly, with Bullet's margins as Bullet
// means them: inside a box's and a cylinder's extents, outside a cone's and a hull's surface. Any
// other convex shape as the hull of its vertices, or, where it has none, of its support points in
// many directions. Nothing where the shape is not convex or has no volume.
std::optional<PlacedShape> toAnalytic(const btCollisionShape& shape);

// Whether toAnalytic knows what to do with this BroadphaseNativeTypes value.
bool isConvertible(int proxyType);

// What a converted shape depended on, so that a conversion can be kept until one of them changes.
class ConversionCache {
 public:
  // The conversion, made anew where the shape is another or was scaled, given a margin or more
  // points since; null where it has none.
  const PlacedShape* of(const btCollisionShape& shape);
  int conversions() const { return conversions_; }  // made so far

 private:
  const btCollisionShape* source_ = nullptr;
  btVector3 scaling_{0, 0, 0};
  btScalar margin_ = 0;
  int vertices_ = 0, conversions_ = 0;
  std::optional<PlacedShape> placed_;
};

}  // namespace cloudcontact
