// Which way a mesh's triangles face, put right. All take welded meshes (mesh_topology.h).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

namespace cloudcontact {

void flip(Eigen::Vector3i& triangle);

// Drops triangles that stand twice in the same direction (their volume would count twice). Where
// every triangle has a twin in the other direction, a mesh made two-sided for display, one of the
// two goes; elsewhere such pairs are two bodies that touch, and stay.
void dropDoubles(Mesh& mesh);

// Neighbours agree, each component as the greater part of its area stood.
void agreeInDirection(Mesh& mesh);

// A closed component turned inside out that lies inside no other is no cavity, but a body turned
// wrongly.
void turnStrayComponents(Mesh& mesh);

}  // namespace cloudcontact
