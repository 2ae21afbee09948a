// What is missing from a surface, filled in: see closing.h.
#include "mesh/closing.h"

#include "mesh/mesh_topology.h"

namespace cloudcontact {

using Eigen::Vector3d;

namespace {

// The middle of a loop, by the length of its edges; no vertex counts more for standing dense.
Vector3d middleOfLoop(const Mesh& mesh, const std::vector<int>& loop) {
  Vector3d sum = Vector3d::Zero();
  double length = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector3d &a = mesh.vertices[loop[i]], &b = mesh.vertices[loop[(i + 1) % loop.size()]];
    sum += (b - a).norm() * (a + 0.5 * (b - a));
    length += (b - a).norm();
  }
  return sum / length;
}

}  // namespace

Closing closeSurface(const Mesh& mesh) {
  Closing closing{mesh, mesh.triangles.size(), 0};
  Mesh& result = closing.mesh;
  for (const std::vector<int>& loop : boundaryLoops(mesh)) {
    if (loop.size() == 3) {
      result.triangles.emplace_back(loop[0], loop[1], loop[2]);
      continue;
    }
    const int apex = static_cast<int>(result.vertices.size());
    result.vertices.push_back(middleOfLoop(mesh, loop));
    for (std::size_t i = 0; i < loop.size(); ++i)
      result.triangles.emplace_back(loop[i], loop[(i + 1) % loop.size()], apex);
  }
  for (std::size_t t = closing.firstCap; t < result.triangles.size(); ++t)
    closing.capArea += triangleArea(result, t);
  return closing;
}

}  // namespace cloudcontact
