// What a lathe turns: closed meshes from an outline.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <vector>

namespace cloudcontact::program::lab {

// `outline` holds (radius, z) from the axis to the axis, outside to the right of its way: an outer
// wall goes up. Only its first and last point lie on the axis.
Mesh turnedMesh(const std::vector<Eigen::Vector2d>& outline, int segments);

// Half a hollow ball about the origin, open upward, its rim flat at z = 0.
Mesh bowlMesh(double innerRadius, double outerRadius, int segments);

}  // namespace cloudcontact::program::lab
