// The exact volume of a convex body bounded by planes, face by face: a reference for coverage that
// is independent of the library's depth columns.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace cloudcontact::test {

// Material where normal.x <= offset.
struct Plane {
  Eigen::Vector3d normal;
  double offset;
};

// The planes of a convex mesh's triangles, facing outward.
inline std::vector<Plane> planesOf(const Mesh& convex) {
  std::vector<Plane> planes;
  for (const Eigen::Vector3i& t : convex.triangles) {
    const Eigen::Vector3d& a = convex.vertices[t[0]];
    const Eigen::Vector3d n =
        (convex.vertices[t[1]] - a).cross(convex.vertices[t[2]] - a).normalized();
    const Plane plane{n, n.dot(a)};
    const bool known = std::any_of(planes.begin(), planes.end(), [&](const Plane& p) {
      return (p.normal - n).norm() < 1e-9 && std::abs(p.offset - plane.offset) < 1e-9;
    });
    if (!known) planes.push_back(plane);
  }
  return planes;
}

// The volume of the bounded intersection of distinct half-spaces. Each plane's face is a large
// square clipped by all other planes; the body is a sum of pyramids over its faces.
inline double convexVolume(const std::vector<Plane>& planes, const Eigen::Vector3d& apex,
                           double size) {
  using Eigen::Vector3d;
  double volume = 0;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Vector3d n = planes[i].normal;
    const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    const Vector3d foot = apex + (planes[i].offset - n.dot(apex)) * n;
    std::vector<Vector3d> face = {foot + size * (u + v), foot + size * (v - u),
                                  foot - size * (u + v), foot + size * (u - v)};
    for (std::size_t j = 0; j < planes.size() && !face.empty(); ++j) {
      if (j == i) continue;
      std::vector<Vector3d> kept;
      for (std::size_t k = 0; k < face.size(); ++k) {
        const Vector3d &a = face[k], &b = face[(k + 1) % face.size()];
        const double da = planes[j].normal.dot(a) - planes[j].offset;
        const double db = planes[j].normal.dot(b) - planes[j].offset;
        if (da <= 0) kept.push_back(a);
        if (da * db < 0) kept.push_back(a + da / (da - db) * (b - a));
      }
      face = kept;
    }
    double area = 0;
    for (std::size_t k = 2; k < face.size(); ++k)
      area += 0.5 * n.dot((face[k - 1] - face[0]).cross(face[k] - face[0]));
    volume += area * (planes[i].offset - n.dot(apex)) / 3;
  }
  return volume;
}

// The volume shared by several convex bodies and the voxel with this center and edge, as a fraction
// of the voxel.
inline double commonFraction(std::vector<Plane> planes, const Eigen::Vector3d& center, double h) {
  // Voxels away from all planes need no clipping: half a voxel's diagonal is 0.87 h.
  bool near = false;
  for (const Plane& p : planes) {
    const double outside = p.normal.dot(center) - p.offset;
    if (outside > 0.87 * h) return 0;
    near |= outside > -0.87 * h;
  }
  if (!near) return 1;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) {
      const Plane face{s * Eigen::Vector3d::Unit(k), s * center[k] + 0.5 * h};
      // A plane that coincides with a voxel's face must not count twice.
      const bool known = std::any_of(planes.begin(), planes.end(), [&](const Plane& p) {
        return (p.normal - face.normal).norm() < 1e-9 &&
               std::abs(p.offset - face.offset) < 1e-9 * h;
      });
      if (!known) planes.push_back(face);
    }
  return convexVolume(planes, center, 4 * h) / (h * h * h);
}

}  // namespace cloudcontact::test
