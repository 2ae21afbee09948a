// Hulls by their planes, for tests: corners by trying all triples, faces by their angles.
#pragma once

#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace cloudcontact::test {

// The corners on a plane, counterclockwise seen from outside.
inline std::vector<int> cornersOn(const Hull& hull, const HalfSpace& plane) {
  std::vector<int> on;
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < hull.corners.size(); ++i)
    if (std::abs(plane.normal.dot(hull.corners[i]) - plane.offset) < 1e-9) {
      on.push_back(static_cast<int>(i));
      middle += hull.corners[i];
    }
  if (on.empty()) return on;
  middle /= static_cast<double>(on.size());
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  const auto angle = [&](int i) {
    const Vec3 out = hull.corners[static_cast<std::size_t>(i)] - middle;
    return std::atan2(out.dot(v), out.dot(u));
  };
  std::sort(on.begin(), on.end(), [&](int i, int j) { return angle(i) < angle(j); });
  return on;
}

// The body inside all planes, which must be bounded; planes that it does not reach are left out.
inline Hull hullOf(const std::vector<HalfSpace>& planes) {
  Hull hull;
  const std::size_t n = planes.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        Eigen::Matrix3d m;
        m << planes[i].normal.transpose(), planes[j].normal.transpose(),
            planes[k].normal.transpose();
        if (std::abs(m.determinant()) < 1e-6) continue;
        const Vec3 at = m.inverse() * Vec3(planes[i].offset, planes[j].offset, planes[k].offset);
        const auto out = [&](const HalfSpace& p) { return p.normal.dot(at) > p.offset + 1e-10; };
        const auto same = [&](const Vec3& other) { return (other - at).norm() < 1e-9; };
        if (std::none_of(planes.begin(), planes.end(), out) &&
            std::none_of(hull.corners.begin(), hull.corners.end(), same))
          hull.corners.push_back(at);
      }
  for (const HalfSpace& plane : planes) {
    const std::vector<int> face = cornersOn(hull, plane);
    if (face.size() < 3) continue;
    hull.planes.push_back(plane);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const int from = face[i], to = face[(i + 1) % face.size()];
      if (from < to) hull.edges.emplace_back(from, to);  // the other face has it turned round
    }
  }
  return hull;
}

inline Mesh meshOf(const Hull& hull) {
  Mesh mesh;
  mesh.vertices = hull.corners;
  for (const HalfSpace& plane : hull.planes) {
    const std::vector<int> face = cornersOn(hull, plane);
    for (std::size_t i = 2; i < face.size(); ++i)
      mesh.triangles.emplace_back(face[0], face[i - 1], face[i]);
  }
  return mesh;
}

inline HalfSpace facing(const Vec3& way, double offset) {
  return {way.normalized(), offset};
}

inline Hull boxHull(const Vec3& half) {
  std::vector<HalfSpace> planes;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0}) planes.push_back({side * Vec3::Unit(axis), half[axis]});
  return hullOf(planes);
}

// A regular prism about z.
inline Hull prismHull(int sides, double inner, double halfHeight) {
  std::vector<HalfSpace> planes = {{Vec3::UnitZ(), halfHeight}, {-Vec3::UnitZ(), halfHeight}};
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    planes.push_back({Vec3(std::cos(angle), std::sin(angle), 0), inner});
  }
  return hullOf(planes);
}

// Between `faces` planes, of random directions, and a box of `size`, so 0.7 to 1 `size` thick.
inline Hull randomHull(int faces, double size, std::mt19937& random) {
  std::uniform_real_distribution<double> even(0, 1);
  std::normal_distribution<double> any;
  std::vector<HalfSpace> planes = boxHull(Vec3::Constant(size)).planes;
  for (int k = 0; k < faces; ++k) {
    const Vec3 way(any(random), any(random), any(random));
    planes.push_back(facing(way, size * (0.7 + 0.3 * even(random))));
  }
  return hullOf(planes);
}

}  // namespace cloudcontact::test
