// Repairs the direction of triangles. All functions take welded meshes (mesh_topology.h).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

namespace cloudcontact {

void flip(Eigen::Vector3i& triangle);  // reverses its direction

// Drops doubles of the same direction, whose volume would count twice. Where every triangle has a
// twin of opposite direction, the mesh was made two-sided for display, and one of each pair is
// dropped; otherwise such pairs are the common faces of two bodies, and remain.
void dropDoubles(Mesh& mesh);

// Makes neighboring triangles agree in direction. In each component the larger area decides.
void agreeInDirection(Mesh& mesh);

// Reverses closed components that face inward but lie inside no other component: they are bodies
// that face the wrong way, not cavities.
void turnStrayComponents(Mesh& mesh);

}  // namespace cloudcontact
