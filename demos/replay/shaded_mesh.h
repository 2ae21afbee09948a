// A mesh as a viewer wants it: single precision, a normal at every vertex.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cstdint>
#include <vector>

namespace cloudcontact::program {

struct ShadedMesh {
  std::vector<Eigen::Vector3f> positions, normals;  // [m]; unit
  std::vector<std::uint32_t> corners;               // three a triangle
};

// Faces that meet at less than `crease` [rad] are shaded as one smooth surface; a vertex on a
// sharper edge becomes several.
ShadedMesh shaded(const Mesh& mesh, double crease = 0.6);

}  // namespace cloudcontact::program
