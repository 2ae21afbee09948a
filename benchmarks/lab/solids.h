// Closed meshes that the cases are made of, by formula: prisms, tubes, solids of revolution.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <vector>

namespace cloudcontact::program::lab {

using Outline = std::vector<Eigen::Vector2d>;  // counter-clockwise, without its first point again

// A regular polygon whose flats are `inner` from the centre, the first corner turned by `turn`.
Outline polygon(int corners, double inner, double turn = 0);
// A circle as a polygon of the circle's area, its facets no further than `tolerance` from it.
Outline circle(double radius, double tolerance);
int circleSegments(double radius, double tolerance);

// The outline, which need not be convex, from z = low to z = high.
Mesh prism(const Outline& outline, double low, double high);
// What lies between two outlines of as many points, the inner one empty.
Mesh tube(const Outline& inner, const Outline& outer, double low, double high);
// A closed outline in (radius, z), away from the axis, turned about z.
Mesh revolved(const Outline& section, int segments);
// A torus about z: `ring` is the radius of the tube's middle.
Mesh torus(double ring, double tubeRadius, double tolerance);

Mesh moved(Mesh mesh, const Pose& pose);

}  // namespace cloudcontact::program::lab
