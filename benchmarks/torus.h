// The mesh of a torus about z.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cmath>
#include <numbers>

namespace cloudcontact {

inline Mesh torusMesh(double ring, double tube, int along, int around) {
  Mesh mesh;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      const double u = 2 * std::numbers::pi * i / along, v = 2 * std::numbers::pi * j / around;
      const double r = ring + tube * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
    }
  const auto at = [=](int i, int j) { return i % along * around + j % around; };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return mesh;
}

}  // namespace cloudcontact
