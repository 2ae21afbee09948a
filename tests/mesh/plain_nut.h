// A nut without its thread: faces, and corners that are sharp, blunt and hollow.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cmath>
#include <numbers>

namespace cloudcontact::testing {

// A hexagonal nut without its thread, by 12 segments, axis z.
inline Mesh plainNut(double acrossCorners, double bore, double height) {
  constexpr int kSegments = 12;
  Mesh mesh;
  for (int i = 0; i < kSegments; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSegments;
    const double outer = acrossCorners / 2 * (i % 2 ? std::cos(std::numbers::pi / 6) : 1);
    for (const double r : {outer, bore / 2})
      for (const double z : {-height / 2, height / 2})
        mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  // Of each segment: outer low, outer high, inner low, inner high.
  const auto quad = [&mesh](int a, int b, int c, int d) {
    mesh.triangles.emplace_back(a, b, c);
    mesh.triangles.emplace_back(a, c, d);
  };
  for (int i = 0; i < kSegments; ++i) {
    const int p = 4 * i, q = 4 * ((i + 1) % kSegments);
    quad(p, q, q + 1, p + 1);
    quad(q + 2, p + 2, p + 3, q + 3);
    quad(p + 1, q + 1, q + 3, p + 3);
    quad(q, p, p + 2, q + 2);
  }
  return mesh;
}

}  // namespace cloudcontact::testing
