// Concave meshes in random poses. There is no closed form; quadrature supplies the force's
// direction and axis.
#include <algorithm>

#include "lab/case_bodies.h"
#include "lab/lab_meshes.h"
#include "lab/oracle.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kSize = 0.01;  // [m]
constexpr int kThrows = 3;

// A chain link of round wire, and a ring with edges.
Mesh link(double tolerance) {
  ChainLink shape{0.6 * kSize, 1.6 * kSize, 2 * kSize, 48, 64};
  shape.around = std::clamp(circleSegments(shape.wire, tolerance), 24, 96);
  shape.along = std::clamp(circleSegments(shape.bend, tolerance) / 2, 24, 96);
  return chainLinkMesh(shape);
}
Mesh ring(double tolerance) {
  const Outline inner = circle(1.4 * kSize, tolerance);
  return tube(inner, polygon(int(inner.size()), 2.2 * kSize), -0.7 * kSize, 0.7 * kSize);
}

Placement thrown(const Mesh& a, const Mesh& b, Random& random) {
  const Vec3 way = random.rotation() * Vec3::UnitZ();
  Pose pose{random.rotation(), -7 * kSize * way};
  const double depth = kDepths[1] * kSize;
  pose.position += distanceUntil(a, b, pose, way, depth, 12 * kSize) * way;
  const OracleForce force = foundationForce(a, b, pose, kSize / 60);
  Truth truth;
  if (!(force.force.norm() > 0)) return {pose, truth};
  truth.direction = force.force.normalized();
  truth.center = force.force.cross(force.torque) / force.force.squaredNorm();
  truth.deepest = force.deepest;
  return {pose, truth};
}

std::vector<Placement> throws(const Mesh& a, const Mesh& b, std::uint64_t seed) {
  Random random(seed);  // equal poses for all grids
  std::vector<Placement> placements;
  for (int k = 0; k < kThrows; ++k) placements.push_back(thrown(a, b, random));
  return placements;
}

constexpr double kFine = kSize / 500;

std::function<Instance(std::uint64_t)> linkOnLink() {
  const auto placements = once<std::vector<Placement>>([] {
    const Mesh mesh = link(kFine);
    return throws(mesh, mesh, 99);
  });
  return [=](std::uint64_t seed) {
    Random random(seed);
    LabBody a = meshBody("link", link, random), b = meshBody("link", link, random);
    return Instance{a, b, placements()};
  };
}

std::function<Instance(std::uint64_t)> ringOnLink() {
  const auto placements =
      once<std::vector<Placement>>([] { return throws(link(kFine), ring(kFine), 101); });
  return [=](std::uint64_t seed) {
    Random random(seed);
    LabBody a = meshBody("link", link, random), b = meshBody("ring", ring, random);
    return Instance{a, b, placements()};
  };
}

}  // namespace

std::vector<LabCase> randomCases() {
  return {{"random", "link thrown on link", false, false, kSize, true, linkOnLink()},
          {"random", "ring thrown on link", false, false, kSize, false, ringOnLink()}};
}

}  // namespace cloudcontact::program::lab
