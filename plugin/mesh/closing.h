// What is missing from a surface, filled in.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

namespace cloudcontact {

struct Closing {
  Mesh mesh;                 // the surface, then the triangles that close it
  std::size_t firstCap = 0;  // index of the first of those
  double capArea = 0;        // their area [m^2]
  bool wasClosed() const { return firstCap == mesh.triangles.size(); }
};

// Fills each loop of a welded mesh's boundary by a cone from the loop's middle. Cracks and
// T-junctions get triangles of (almost) no area, a hole the size of a facet gets that facet, a
// wrongly turned triangle is turned, a doubled one taken away: what comes out is a surface without
// boundary, of which every column's sum comes back to zero.
Closing closeSurface(const Mesh& mesh);

// The mesh, whose triangles agree in direction, with a back and walls: its copy, each vertex moved
// by its `behind` [m] and reversed, and walls along the open edges.
Mesh thickened(Mesh mesh, const std::vector<Eigen::Vector3d>& behind);

}  // namespace cloudcontact
