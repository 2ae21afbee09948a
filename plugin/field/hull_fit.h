// Fits a convex body with flat faces to points of a surface.
#pragma once

#include "field/shape_fit.h"

namespace cloudcontact {

// The hulls that the points' flat faces enclose, with their edges, about a place inside: one by the
// faces on which most of the surface lies, then one more for each narrow face. None where the
// surface is not made of 4 to kMostFaces flat faces, or is not convex. A curved surface is none,
// however many faces would be near it: a body on facets does not roll. Lengths as in ShapePoint. Of
// corners and edges this says nothing: whoever asks compares them.
std::vector<PlacedSolid> fittedHulls(const std::vector<ShapePoint>& surface);

}  // namespace cloudcontact
