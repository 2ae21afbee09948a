// Backs and walls: see thicken.h.
#include "mesh/thicken.h"

#include "mesh/mesh_topology.h"

namespace cloudcontact {

Mesh thickened(Mesh mesh, const std::vector<Eigen::Vector3d>& behind) {
  const std::vector<EdgeSide> sides = sortedEdgeSides(mesh);
  const int count = static_cast<int>(mesh.vertices.size());
  for (int v = 0; v < count; ++v)
    mesh.vertices.push_back(mesh.vertices[v] + behind[static_cast<std::size_t>(v)]);
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
