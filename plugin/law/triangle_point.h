// The point of a triangle that is nearest to another point.
#pragma once

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// Returns the feature that it lies on: 0 the face, 1 to 3 corners, 4 to 6 the edges from them.
// (Ericson, Real-Time Collision Detection, 5.1.5)
int nearestOnTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x, Vec3& foot);

}  // namespace cloudcontact
