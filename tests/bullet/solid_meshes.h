// Meshes whose mass, center of mass and moments are known in closed form.
#pragma once

#include <cloudcontact/base/mass_properties.h>
#include <cloudcontact/mesh/mesh.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace cloudcontact::testing {

// Axis-aligned.
struct SolidBox {
  Vec3 low, high;

  double mass() const { return (high - low).prod(); }  // at a density of 1 kg/m^3
  Vec3 center() const { return (low + high) / 2; }
};

// Of boxes that do not overlap, at a density of 1 kg/m^3.
inline MassProperties matterOfBoxes(const std::vector<SolidBox>& boxes) {
  MassProperties sum;
  for (const SolidBox& box : boxes) {
    sum.mass += box.mass();
    sum.centerOfMass += box.mass() * box.center();
  }
  sum.volume = sum.mass;
  sum.centerOfMass /= sum.mass;
  for (const SolidBox& box : boxes) {
    const Vec3 e = box.high - box.low, r = box.center() - sum.centerOfMass;
    const Vec3 square = e.cwiseProduct(e);
    const Vec3 own = (Vec3::Constant(square.sum()) - square) / 12;
    sum.inertia += box.mass() * (Eigen::Matrix3d(own.asDiagonal()) +
                                 r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return sum;
}

// An L: two arms of different lengths from the origin along x and y, `thick` wide, `height` high.
inline std::vector<SolidBox> angleBoxes(double x, double y, double thick, double height) {
  return {{Vec3::Zero(), {x, thick, height}}, {{0, thick, 0}, {thick, y, height}}};
}

inline Mesh angleMesh(double x, double y, double thick, double height) {
  const double corners[6][2] = {{0, 0}, {x, 0}, {x, thick}, {thick, thick}, {thick, y}, {0, y}};
  Mesh mesh;
  for (const double z : {0.0, height})
    for (const auto& c : corners) mesh.vertices.emplace_back(c[0], c[1], z);
  for (int i = 0; i < 6; ++i) {
    const int next = (i + 1) % 6;
    mesh.triangles.insert(mesh.triangles.end(), {{i, next, next + 6}, {i, next + 6, i + 6}});
  }
  for (const auto& t : {Eigen::Vector3i(0, 1, 2), Eigen::Vector3i(0, 2, 3),
                        Eigen::Vector3i(0, 3, 4), Eigen::Vector3i(0, 4, 5)})
    mesh.triangles.insert(mesh.triangles.end(),
                          {{t[0], t[2], t[1]}, {t[0] + 6, t[1] + 6, t[2] + 6}});
  return mesh;
}

// Its base is at the origin, its tip on z. The facets keep the volume.
inline Mesh coneMesh(double radius, double height, int sides) {
  const double angle = 2 * std::numbers::pi / sides;
  const double r = radius * std::sqrt(angle / std::sin(angle));
  Mesh mesh;
  for (int i = 0; i < sides; ++i)
    mesh.vertices.emplace_back(r * std::cos(i * angle), r * std::sin(i * angle), 0);
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(0, 0, height);
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    mesh.triangles.insert(mesh.triangles.end(), {{sides, next, i}, {sides + 1, i, next}});
  }
  return mesh;
}

}  // namespace cloudcontact::testing
