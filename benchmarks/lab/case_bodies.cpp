// Random numbers, bodies, poses and placements.
#include "lab/case_bodies.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "lab/lab_meshes.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program::lab {

double Random::uniform(double low, double high) {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return low + (high - low) * double((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// Shoemake 1992, "Uniform random rotations".
Eigen::Quaterniond Random::rotation() {
  const double u = uniform(0, 1), v = uniform(0, 2 * std::numbers::pi),
               w = uniform(0, 2 * std::numbers::pi);
  const double a = std::sqrt(1 - u), b = std::sqrt(u);
  return {a * std::sin(v), a * std::cos(v), b * std::sin(w), b * std::cos(w)};
}

Pose Random::grid(double voxel) {
  const Eigen::Quaterniond turn = rotation();
  const double x = uniform(0, voxel), y = uniform(0, voxel), z = uniform(0, voxel);
  return {turn, {x, y, z}};
}

LabBody primitiveBody(const std::string& name, const Solid& shape, Random& random) {
  LabBody body{
      name, [shape](double tolerance) { return primitiveMesh(shape, tolerance); }, shape, true, {}};
  body.grid = random.grid(1e-3);
  return body;
}

LabBody halfSpaceBody() {
  return {"half-space", {}, HalfSpace{}, true, {}};
}

LabBody meshBody(const std::string& name, std::function<Mesh(double tolerance)> mesh,
                 Random& random, bool convex) {
  LabBody body{name, std::move(mesh), {}, convex, {}};
  body.grid = random.grid(1e-3);
  return body;
}

LabBody torusBody(Random& random, double ring, double wire) {
  const Pose turned{turnZ(random.uniform(0, 2 * std::numbers::pi)), Vec3::Zero()};
  return meshBody(
      "torus", [=](double tolerance) { return moved(torus(ring, wire, tolerance), turned); },
      random);
}

Pose at(double x, double y, double z, const Eigen::Quaterniond& turn) {
  return {turn, {x, y, z}};
}
Eigen::Quaterniond turnX(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitX()));
}
Eigen::Quaterniond turnY(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitY()));
}
Eigen::Quaterniond turnZ(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
}

std::vector<Placement> pressed(const std::vector<double>& depths,
                               const std::function<Pose(double depth)>& pose, const Truth& truth) {
  std::vector<Placement> placements;
  for (const double depth : depths) {
    placements.push_back({pose(depth), truth});
    Truth& known = placements.back().truth;
    if (known.depth) known.depth = depth;
    if (known.deepest) *known.deepest *= depth;
  }
  return placements;
}

std::vector<double> depthsOf(double size, double most) {
  std::vector<double> depths;
  for (const double share : kDepths) depths.push_back(std::min(most, share * size));
  return depths;
}

}  // namespace cloudcontact::program::lab
