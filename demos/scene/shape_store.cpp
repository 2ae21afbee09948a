// FNV-1a over vertices and triangles.
#include "scene/shape_store.h"

#include <cstdint>

namespace cloudcontact::program {

std::string contentKey(const Mesh& mesh) {
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&](const void* data, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
  };
  for (const Vec3& v : mesh.vertices) add(v.data(), 3 * sizeof(double));
  for (const Eigen::Vector3i& t : mesh.triangles) add(t.data(), 3 * sizeof(int));
  return std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.triangles.size()) + " " +
         std::to_string(hash);
}

std::shared_ptr<ShapeStore> commonStore() {
  static const auto store = std::make_shared<ShapeStore>();
  return store;
}

}  // namespace cloudcontact::program
