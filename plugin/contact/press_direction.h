// The direction in which two convex bodies press on each other.
#pragma once

#include "contact/core_distance.h"

namespace cloudcontact {

// The direction along which B would come free of A by the shortest way, or in which it is apart.
struct PressDirection {
  Vec3 normal = Vec3::UnitZ();  // unit, from A to B
  double depth = 0;             // [m] of B in A along it; negative: apart, by up to 3 % more
};

// Closed forms for half-spaces, balls and pairs of boxes. For others the way between cores, or a
// face of either body where that is shorter. Empty if even the cores overlap: the bodies are half
// as deep in each other as they are thick. Both must be simple (isSimple), at most one a
// half-space.
std::optional<PressDirection> pressDirection(const PlacedConvex& a, const PlacedConvex& b);

// Whether pressDirection() has a closed form for a pair.
bool isClosedForm(const Solid& a, const Solid& b);
// The best of the directions of both bodies' faces: what pressDirection() would return if the
// bodies meet there, at a fraction of its time. Empty without faces. Not for half-spaces and balls.
std::optional<PressDirection> faceDirection(const PlacedConvex& a, const PlacedConvex& b);

}  // namespace cloudcontact
