// Meshes by formula for tests, and changes to them whose effect is known.
#pragma once

#include <gtest/gtest.h>

#include <cloudcontact/mesh/mesh.h>
#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

namespace cloudcontact::test {

using Eigen::Vector3d;
using Eigen::Vector3i;

inline Mesh boxMesh(const Vector3d& low, const Vector3d& high) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1],
                               i & 4 ? high[2] : low[2]);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

inline Mesh tetrahedronMesh(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                            const Vector3d& d) {
  Mesh mesh{{a, b, c, d}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  if ((b - a).cross(c - a).dot(d - a) < 0)
    for (Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// A geodesic sphere: an octahedron divided `levels` times.
inline Mesh sphereMesh(double radius, int levels) {
  Mesh mesh;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) mesh.vertices.push_back(s * Vector3d::Unit(k));
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, isNew] = middles.try_emplace(std::minmax(a, b), mesh.vertices.size());
      if (isNew) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<Vector3i> finer;
    for (const Vector3i& t : mesh.triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = finer;
  }
  for (Vector3d& v : mesh.vertices) v *= radius;
  return mesh;
}

// A prism of `sides` sides around z, from -height / 2 to height / 2.
inline Mesh cylinderMesh(double radius, double height, int sides) {
  Mesh mesh;
  for (int i = 0; i < sides; ++i)
    for (const double z : {-0.5 * height, 0.5 * height}) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  mesh.vertices.emplace_back(0, 0, -0.5 * height);
  mesh.vertices.emplace_back(0, 0, 0.5 * height);
  for (int i = 0; i < sides; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % sides);
    mesh.triangles.insert(
        mesh.triangles.end(),
        {{a, b, a + 1}, {b, b + 1, a + 1}, {2 * sides, b, a}, {2 * sides + 1, a + 1, b + 1}});
  }
  return mesh;
}

// A flat sheet of n x n squares in the plane z = 0, facing up.
inline Mesh sheetMesh(double edge, int n) {
  Mesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.vertices.emplace_back(edge * x / n, edge * y / n, 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = x + (n + 1) * y, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
    }
  return mesh;
}

inline Mesh moved(Mesh mesh, const Eigen::Quaterniond& turn, const Vector3d& shift) {
  for (Vector3d& v : mesh.vertices) v = turn * v + shift;
  return mesh;
}

inline Mesh turnedInsideOut(Mesh mesh) {
  for (Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

inline Mesh joined(Mesh a, const Mesh& b) {
  const int base = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Vector3i& t : b.triangles) a.triangles.push_back(t + Vector3i::Constant(base));
  return a;
}

// Every triangle with vertices of its own, as in an STL file.
inline Mesh soup(const Mesh& mesh) {
  Mesh result;
  for (const Vector3i& t : mesh.triangles) {
    const int base = static_cast<int>(result.vertices.size());
    for (int k = 0; k < 3; ++k) result.vertices.push_back(mesh.vertices[t[k]]);
    result.triangles.emplace_back(base, base + 1, base + 2);
  }
  return result;
}

// Without `count` random triangles.
inline Mesh withHoles(Mesh mesh, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  mesh.triangles.resize(mesh.triangles.size() - static_cast<std::size_t>(count));
  return mesh;
}

inline Eigen::Quaterniond oddTurn() {
  return Eigen::Quaterniond(0.83, -0.31, 0.42, 0.19).normalized();
}

}  // namespace cloudcontact::test
