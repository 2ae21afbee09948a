// A triangle mesh, as a file or a generator gives it.
#pragma once

#include <Eigen/Core>
#include <string>
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

// A part of a mesh file and its name in the file.
struct NamedMesh {
  std::string name;
  Mesh mesh;
};

// All parts as one mesh, in their order.
Mesh merged(const std::vector<NamedMesh>& parts);

}  // namespace cloudcontact
