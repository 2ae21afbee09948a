// Signed distance of a point to a triangle mesh, in double and without voxels. It measures a
// simulation's penetration.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact::program {

// A tree of boxes over the triangles finds the closest point. The angle-weighted pseudo-normal of
// its face, edge or vertex gives the sign (Baerentzen and Aanaes 2005, "Signed distance computation
// using the angle weighted pseudonormal"). At edges without exactly two faces the generalized
// winding number gives the sign, so slits in a mesh do no harm.
class MeshDistance {
 public:
  // Throws std::invalid_argument if no triangle has an area.
  explicit MeshDistance(const Mesh& mesh);

  // Depth of a point: positive inside, minus the distance outside [m]. For points farther out than
  // `reach`, any value below -reach. `hint` is any triangle, best a close one, and is set to the
  // closest one: queries in spatial order then take half the time.
  double depth(const Vec3& point, double reach, int* hint = nullptr) const;
  // Winding number, 1 inside and 0 outside a closed mesh. Visits every triangle.
  double winding(const Vec3& point) const;
  const Eigen::AlignedBox3d& bounds() const { return nodes_.front().box; }

 private:
  // The closest point of a triangle. `feature`: 0 face, 1..3 edge after corner, 4..6 corner.
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

// The mesh's vertices, and about `wanted` points spread evenly over its area.
std::vector<Vec3> surfacePoints(const Mesh& mesh, int wanted);

}  // namespace cloudcontact::program
