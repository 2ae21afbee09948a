// Four equal parts, a body that stands on them: tips, balls or posts.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include "mesh/turned_mesh.h"

namespace cloudcontact::test {

// Copies of a foot at (+-x, +-y).
inline Mesh feetMesh(const Mesh& foot, double x, double y) {
  Mesh all;
  for (int k = 0; k < 4; ++k) {
    const int first = static_cast<int>(all.vertices.size());
    const Eigen::Vector3d by(k & 1 ? x : -x, k & 2 ? y : -y, 0);
    for (const auto& vertex : foot.vertices) all.vertices.push_back(vertex + by);
    for (const auto& triangle : foot.triangles)
      all.triangles.push_back(triangle + Eigen::Vector3i::Constant(first));
  }
  return all;
}

// A pyramid that stands on its tip at the origin, as high as its base is from its middle.
inline Mesh tipMesh(double height) {
  return turnedMesh({{0, 0}, {height, height}, {0, height}}, 4);
}

}  // namespace cloudcontact::test
