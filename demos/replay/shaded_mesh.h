// A mesh for viewers: single precision, with a normal at each vertex.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cstdint>
#include <vector>

namespace cloudcontact::program {

struct ShadedMesh {
  std::vector<Eigen::Vector3f> positions, normals;  // [m]; unit
  std::vector<std::uint32_t> corners;               // three per triangle
};

// Shades faces that meet at less than `crease` [rad] as one smooth surface; splits vertices on
// sharper edges.
ShadedMesh shaded(const Mesh& mesh, double crease = 0.6);

// The same triangles over vertices of different positions.
Mesh welded(const Mesh& mesh);

}  // namespace cloudcontact::program
