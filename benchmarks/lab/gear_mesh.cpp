// The outline of one tooth after the other, then two flat faces and the wall between them.
#include "lab/gear_mesh.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;

double involute(double angle) {
  return std::tan(angle) - angle;
}

// Half the angle that a tooth takes at `radius`, on or outside the base circle.
double halfTooth(const Gear& gear, double radius) {
  const double base = gear.pitchRadius() * std::cos(gear.pressureAngle);
  const double atPitch = (kPi * gear.module / 2 - gear.thinned) / (2 * gear.pitchRadius());
  return atPitch + involute(gear.pressureAngle) - involute(std::acos(base / radius));
}

// Counter-clockwise, (radius, angle).
std::vector<Eigen::Vector2d> outline(const Gear& gear) {
  const double base = gear.pitchRadius() * std::cos(gear.pressureAngle) * (1 + 1e-9);
  const double tip = gear.pitchRadius() + gear.module;
  const double root = gear.pitchRadius() - 1.25 * gear.module;
  const double foot = std::max(base, root);
  // Inside the base circle there is no involute. A flank that widens a little toward the root
  // keeps clear of the other's tips and leaves no two points at one angle.
  const double atFoot = halfTooth(gear, foot);
  const double atRoot = atFoot + 0.15 * (kPi / gear.teeth - atFoot);
  std::vector<Eigen::Vector2d> points;
  for (int tooth = 0; tooth < gear.teeth; ++tooth) {
    const double middle = 2 * kPi * tooth / gear.teeth;
    const auto radius = [&](int k) { return foot + (tip - foot) * k / gear.flankSteps; };
    points.emplace_back(root, middle - atRoot);
    for (int k = 0; k <= gear.flankSteps; ++k)
      points.emplace_back(radius(k), middle - halfTooth(gear, radius(k)));
    points.emplace_back(tip, middle);
    for (int k = gear.flankSteps; k >= 0; --k)
      points.emplace_back(radius(k), middle + halfTooth(gear, radius(k)));
    points.emplace_back(root, middle + atRoot);
  }
  return points;
}

}  // namespace

Mesh gearMesh(const Gear& gear) {
  if (gear.teeth < 17 || !(gear.module > 0) || !(gear.width > 0) || gear.flankSteps < 1)
    throw std::invalid_argument(
        "gearMesh: needs 17 teeth or more, a positive module and width and flankSteps >= 1");
  const std::vector<Eigen::Vector2d> points = outline(gear);
  const int n = int(points.size());
  Mesh mesh;
  for (const double z : {-gear.width / 2, gear.width / 2}) {
    for (const auto& p : points)
      mesh.vertices.emplace_back(p.x() * std::cos(p.y()), p.x() * std::sin(p.y()), z);
    mesh.vertices.emplace_back(0, 0, z);
  }
  const int low = n, high = 2 * n + 1;  // the faces' middles; the upper outline starts at n + 1
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.emplace_back(low, j, i);
    mesh.triangles.emplace_back(high, n + 1 + i, n + 1 + j);
    mesh.triangles.emplace_back(i, j, n + 1 + j);
    mesh.triangles.emplace_back(i, n + 1 + j, n + 1 + i);
  }
  return mesh;
}

}  // namespace cloudcontact::program::lab
