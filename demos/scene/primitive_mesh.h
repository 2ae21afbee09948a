// Closed meshes of the primitives within a tolerance.
#pragma once

#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

namespace cloudcontact::program {

// A closed mesh of the shape. Vertices of curved surfaces lie just outside, so that the mesh has
// the shape's volume. Facets lie within `tolerance` [m] of the surface, up to a limit of about
// 330,000 triangles. Throws std::invalid_argument for a half-space.
Mesh primitiveMesh(const Solid& shape, double tolerance);

}  // namespace cloudcontact::program
