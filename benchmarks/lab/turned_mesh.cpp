// Rings about z, one a point of the outline, closed by a fan at each end.
#include "lab/turned_mesh.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace cloudcontact::program::lab {

Mesh turnedMesh(const std::vector<Eigen::Vector2d>& outline, int segments) {
  if (outline.size() < 3 || segments < 3)
    throw std::invalid_argument("turnedMesh: needs three points and three segments at least");
  Mesh mesh;
  const int rings = int(outline.size()) - 2;
  for (int k = 1; k <= rings; ++k)
    for (int i = 0; i < segments; ++i) {
      const double angle = 2 * std::numbers::pi * i / segments;
      mesh.vertices.emplace_back(outline[k].x() * std::cos(angle), outline[k].x() * std::sin(angle),
                                 outline[k].y());
    }
  mesh.vertices.emplace_back(0, 0, outline.front().y());
  mesh.vertices.emplace_back(0, 0, outline.back().y());
  const int first = rings * segments, last = first + 1, top = first - segments;
  for (int i = 0; i < segments; ++i) {
    const int j = (i + 1) % segments;
    mesh.triangles.emplace_back(first, j, i);
    mesh.triangles.emplace_back(last, top + i, top + j);
    for (int ring = 0; ring < top; ring += segments) {
      mesh.triangles.emplace_back(ring + i, ring + j, ring + segments + j);
      mesh.triangles.emplace_back(ring + i, ring + segments + j, ring + segments + i);
    }
  }
  return mesh;
}

Mesh bowlMesh(double innerRadius, double outerRadius, int segments) {
  const int steps = segments / 4;
  std::vector<Eigen::Vector2d> outline;
  const auto arc = [&](double radius, int k) {
    const double angle = std::numbers::pi / 2 * k / steps;
    outline.emplace_back(radius * std::sin(angle), -radius * std::cos(angle));
  };
  for (int k = 0; k <= steps; ++k) arc(outerRadius, k);
  for (int k = steps; k >= 0; --k) arc(innerRadius, k);
  return turnedMesh(outline, segments);
}

}  // namespace cloudcontact::program::lab
