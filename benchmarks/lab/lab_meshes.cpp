// Extrusion, revolution and gear teeth; caps are triangulated by ear clipping.
#include "lab/lab_meshes.h"

#include <cloudcontact/mesh/mesh_repair.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

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

// The strip between two rings of n vertices that start at a and b.
void addStrip(Mesh& mesh, int a, int b, int n) {
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.emplace_back(a + i, a + j, b + j);
    mesh.triangles.emplace_back(a + i, b + j, b + i);
  }
}

double involute(double angle) {
  return std::tan(angle) - angle;
}

// Half the angle of a tooth at `radius`, on or outside the base circle.
double halfTooth(const Gear& gear, double radius) {
  const double base = gear.pitchRadius() * std::cos(gear.pressureAngle);
  const double atPitch = (kPi * gear.module / 2 - gear.thinned) / (2 * gear.pitchRadius());
  return atPitch + involute(gear.pressureAngle) - involute(std::acos(base / radius));
}

// Outline in (radius, angle), counter-clockwise.
std::vector<Eigen::Vector2d> outline(const Gear& gear) {
  const double base = gear.pitchRadius() * std::cos(gear.pressureAngle) * (1 + 1e-9);
  const double tip = gear.pitchRadius() + gear.module;
  const double root = gear.pitchRadius() - 1.25 * gear.module;
  const double foot = std::max(base, root);
  // There is no involute inside the base circle. There the flank widens a little toward the root:
  // that clears the other gear's tips, and no two points have equal angles.
  const double atFoot = halfTooth(gear, foot);
  const double atRoot = atFoot + 0.15 * (kPi / gear.teeth - atFoot);
  std::vector<Eigen::Vector2d> points;
  for (int tooth = 0; tooth < gear.teeth; ++tooth) {
    const double middle = 2 * kPi * tooth / gear.teeth;
    const auto radius = [&](int k) { return foot + (tip - foot) * k / gear.flankSteps; };
    points.emplace_back(root, middle - atRoot);
    for (int k = 0; k <= gear.flankSteps; ++k)
      points.emplace_back(radius(k), middle - halfTooth(gear, radius(k)));
    points.emplace_back(tip, middle);
    for (int k = gear.flankSteps; k >= 0; --k)
      points.emplace_back(radius(k), middle + halfTooth(gear, radius(k)));
    points.emplace_back(root, middle + atRoot);
  }
  return points;
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
  // A polygon with circumradius r has the area n / 2 r^2 sin(2 pi / n).
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

Mesh turnedMesh(const std::vector<Eigen::Vector2d>& outline, int segments) {
  if (outline.size() < 3 || segments < 3)
    throw std::invalid_argument("turnedMesh: needs at least three points and three segments");
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

Mesh taperedMesh(const Eigen::Vector2d& bottom, const Eigen::Vector2d& top, double height) {
  Mesh mesh;
  for (const double z : {0.0, height}) {
    const Eigen::Vector2d half = (z > 0 ? top : bottom) / 2;
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      mesh.vertices.emplace_back(x * half.x(), y * half.y(), z);
  }
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (int k = 0; k < 4; ++k) {
    const int n = (k + 1) % 4;
    mesh.triangles.emplace_back(k, n, n + 4);
    mesh.triangles.emplace_back(k, n + 4, k + 4);
  }
  return mended(mesh);  // merges the four corners of a tip, removes its empty triangles
}

Mesh prismMesh(const Outline& outline, double width) {
  Mesh mesh = prism(outline, -width / 2, width / 2);
  for (Vec3& v : mesh.vertices) v = Vec3(v.x(), -v.z(), v.y());
  return mesh;
}

Mesh gearMesh(const Gear& gear) {
  if (gear.teeth < 17 || !(gear.module > 0) || !(gear.width > 0) || gear.flankSteps < 1)
    throw std::invalid_argument(
        "gearMesh: needs 17 teeth or more, a positive module and width and flankSteps >= 1");
  const std::vector<Eigen::Vector2d> points = outline(gear);
  const int n = int(points.size());
  Mesh mesh;
  for (const double z : {-gear.width / 2, gear.width / 2}) {
    for (const auto& p : points)
      mesh.vertices.emplace_back(p.x() * std::cos(p.y()), p.x() * std::sin(p.y()), z);
    mesh.vertices.emplace_back(0, 0, z);
  }
  const int low = n, high = 2 * n + 1;  // centers of the faces; the upper outline starts at n + 1
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.emplace_back(low, j, i);
    mesh.triangles.emplace_back(high, n + 1 + i, n + 1 + j);
    mesh.triangles.emplace_back(i, j, n + 1 + j);
    mesh.triangles.emplace_back(i, n + 1 + j, n + 1 + i);
  }
  return mesh;
}

Mesh moved(Mesh mesh, const Pose& pose) {
  for (Vec3& v : mesh.vertices) v = pose.toWorld(v);
  return mesh;
}

}  // namespace cloudcontact::program::lab
