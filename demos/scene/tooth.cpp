// The tooth as level functions, in millimeters, positive inside. Sizes follow textbooks of dental
// anatomy for a first lower molar (crown 7.5 high, 11 by 10.5 wide, roots 14; enamel 1 to 2 thick);
// the form is our own. As in real teeth, caries enters through the fissure and spreads below the
// enamel.
#include "scene/tooth.h"

#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scene/level_surface.h"

namespace cloudcontact::program {

namespace {

constexpr double kMm = 1e-3;

// The maximum of two, rounded where they differ by less than `width`.
double smoothMax(double a, double b, double width) {
  const double near = std::max(width - std::abs(a - b), 0.0) / width;
  return std::max(a, b) + near * near * width / 4;
}
double smoothMin(double a, double b, double width) {
  return -smoothMax(-a, -b, width);
}
double smoothStep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
double gauss(double x, double width) {
  return std::exp(-x * x / (width * width));
}
double ellipsoid(const Vec3& p, const Vec3& center, const Vec3& axes) {
  return (1 - (p - center).cwiseQuotient(axes).norm()) * axes.minCoeff();
}

// The chewing surface: four cusps, a fissure along x and a shallower one along y.
double chewingHeight(double x, double y) {
  double height = 5.2;
  for (const double cx : {-2.4, 2.4})
    for (const double cy : {-2.3, 2.3}) height += 1.7 * gauss(x - cx, 1.77) * gauss(y - cy, 1.77);
  return height - 0.5 * gauss(y, 0.45) - 0.35 * gauss(x, 0.45);
}

double crown(const Vec3& p) {
  const double bulge = std::sin(std::numbers::pi * std::clamp(p.z() / 6.5, 0.0, 1.0));
  const double a = 4.55 + 0.7 * bulge, b = 4.3 + 0.65 * bulge;
  constexpr double kPower = 2.8;  // between a circle and a square
  const double round = std::pow(
      std::pow(std::abs(p.x()) / a, kPower) + std::pow(std::abs(p.y()) / b, kPower), 1 / kPower);
  const double side = (1 - round) * b, top = 0.8 * (chewingHeight(p.x(), p.y()) - p.z());
  return std::min(smoothMin(side, top, 1.2), p.z() + 0.6);
}

// The part below `top`: roots and canals end inside the crown.
double below(double top, double z, double depth) {
  return std::min(depth, top - z);
}

// The roots diverge.
double rootMiddle(double side, double z) {
  return side * (2.0 - 0.06 * z);
}

double wholeTooth(const Vec3& p) {
  double depth = smoothMax(crown(p), ellipsoid(p, Vec3::Zero(), Vec3(4.3, 4.1, 4.5)), 0.6);
  for (const double side : {-1.0, 1.0})
    depth = smoothMax(
        depth,
        below(1.5, p.z(), ellipsoid(p, Vec3(rootMiddle(side, p.z()), 0, 0), Vec3(2.3, 3.6, 13))),
        0.6);
  return depth;
}

// Approximates a distance: the function over its slope.
double toothDepth(const Vec3& p) {
  constexpr double kStep = 1e-3;
  Vec3 slope;
  for (int i = 0; i < 3; ++i)
    slope[i] = (wholeTooth(p + kStep * Vec3::Unit(i)) - wholeTooth(p - kStep * Vec3::Unit(i))) /
               (2 * kStep);
  return wholeTooth(p) / std::max(slope.norm(), 0.2);
}

double dentin(const Vec3& p, const ToothShape& shape) {
  return toothDepth(p) - shape.enamel / kMm * smoothStep(-0.2, 3.2, p.z());
}

// A chamber with a horn under each cusp and a canal in each root.
double pulp(const Vec3& p, const ToothShape& shape) {
  const double roof = shape.pulpRoof / kMm;
  double depth = ellipsoid(p, Vec3(0, 0, roof - 1.3), Vec3(2.2, 1.7, 1.3));
  for (const double x : {-1.5, 1.5})
    for (const double y : {-1.1, 1.1})
      depth = smoothMax(depth, ellipsoid(p, Vec3(x, y, roof - 0.7), Vec3(0.45, 0.45, 1.3)), 0.3);
  for (const double side : {-1.0, 1.0})
    depth = smoothMax(
        depth,
        below(roof - 1.3, p.z(),
              ellipsoid(p, Vec3(rootMiddle(side, p.z()) - 0.3 * side, 0, -2), Vec3(0.5, 0.9, 9.5))),
        0.3);
  return depth;
}

double caries(const Vec3& p, const ToothShape& shape) {
  const double half = shape.lesion / kMm;
  const double spread =
      std::min(ellipsoid(p, Vec3(0, 0, 2.7), Vec3(half, 0.7 * half, 1.0)), dentin(p, shape));
  const double pit = std::min(shape.pit / kMm - std::hypot(p.x(), p.y()), p.z() - 2.5);
  return std::min(std::max(spread, pit), toothDepth(p));
}

void require(const ToothShape& shape) {
  const auto within = [](double value, double most, const char* field) {
    if (!(value > 0) || !(value <= most))
      throw std::invalid_argument(std::string("ToothShape: ") + field +
                                  " must be positive and at most " + std::to_string(most / kMm) +
                                  " mm");
  };
  within(shape.enamel, 2 * kMm, "enamel");
  within(shape.pit, 1 * kMm, "pit");
  within(shape.lesion, 2.5 * kMm, "lesion");
  within(shape.pulpRoof, 1.5 * kMm, "pulpRoof");
  within(shape.meshCell, 0.5 * kMm, "meshCell");
}

}  // namespace

std::vector<NamedMesh> toothMeshes(const ToothShape& shape) {
  require(shape);
  const Eigen::AlignedBox3d box(Vec3(-5.8, -5.6, -13.6), Vec3(5.8, 5.6, 7.4));
  const auto mesh = [&](const char* name, const LevelFunction& level) {
    Mesh found = levelSurface(level, box, shape.meshCell / kMm);
    return NamedMesh{name, found.scaled(Vec3::Constant(kMm))};
  };
  return {mesh("enamel", toothDepth),
          mesh("dentin", [&](const Vec3& p) { return dentin(p, shape); }),
          mesh("pulp", [&](const Vec3& p) { return pulp(p, shape); }),
          mesh("caries", [&](const Vec3& p) { return caries(p, shape); })};
}

Cloud toothCloud(double voxelSize, int threads, const ToothShape& shape) {
  DigitizeSettings settings;
  settings.voxelSize = voxelSize;
  settings.threads = threads;
  return digitize(toothMeshes(shape), settings);
}

}  // namespace cloudcontact::program
