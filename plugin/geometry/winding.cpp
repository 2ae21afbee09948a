// The generalised winding number: see winding.h.
#include "geometry/winding.h"

#include <cmath>
#include <numbers>

namespace cloudcontact {

using Eigen::Vector3d;

double windingOf(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& point) {
  const Vector3d u = a - point, v = b - point, w = c - point;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  const double numerator = u.dot(v.cross(w));
  const double denominator = lu * lv * lw + u.dot(v) * lw + v.dot(w) * lu + w.dot(u) * lv;
  return std::atan2(numerator, denominator) / (2 * std::numbers::pi);
}

double windingNumber(const Mesh& mesh, const Vector3d& point) {
  double sum = 0;
  for (const Eigen::Vector3i& t : mesh.triangles)
    sum += windingOf(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], point);
  return sum;
}

}  // namespace cloudcontact
