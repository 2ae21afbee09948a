// The point where a segment enters a cloud, for ray queries.
#pragma once

#include <cloudcontact/field/surface_field.h>

namespace cloudcontact {

struct FieldHit {
  double fraction;  // of the segment, from its start
  Vec3 normal;      // outward unit vector, body's frame
};

// The first point before `maxFraction` where the segment passes from outside to inside. Body's
// frame [m]. Empty if there is none or the segment is not finite.
std::optional<FieldHit> firstEntry(const SurfaceField& field, const Vec3& from, const Vec3& to,
                                   double maxFraction = 1);

}  // namespace cloudcontact
