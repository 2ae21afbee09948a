// The generalized winding number: the solid angle of all triangles seen from a point, over 4 pi. It
// is 1 inside and 0 outside of a closed mesh, and in between where the mesh is open (Jacobson et
// al., "Robust inside-outside segmentation using generalized winding numbers", 2013).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

#include <vector>

namespace cloudcontact {

// The signed solid angle of a triangle seen from `point`, over 4 pi (Van Oosterom and Strackee).
double windingOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                 const Eigen::Vector3d& point);

// The sum over all triangles, in linear time. For few points.
double windingNumber(const Mesh& mesh, const Eigen::Vector3d& point);

// The same for many points, right to about 0.01: far groups of triangles count as one dipole
// (Barill et al., "Fast winding numbers for soups and clouds", 2018, first order).
class WindingTree {
 public:
  // Copies the triangles.
  WindingTree(const std::vector<Eigen::Vector3d>& vertices,
              const std::vector<Eigen::Vector3i>& triangles);
  double at(const Eigen::Vector3d& point) const;

 private:
  struct Triangle {
    Eigen::Vector3d a, b, c;
    Eigen::Vector3d centroid() const { return (a + b + c) / 3; }
    Eigen::Vector3d areaVector() const { return 0.5 * (b - a).cross(c - a); }
  };
  // The children of node i are i + 1 and `second`; `second` is 0 for a leaf.
  struct Node {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();      // of the triangles, by area
    Eigen::Vector3d areaVector = Eigen::Vector3d::Zero();  // sum of area times normal
    double radius = 0;                                     // from the center to the farthest corner
    std::size_t first = 0, last = 0;                       // triangles
    std::size_t second = 0;
  };
  void build(std::size_t first, std::size_t last);
  double sum(std::size_t node, const Eigen::Vector3d& point) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace cloudcontact
