// Closed meshes of the primitives, fine enough that a facet is far below a voxel.
#pragma once

#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

namespace cloudcontact::program {

// A closed mesh of the shape, each vertex on or, where the surface is curved, just outside it, so
// that the mesh has the shape's volume and facets lie on both sides of the surface. No facet is
// further than `tolerance` [m] from the surface, unless that took more than about 330,000
// triangles. Throws std::invalid_argument for a half-space, which has no mesh.
Mesh primitiveMesh(const Solid& shape, double tolerance);

}  // namespace cloudcontact::program
