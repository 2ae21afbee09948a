// A triangle mesh as it comes from a file or a generator, and what must be mended before its
// inside can be told from its outside.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace cloudcontact {

// Triangles over shared vertices. Vertices in metres; each triangle's vertices run
// counter-clockwise seen from outside. Nothing else is promised: a mesh may be open, doubled or
// wrongly turned.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;

  // The mesh with every vertex multiplied by `factor` (per axis), turned and moved by nothing.
  Mesh scaled(const Eigen::Vector3d& factor) const;
};

// A part of a mesh file, by the name that it has there.
struct NamedMesh {
  std::string name;
  Mesh mesh;
};
Mesh merged(const std::vector<NamedMesh>& parts);

// What a look at a mesh's edges and volume tells.
struct MeshReport {
  std::size_t openEdges = 0;      // edges of welded triangles that belong to one triangle only
  std::size_t overusedEdges = 0;  // ... to three or more
  std::size_t degenerateTriangles = 0;  // triangles that weld to a line or a point
  double volume = 0;                    // [m^3] signed, by the divergence theorem
  double area = 0;                      // [m^2]
  bool closed() const { return openEdges == 0 && overusedEdges == 0; }
};

// Throws std::invalid_argument where an index is out of range or a vertex is NaN or infinite.
MeshReport inspect(const Mesh& mesh);

// Vertices within `tolerance` [m] welded, degenerate triangles dropped, neighbouring triangles made
// to agree in their direction, each as most of its component stands; the whole turned outside out
// where its volume is negative. A component that is a cavity (turned against its surroundings on
// purpose) stays so.
Mesh mended(const Mesh& mesh, double tolerance = 0);

// A surface with no inside (a sheet, a terrain) as a closed shell: the faces themselves, their
// copies `thickness` [m] behind them along the vertex normals, and walls along the open edges.
Mesh shell(const Mesh& mesh, double thickness);

// True where so many edges are open that the surface bounds nothing (a sheet rather than a body
// with holes).
bool isSheet(const Mesh& mesh);

}  // namespace cloudcontact
