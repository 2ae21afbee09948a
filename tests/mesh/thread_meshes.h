// Meshes of a threaded rod and of a ring with the same thread inside, for pairs like a nut on its
// bolt.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <cmath>
#include <numbers>

namespace cloudcontact {

// A thread about z: flanks of 30 deg to the cross-section, `pitch` [m] per turn, crests at `radius`
// [m].
struct Thread {
  double radius = 8e-3, pitch = 2e-3, depth = 1.1e-3;

  double at(double angle, double z) const {
    const double turn = z / pitch - angle / (2 * std::numbers::pi);
    const double rise = 2 * std::abs(turn - std::floor(turn) - 0.5);  // 0 at a crest, 1 at a root
    return radius - depth * rise;
  }
};

// A closed surface around z: `place(angle, s)` for s in 0..1 along a profile. The
// profile is a closed curve where `ring` is set, otherwise it begins and ends on the axis.
template <typename Place>
Mesh revolvedMesh(int around, int along, bool ring, const Place& place) {
  Mesh mesh;
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i)
      mesh.vertices.push_back(
          place(2 * std::numbers::pi * i / around, double(j) / (ring ? along : along - 1)));
  const auto at = [&](int i, int j) { return j % along * around + i % around; };
  for (int j = 0; j < (ring ? along : along - 1); ++j)
    for (int i = 0; i < around; ++i) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return mesh;
}

inline Mesh threadedRod(const Thread& thread, double length, int around = 180, int along = 240) {
  return revolvedMesh(around, along, false, [&](double angle, double s) {
    const double u = s * (along - 1);  // the first and the last point are on the axis
    const double z = length * (std::min(std::max(u - 1, 0.0), along - 3.0) / (along - 3) - 0.5);
    const double r = u < 0.5 || u > along - 1.5 ? 0.0 : thread.at(angle, z);
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  });
}

// `play` [m] wider than the rod; `outer` radius.
inline Mesh threadedRing(const Thread& thread, double height, double outer, double play,
                         int around = 180, int along = 240) {
  return revolvedMesh(around, along, true, [&](double angle, double s) {
    const bool inside = s < 0.5;
    const double part = inside ? 2 * s : 2 - 2 * s;
    const double z = height * (std::min(part * along / (along - 2.0), 1.0) - 0.5);
    const double r = inside ? thread.at(angle, z) + play : outer;
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  });
}

}  // namespace cloudcontact
