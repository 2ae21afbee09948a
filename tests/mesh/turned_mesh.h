// Closed meshes of bodies of revolution.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace cloudcontact::test {

// About z. The profile's points (r, z) go from the bottom of the axis to its top, r = 0 at both.
inline Mesh turnedMesh(const std::vector<std::pair<double, double>>& profile, int sides) {
  Mesh mesh;
  const int rings = static_cast<int>(profile.size()) - 2;
  mesh.vertices.emplace_back(0, 0, profile.front().second);
  for (int ring = 1; ring <= rings; ++ring)
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      const auto& [r, z] = profile[static_cast<std::size_t>(ring)];
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  mesh.vertices.emplace_back(0, 0, profile.back().second);
  const int top = static_cast<int>(mesh.vertices.size()) - 1;
  const auto at = [sides](int ring, int i) { return 1 + ring * sides + i % sides; };
  for (int i = 0; i < sides; ++i) {
    mesh.triangles.emplace_back(0, at(0, i + 1), at(0, i));
    for (int ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.emplace_back(at(ring, i), at(ring, i + 1), at(ring + 1, i + 1));
      mesh.triangles.emplace_back(at(ring, i), at(ring + 1, i + 1), at(ring + 1, i));
    }
    mesh.triangles.emplace_back(top, at(rings - 1, i), at(rings - 1, i + 1));
  }
  return mesh;
}

inline Mesh roundMesh(double radius, double height, int sides) {
  return turnedMesh(
      {{0, -height / 2}, {radius, -height / 2}, {radius, height / 2}, {0, height / 2}}, sides);
}

inline Mesh capsuleMesh(double radius, double halfHeight, int sides) {
  std::vector<std::pair<double, double>> profile;
  const int arcs = sides / 4;
  for (int end = -1; end <= 1; end += 2)
    for (int k = 0; k <= arcs; ++k) {
      const double angle = std::numbers::pi / 2 * (end < 0 ? k - arcs : k) / arcs;
      const bool pole = (end < 0 && k == 0) || (end > 0 && k == arcs);
      profile.emplace_back(pole ? 0 : radius * std::cos(angle),
                           end * halfHeight + radius * std::sin(angle));
    }
  return turnedMesh(profile, sides);
}

// The base at -halfHeight, the tip at +halfHeight.
inline Mesh coneMesh(double radius, double halfHeight, int sides) {
  return turnedMesh({{0, -halfHeight}, {radius, -halfHeight}, {0, halfHeight}}, sides);
}

}  // namespace cloudcontact::test
