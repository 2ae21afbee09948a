// Boxes from their faces, round bodies from a profile turned about z, spheres as subdivided
// icosahedra.
#include "scene/primitive_mesh.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace cloudcontact::program {

namespace {

constexpr int kMaxSubdivisions = 7;  // of the icosahedron: 327,680 triangles
constexpr int kMaxSlices = 4096;     // about the axis
constexpr int kMaxCapSlices = 512;   // with rings as fine: 264,192 triangles

using Eigen::Vector3i;

Mesh icosahedron() {
  const double g = std::numbers::phi;
  Mesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Vec3& v : mesh.vertices) v.normalize();
  return mesh;
}

// Splits each triangle in four and moves the new corners to the unit sphere.
Mesh subdivided(const Mesh& coarse) {
  Mesh fine;
  fine.vertices = coarse.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, isNew] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(fine.vertices.size()));
    if (isNew) {
      const Vec3 sum = fine.vertices[a] + fine.vertices[b];
      fine.vertices.push_back(sum.normalized());
    }
    return entry->second;
  };
  for (const Vector3i& t : coarse.triangles) {
    const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    for (const Vector3i& part :
         {Vector3i(t[0], a, c), Vector3i(a, t[1], b), Vector3i(c, b, t[2]), Vector3i(a, b, c)})
      fine.triangles.push_back(part);
  }
  return fine;
}

double volumeOf(const Mesh& mesh) {
  double six = 0;
  for (const Vector3i& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6;
}

Mesh sphereMesh(double radius, double tolerance) {
  Mesh mesh = icosahedron();
  // A facet of edge L lies up to L^2 / (6 R) below its sphere. The icosahedron's edge is 1.05 R;
  // the longest edge of a spherical subdivision is about 1.2 that of a flat one.
  int level = 2;
  for (double edge = 1.05 * 1.2 / 4;
       edge * edge / 6 * radius > tolerance && level < kMaxSubdivisions; edge /= 2)
    ++level;
  for (int k = 0; k < level; ++k) mesh = subdivided(mesh);
  const double unit = std::cbrt(4 * std::numbers::pi / 3 / volumeOf(mesh));
  for (Vec3& v : mesh.vertices) v *= radius * unit;
  return mesh;
}

Mesh boxMesh(const Vec3& half) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.push_back(
        {k & 1 ? half.x() : -half.x(), k & 2 ? half.y() : -half.y(), k & 4 ? half.z() : -half.z()});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// Number of slices for which a chord's middle lies at most `tolerance` inside the circle.
int slicesFor(double radius, double tolerance) {
  const double slices = std::numbers::pi * std::sqrt(radius / (2 * tolerance));
  return static_cast<int>(std::clamp(std::ceil(slices), 24.0, double(kMaxSlices)));
}

// A closed body of revolution about z. `profile` holds (radius, z) from the lowest to the highest
// point, with its ends on the axis. Circles become polygons of equal area.
Mesh turned(const std::vector<Eigen::Vector2d>& profile, int slices) {
  const double step = 2 * std::numbers::pi / slices;
  const double widen = std::sqrt(step / std::sin(step));
  Mesh mesh;
  std::vector<int> first;  // vertex of each ring; rings on the axis have one vertex
  for (const Eigen::Vector2d& p : profile) {
    first.push_back(static_cast<int>(mesh.vertices.size()));
    const int count = p[0] > 0 ? slices : 1;
    for (int k = 0; k < count; ++k)
      mesh.vertices.push_back(
          {p[0] * widen * std::cos(k * step), p[0] * widen * std::sin(k * step), p[1]});
  }
  for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring)
    for (int k = 0; k < slices; ++k) {
      const int next = (k + 1) % slices;
      const bool low = profile[ring][0] > 0, high = profile[ring + 1][0] > 0;
      const int a = first[ring] + (low ? k : 0), b = first[ring] + (low ? next : 0);
      const int c = first[ring + 1] + (high ? k : 0), d = first[ring + 1] + (high ? next : 0);
      if (low) mesh.triangles.push_back({a, b, high ? d : c});
      if (high) mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

Mesh capsuleMesh(const Capsule& shape, double tolerance) {
  // A cap curves in two directions; each gets half of the tolerance.
  const int slices = std::min(slicesFor(shape.radius, tolerance / 2), kMaxCapSlices);
  const int rings = std::max(8, slices / 4);
  std::vector<Eigen::Vector2d> profile;
  for (int end : {-1, 1})
    for (int k = 0; k <= rings; ++k) {
      const double angle = std::numbers::pi / 2 * (end < 0 ? k - rings : k) / rings;
      const bool tip = end < 0 ? k == 0 : k == rings;  // exactly on the axis, not within rounding
      profile.push_back({tip ? 0 : shape.radius * std::cos(angle),
                         end * shape.halfHeight + shape.radius * std::sin(angle)});
    }
  return turned(profile, slices);
}

struct Mesher {
  double tolerance;

  Mesh operator()(const Sphere& s) const { return sphereMesh(s.radius, tolerance); }
  Mesh operator()(const Box& s) const { return boxMesh(s.halfExtents); }
  Mesh operator()(const Capsule& s) const { return capsuleMesh(s, tolerance); }
  Mesh operator()(const Cylinder& s) const {
    return turned({{0, -s.halfHeight},
                   {s.radius, -s.halfHeight},
                   {s.radius, s.halfHeight},
                   {0, s.halfHeight}},
                  slicesFor(s.radius, tolerance));
  }
  Mesh operator()(const Cone& s) const {
    return turned({{0, -s.halfHeight}, {s.radius, -s.halfHeight}, {0, s.halfHeight}},
                  slicesFor(s.radius, tolerance));
  }
  template <class Other>
  Mesh operator()(const Other&) const {
    throw std::invalid_argument(
        "a half-space or hull has no mesh here; use a sphere, box, "
        "capsule, cylinder or cone");
  }
};

}  // namespace

Mesh primitiveMesh(const Solid& shape, double tolerance) {
  return std::visit(Mesher{tolerance}, shape);
}

}  // namespace cloudcontact::program
