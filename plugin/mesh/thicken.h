// A surface given a back and walls: what makes a body of a sheet.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <vector>

namespace cloudcontact {

// The mesh, whose triangles agree in their direction; its copy, each vertex moved by its `behind`
// [m] and turned over; and walls along the open edges.
Mesh thickened(Mesh mesh, const std::vector<Eigen::Vector3d>& behind);

}  // namespace cloudcontact
