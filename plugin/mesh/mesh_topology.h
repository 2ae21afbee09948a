// How a mesh's triangles hang together: welded vertices, edges, components and open boundaries.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace cloudcontact {

// The mesh with vertices within `tolerance` [m] made one (0: equal ones), triangles that shrink to
// a line or a point dropped, unused vertices dropped. The order of triangles is kept.
Mesh welded(const Mesh& mesh, double tolerance);

// One side of one triangle. Sorted by (low, high, triangle), sides of one edge stand together.
struct EdgeSide {
  int low, high;  // vertices of the edge, low < high
  int triangle;
  bool forward;  // the triangle runs low -> high
};
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

// The component of each triangle, numbered in the order of their first triangles. Triangles belong
// together where they share an edge that is theirs alone.
std::vector<int> components(const Mesh& mesh, int& count);

// Whether a welded mesh is one surface without boundary, every edge of which two triangles share
// that agree in their direction. May say no where a vertex has very many triangles.
bool isOneClosedSurface(const Mesh& mesh);

// Closed loops of vertices that, each filled by a surface that runs along the loop, complete the
// mesh to a surface without boundary (a cycle in the sense of homology: a wrongly turned triangle
// shows as a loop run twice, a doubled one as a loop that takes the double away).
std::vector<std::vector<int>> boundaryLoops(const Mesh& mesh);

// Six times the signed volume between the mesh and `apex` [m^3].
double sixVolumes(const Mesh& mesh, const Eigen::Vector3d& apex);
double triangleArea(const Mesh& mesh, std::size_t triangle);
double totalArea(const Mesh& mesh);
Eigen::Vector3d middleOf(const Mesh& mesh);  // of the box around all vertices

}  // namespace cloudcontact
