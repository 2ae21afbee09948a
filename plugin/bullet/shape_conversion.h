// Converts Bullet's convex shapes to Solid.
#pragma once

#include <LinearMath/btVector3.h>
#include <cloudcontact/law/solid.h>

#include <optional>

class btCollisionShape;

namespace cloudcontact {

// The solid, and its place in the Bullet shape's frame. Planes, boxes, spheres, capsules,
// cylinders, cones and hulls are exact, with Bullet's meaning of margins: inside the extents of a
// box or cylinder, outside the surface of a cone or hull. Any other convex shape becomes the hull
// of its vertices or, without vertices, of its support points in many directions. 2D shapes have
// the thickness that Bullet gives them. Empty if the shape is not convex or has no volume.
std::optional<PlacedSolid> toSolid(const btCollisionShape& shape);

// Keeps a conversion until what it depends on changes.
class ConversionCache {
 public:
  // Converts again if this is another shape, or its scaling, margin or number of vertices changed.
  // Null if the shape cannot be converted.
  const PlacedSolid* of(const btCollisionShape& shape);
  int conversions() const { return conversions_; }  // so far

 private:
  const btCollisionShape* source_ = nullptr;
  btVector3 scaling_{0, 0, 0};
  btScalar margin_ = 0;
  int vertices_ = 0, conversions_ = 0;
  std::optional<PlacedSolid> placed_;
};

}  // namespace cloudcontact
