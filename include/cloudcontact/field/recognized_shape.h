// RecognizedShape: a cloud that is a ball, box, cylinder, capsule, cone or a convex body with flat
// faces within a tolerance.
// Closed forms then answer in the place of its voxels (docs/engine.md, "Shapes").
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/solid.h>

#include <optional>

namespace cloudcontact {

struct RecognizedShape {
  // Sphere, Box, Cylinder, Capsule, Cone or a Hull of at most 64 faces with its edges, about a
  // place inside it; in the cloud's frame.
  PlacedSolid placed;
  // [m] The largest distance between the cloud's surface and the shape's. Faces: at all samples,
  // which know a flat or gently curved surface to about 0.01 voxel. Edges and tips: by coverage, to
  // about 0.1 voxel. So it is not 0 for a perfect body.
  double error = 0;
};

// The shape that the cloud's surface is within `tolerance` [m]: a ball if it is one, else the kind
// with the least error; a hull if it is no other kind. Empty if none is: a hollow, bored, notched
// or dented body has surface where the shape has none, and a curved body is no hull, since one on
// facets would not roll. Throws std::invalid_argument where the tolerance is negative or not
// finite.
std::optional<RecognizedShape> recognizedShape(const SurfaceField& field, double tolerance);

// "ball", "box", "cylinder", "capsule", "cone", "hull" or, for any other kind, "solid".
const char* shapeName(const Solid& solid);

}  // namespace cloudcontact
