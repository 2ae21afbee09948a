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

}  // namespace cloudcontact
