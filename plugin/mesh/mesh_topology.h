// Topology of meshes: welded vertices, edges, components and boundaries.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace cloudcontact {

// The mesh with vertices within `tolerance` [m] merged (0: equal vertices). Degenerate triangles
// and unused vertices are dropped; the order of triangles is kept.
Mesh welded(const Mesh& mesh, double tolerance);

// One side of one triangle.
struct EdgeSide {
  int low, high;  // vertices of the edge, low < high
  int triangle;
  bool forward;  // the triangle runs low -> high
};

// All sides, sorted by (low, high, triangle): the sides of an edge are adjacent.
std::vector<EdgeSide> sortedEdgeSides(const Mesh& mesh);

// Calls visit(first, last) for the sides of each edge.
template <typename Visit>
void forEachEdge(const std::vector<EdgeSide>& sides, Visit&& visit) {
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i + 1;
    while (j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high) ++j;
    visit(sides.data() + i, sides.data() + j);
    i = j;
  }
}

// The component of each triangle, numbered in the order of their first triangles. Two triangles are
// connected where they share an edge that no third triangle has.
std::vector<int> components(const Mesh& mesh, int& count);

// Whether a welded mesh is one component without boundary in which every edge has exactly two
// triangles that agree in direction. May return false where a vertex has very many triangles.
bool isOneClosedSurface(const Mesh& mesh);

// Closed loops of vertices. Surfaces with these loops as boundaries complete the mesh to a surface
// without boundary (a cycle in the sense of homology: a reversed triangle gives a loop that is
// traversed twice, a doubled one a loop that cancels the double).
std::vector<std::vector<int>> boundaryLoops(const Mesh& mesh);

// Six times the signed volume between the mesh and `apex` [m^3].
double sixVolumes(const Mesh& mesh, const Eigen::Vector3d& apex);
double triangleArea(const Mesh& mesh, std::size_t triangle);
double totalArea(const Mesh& mesh);
Eigen::Vector3d middleOf(const Mesh& mesh);  // of the box around all vertices

}  // namespace cloudcontact
