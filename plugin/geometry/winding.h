// The generalised winding number: the solid angle of all triangles seen from a point, over 4 pi.
// 1 inside and 0 outside of a closed mesh; in between where the mesh is open (Jacobson et al.,
// "Robust inside-outside segmentation using generalized winding numbers", 2013).
#pragma once

#include <cloudcontact/mesh.h>
#include <Eigen/Geometry>

#include <functional>
#include <vector>

namespace cloudcontact {

// The signed solid angle of a triangle seen from `point`, over 4 pi (Van Oosterom and Strackee).
double windingOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                 const Eigen::Vector3d& point);

// Over all triangles: linear in their number. For few points.
double windingNumber(const Mesh& mesh, const Eigen::Vector3d& point);

}  // namespace cloudcontact
