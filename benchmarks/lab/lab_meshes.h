// Closed meshes by formula: prisms, tubes, solids of revolution, bowls, frusta, gears.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <vector>

namespace cloudcontact::program::lab {

using Outline = std::vector<Eigen::Vector2d>;  // counter-clockwise, first point not repeated

// A regular polygon with inscribed radius `inner`, its first corner at angle `turn`.
Outline polygon(int corners, double inner, double turn = 0);
// A polygon with the circle's area, no further than `tolerance` from the circle.
Outline circle(double radius, double tolerance);
int circleSegments(double radius, double tolerance);

// The outline, convex or not, extruded from z = low to z = high.
Mesh prism(const Outline& outline, double low, double high);
// A tube between two outlines with equal numbers of points.
Mesh tube(const Outline& inner, const Outline& outer, double low, double high);
// A closed outline in (radius, z) that does not meet the axis, revolved about z.
Mesh revolved(const Outline& section, int segments);
// A torus about z: `ring` is the radius of the tube's center line.
Mesh torus(double ring, double tubeRadius, double tolerance);

// A solid of revolution about z whose outline (radius, z) starts and ends on the axis and meets it
// nowhere else. The outside is to the right: an outer wall goes up. Throws std::invalid_argument
// for fewer than three points or segments.
Mesh turnedMesh(const std::vector<Eigen::Vector2d>& outline, int segments);

// Half a hollow ball about the origin, open at the top, its rim at z = 0.
Mesh bowlMesh(double innerRadius, double outerRadius, int segments);

// A frustum over 0 <= z <= height between two rectangles about the z axis. A side of length 0 makes
// a wedge's edge or a spike's tip.
Mesh taperedMesh(const Eigen::Vector2d& bottom, const Eigen::Vector2d& top, double height);
// An outline in (x, z), counter-clockwise seen from -y, extruded over |y| <= width / 2.
Mesh prismMesh(const Outline& outline, double width);

// An involute spur gear. Two of equal module and pressure angle mesh at an axle distance of
// (teeth + teeth) * module / 2.
struct Gear {
  int teeth = 18;                             // at least 17: fewer need an undercut
  double module = 4e-3;                       // [m] pitch diameter per tooth
  double pressureAngle = 0.3490658503988659;  // [rad], 20 deg
  double width = 10e-3;                       // [m] along z
  double thinned = 0;                         // [m] taken off a tooth's width on the pitch circle
  int flankSteps = 8;                         // points along each flank

  double pitchRadius() const { return teeth * module / 2; }
};

// About z, -width/2 <= z <= width/2, a tooth's middle on the x axis. Throws std::invalid_argument.
Mesh gearMesh(const Gear& gear);

Mesh moved(Mesh mesh, const Pose& pose);

}  // namespace cloudcontact::program::lab
