// Caps of outlines that are not convex are cut into triangles ear by ear.
#include "lab/solids.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool isEar(const Outline& p, const std::vector<int>& left, std::size_t k) {
  const std::size_t n = left.size();
  const int a = left[(k + n - 1) % n], b = left[k], c = left[(k + 1) % n];
  if (cross(p[a], p[b], p[c]) <= 0) return false;
  return std::none_of(left.begin(), left.end(), [&](int i) {
    return i != a && i != b && i != c && cross(p[a], p[b], p[i]) >= 0 &&
           cross(p[b], p[c], p[i]) >= 0 && cross(p[c], p[a], p[i]) >= 0;
  });
}

std::vector<Eigen::Vector3i> triangulated(const Outline& outline) {
  std::vector<int> left(outline.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = static_cast<int>(i);
  std::vector<Eigen::Vector3i> triangles;
  while (left.size() > 3) {
    std::size_t k = 0;
    while (k + 1 < left.size() && !isEar(outline, left, k)) ++k;
    const std::size_t n = left.size();
    triangles.emplace_back(left[(k + n - 1) % n], left[k], left[(k + 1) % n]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
  }
  triangles.emplace_back(left[0], left[1], left[2]);
  return triangles;
}

void addRing(Mesh& mesh, const Outline& outline, double z) {
  for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
}

// The strip between two rings of n points that start at a and b, seen from outside.
void addStrip(Mesh& mesh, int a, int b, int n) {
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.emplace_back(a + i, a + j, b + j);
    mesh.triangles.emplace_back(a + i, b + j, b + i);
  }
}

}  // namespace

Outline polygon(int corners, double inner, double turn) {
  Outline outline;
  const double radius = inner / std::cos(kPi / corners);
  for (int i = 0; i < corners; ++i) {
    const double angle = turn + 2 * kPi * i / corners;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return outline;
}

int circleSegments(double radius, double tolerance) {
  const double angle = std::acos(std::clamp(1 - tolerance / radius, 0.5, 1 - 1e-9));
  return std::clamp(4 * static_cast<int>(std::ceil(kPi / angle / 4)), 16, 2048);
}

Outline circle(double radius, double tolerance) {
  const int n = circleSegments(radius, tolerance);
  // n / 2 r^2 sin(2 pi / n) is a polygon's area by its corners' radius.
  const double share = 2 * kPi / n;
  const double corner = radius * std::sqrt(share / std::sin(share));
  return polygon(n, corner * std::cos(kPi / n));
}

Mesh prism(const Outline& outline, double low, double high) {
  Mesh mesh;
  const int n = static_cast<int>(outline.size());
  addRing(mesh, outline, low);
  addRing(mesh, outline, high);
  addStrip(mesh, 0, n, n);
  for (const Eigen::Vector3i& t : triangulated(outline)) {
    mesh.triangles.emplace_back(t[0], t[2], t[1]);
    mesh.triangles.emplace_back(n + t[0], n + t[1], n + t[2]);
  }
  return mesh;
}

Mesh tube(const Outline& inner, const Outline& outer, double low, double high) {
  Mesh mesh;
  const int n = static_cast<int>(inner.size());
  addRing(mesh, outer, low);
  addRing(mesh, outer, high);
  addRing(mesh, inner, high);
  addRing(mesh, inner, low);
  for (int k = 0; k < 4; ++k) addStrip(mesh, k * n, (k + 1) % 4 * n, n);
  return mesh;
}

Mesh revolved(const Outline& section, int segments) {
  Mesh mesh;
  const int n = static_cast<int>(section.size());
  for (int s = 0; s < segments; ++s) {
    const double angle = 2 * kPi * s / segments;
    for (const auto& p : section)
      mesh.vertices.emplace_back(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
  }
  for (int s = 0; s < segments; ++s) addStrip(mesh, (s + 1) % segments * n, s * n, n);
  return mesh;
}

Mesh torus(double ring, double tubeRadius, double tolerance) {
  Outline section = circle(tubeRadius, tolerance);
  for (auto& p : section) p.x() += ring;
  return revolved(section, circleSegments(ring + tubeRadius, tolerance));
}

Mesh moved(Mesh mesh, const Pose& pose) {
  for (Vec3& v : mesh.vertices) v = pose.toWorld(v);
  return mesh;
}

}  // namespace cloudcontact::program::lab
