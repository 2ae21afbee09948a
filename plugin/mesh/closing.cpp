// Fills holes and adds backs: see closing.h.
#include "mesh/closing.h"

#include "mesh/mesh_topology.h"

namespace cloudcontact {

using Eigen::Vector3d;

namespace {

// The center of a loop weighted by edge lengths, so dense vertices do not count more.
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

Mesh thickened(Mesh mesh, const std::vector<Eigen::Vector3d>& behind) {
  const std::vector<EdgeSide> sides = sortedEdgeSides(mesh);
  const int count = static_cast<int>(mesh.vertices.size());
  for (int v = 0; v < count; ++v) mesh.vertices.push_back(mesh.vertices[v] + behind[v]);
  const std::size_t faces = mesh.triangles.size();
  for (std::size_t t = 0; t < faces; ++t) {
    const Eigen::Vector3i f = mesh.triangles[t];
    mesh.triangles.emplace_back(f[0] + count, f[2] + count, f[1] + count);
  }
  forEachEdge(sides, [&](const EdgeSide* first, const EdgeSide* last) {
    int excess = 0;
    for (const EdgeSide* s = first; s != last; ++s) excess += s->forward ? 1 : -1;
    for (; excess != 0; excess += excess > 0 ? -1 : 1) {
      const int a = excess > 0 ? first->low : first->high;
      const int b = excess > 0 ? first->high : first->low;
      mesh.triangles.emplace_back(b, a, a + count);
      mesh.triangles.emplace_back(b, a + count, b + count);
    }
  });
  return mesh;
}

}  // namespace cloudcontact
