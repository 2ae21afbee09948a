// Meshes scaled, merged and validated: see mesh.h.
#include <cloudcontact/mesh/mesh.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace cloudcontact {

void validate(const Mesh& mesh) {
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      throw std::invalid_argument("mesh: vertex " + std::to_string(i) +
                                  " is NaN or infinite; repair the mesh or its exporter");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      if (const int v = mesh.triangles[t][k]; v < 0 || v >= count)
        throw std::invalid_argument("mesh: triangle " + std::to_string(t) + " names vertex " +
                                    std::to_string(v) + ", but there are " + std::to_string(count) +
                                    "; repair the mesh's indices");
}

Mesh Mesh::scaled(const Eigen::Vector3d& factor) const {
  Mesh result = *this;
  for (Eigen::Vector3d& v : result.vertices) v = v.cwiseProduct(factor);
  // A mirror turns a mesh inside out; reversed triangles undo that.
  if (factor.prod() < 0)
    for (Eigen::Vector3i& t : result.triangles) std::swap(t[1], t[2]);
  return result;
}

Mesh merged(const std::vector<NamedMesh>& parts) {
  Mesh all;
  for (const NamedMesh& part : parts) {
    const int base = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), part.mesh.vertices.begin(), part.mesh.vertices.end());
    for (const Eigen::Vector3i& t : part.mesh.triangles)
      all.triangles.push_back(t + Eigen::Vector3i::Constant(base));
  }
  return all;
}

}  // namespace cloudcontact
