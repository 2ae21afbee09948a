// The points where a segment enters and leaves a cloud, for ray queries.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <functional>

namespace cloudcontact {

struct FieldHit {
  double fraction;  // of the segment, from its start
  Vec3 normal;      // outward unit vector, body's frame
};

// The first point before `maxFraction` where the segment passes from outside to inside. Body's
// frame [m]. Empty if there is none or the segment is not finite.
std::optional<FieldHit> firstEntry(const SurfaceField& field, const Vec3& from, const Vec3& to,
                                   double maxFraction = 1);

// Calls visit(hit, enters) in order for each point before `maxFraction` where the segment passes
// the surface, until it returns false. The hits are those of the closed form, if the cloud has one
// (closed_form.h), else of the smoothed surface (smoothed_point.h).
void visitCrossings(const SurfaceField& field, const Vec3& from, const Vec3& to, double maxFraction,
                    const std::function<bool(const FieldHit&, bool enters)>& visit);

}  // namespace cloudcontact
