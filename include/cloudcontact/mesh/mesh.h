// A triangle mesh, as a file or a generator gives it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace cloudcontact {

// Triangles over shared vertices. The vertices of a triangle run counter-clockwise seen from
// outside. Nothing else is promised: a mesh may be open, have doubled triangles or face the wrong
// way (mesh_repair.h inspects and repairs it).
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;   // [m]
  std::vector<Eigen::Vector3i> triangles;  // three indices into `vertices` each

  // The mesh with every vertex multiplied by `factor`, axis by axis. Triangles still face outward
  // where a negative factor mirrors the mesh.
  Mesh scaled(const Eigen::Vector3d& factor) const;
};

// Throws std::invalid_argument where an index is out of range or a vertex is NaN or infinite.
void validate(const Mesh& mesh);

// From arrays: three coordinates a vertex, three indices a triangle; times `metersPerUnit`. Throws
// std::invalid_argument where a number is missing, and as validate(Mesh) does.
template <typename Coordinates, typename Indices,
          typename = decltype(std::data(std::declval<const Coordinates&>())),
          typename = decltype(std::data(std::declval<const Indices&>()))>
Mesh meshOf(const Coordinates& coordinates, const Indices& indices, double metersPerUnit = 1) {
  if (std::size(coordinates) % 3 != 0 || std::size(indices) % 3 != 0)
    throw std::invalid_argument(
        "mesh: give three coordinates a vertex and three indices a triangle");
  Mesh mesh;
  const auto* const x = std::data(coordinates);
  const auto* const corner = std::data(indices);
  // -1, which no mesh has, for an index that is no int.
  const auto index = [](auto i) {
    const int as = static_cast<int>(i);
    return as >= 0 && static_cast<decltype(i)>(as) == i ? as : -1;
  };
  for (std::size_t i = 0; i < std::size(coordinates); i += 3)
    mesh.vertices.push_back(metersPerUnit * Eigen::Vector3d(x[i], x[i + 1], x[i + 2]));
  for (std::size_t i = 0; i < std::size(indices); i += 3)
    mesh.triangles.emplace_back(index(corner[i]), index(corner[i + 1]), index(corner[i + 2]));
  validate(mesh);
  return mesh;
}

// A part of a mesh file and its name in the file.
struct NamedMesh {
  std::string name;
  Mesh mesh;
};

// All parts as one mesh, in their order.
Mesh merged(const std::vector<NamedMesh>& parts);

}  // namespace cloudcontact
