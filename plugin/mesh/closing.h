// Surfaces made closed: holes filled, sheets given a back.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

namespace cloudcontact {

// A surface and the caps that close it.
struct Closing {
  Mesh mesh;                 // triangles of the surface, then the caps
  std::size_t firstCap = 0;  // index of the first cap
  double capArea = 0;        // of all caps [m^2]
  bool wasClosed() const { return firstCap == mesh.triangles.size(); }
};

// Fills each boundary loop of a welded mesh with a cone from the loop's middle. Cracks and
// T-junctions get triangles of almost no area, and a missing facet is restored. The caps also
// cancel reversed and doubled triangles. The result has no boundary, so the sum of every column
// returns to zero.
Closing closeSurface(const Mesh& mesh);

// A mesh whose triangles agree in direction, with a back and walls: a reversed copy with each
// vertex moved by its `behind` [m], and walls along the open edges.
Mesh thickened(Mesh mesh, const std::vector<Eigen::Vector3d>& behind);

}  // namespace cloudcontact
