// The signed distance of a point to a triangle mesh, in double and independent of any voxels: the
// yardstick by which a simulation's penetration is measured.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact::program {

// A tree of boxes over the triangles finds the closest point; the angle-weighted pseudo-normal of
// the face, edge or vertex it lies on tells inside from outside (Baerentzen and Aanaes 2005,
// "Signed distance computation using the angle weighted pseudonormal"). Where that feature belongs
// to an edge without exactly two faces, the generalised winding number over all triangles decides
// instead, so that slits in a mesh do no harm.
class MeshDistance {
 public:
  // Throws std::invalid_argument where no triangle has an area.
  explicit MeshDistance(const Mesh& mesh);

  // Depth of a point: positive inside, minus the distance outside [m]. Points further out than
  // `reach` may be answered with any value below -reach. `hint` is a triangle that may be close
  // (any valid index), and becomes the closest: neighbouring points in turn halve the search.
  double depth(const Vec3& point, double reach, int* hint = nullptr) const;
  // Winding number, 1 inside and 0 outside a closed mesh. Sums over every triangle.
  double winding(const Vec3& point) const;
  const Eigen::AlignedBox3d& bounds() const { return nodes_.front().box; }

 private:
  // Where a point's closest point on a triangle lies: 0 face, 1..3 edge after corner, 4..6 corner.
  struct Closest {
    double squared;
    int triangle;
    int feature;
    Vec3 point;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    int first = 0, count = 0;  // a leaf's triangles; count 0: children at first and first + 1
  };

  void weld(const Mesh& mesh);
  void pseudoNormals();
  void build(int node, int first, int count, std::vector<Vec3>& centers);
  Closest closest(const Vec3& point, int hint) const;
  void closestInTriangle(int triangle, const Vec3& point, Closest& best) const;

  std::vector<Vec3> vertices_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<Vec3> faceNormal_;
  std::vector<std::array<Vec3, 3>> edgeNormal_;  // of the edge after each corner
  std::vector<Vec3> vertexNormal_;
  std::vector<std::array<std::uint8_t, 3>> edgeBad_;
  std::vector<std::uint8_t> vertexBad_;
  std::vector<Node> nodes_;
};

// The mesh's vertices, and points spread over those triangles that are larger than the cells of a
// grid of `wanted` points over its area.
std::vector<Vec3> surfacePoints(const Mesh& mesh, int wanted);

}  // namespace cloudcontact::program
