// Where a segment enters a cloud.
#pragma once

#include <cloudcontact/field/surface_field.h>

namespace cloudcontact {

struct FieldHit {
  double fraction;  // of the way from the segment's start to its end
  Vec3 normal;      // outward, body's frame
};

// The first place before `maxFraction` where the segment goes from outside to inside. Body's frame.
std::optional<FieldHit> firstEntry(const SurfaceField& field, const Vec3& from, const Vec3& to,
                                   double maxFraction = 1);

}  // namespace cloudcontact
