// Spheres, cylinders, boxes and plates with known distance, and the errors of fields on them.
#include "field/field_cases.h"

#include <cloudcontact/field/surface_field.h>

#include <array>
#include <cmath>
#include <numbers>
#include <ostream>

namespace cloudcontact::testing {
namespace {

TrueSurface trueSphere(double radius, const Vec3& p) {
  return {radius - p.norm(), p.normalized(), 1e9};
}

// Valid beside faces, where all definitions of distance agree, and inside also at edges.
TrueSurface trueBox(const Vec3& half, const Vec3& p) {
  const Vec3 depths = half - p.cwiseAbs();
  int axis = 0;
  const double depth = depths.minCoeff(&axis);
  double second = 1e9;
  for (int k = 0; k < 3; ++k) {
    if (k != axis) second = std::min(second, depths[k]);
  }
  return {depth, Vec3::Unit(axis) * (p[axis] < 0 ? -1.0 : 1.0), second};
}

TrueSurface trueCylinder(double radius, double half, const Vec3& p) {
  const double across = std::hypot(p.x(), p.y());
  const double side = radius - across, cap = half - std::abs(p.z());
  if (cap < side) return {cap, Vec3::UnitZ() * (p.z() < 0 ? -1.0 : 1.0), side};
  return {side, Vec3(p.x(), p.y(), 0) / across, cap};
}

void compareAt(FieldErrors& errors, const Body& body, const Vec3& at, const TrueSurface& truth) {
  const double voxel = body.field->cloud().voxelSize();
  const auto found = body.field->at(body.grid.toWorld(at * voxel));
  if (!found) {
    ++errors.missing;
    return;
  }
  const double depth = found->depth / voxel - truth.depth;
  const Vec3 normal = body.grid.orientation * truth.normal;
  const double degrees = std::atan2(normal.cross(found->normal).norm(), normal.dot(found->normal)) *
                         180 / std::numbers::pi;
  ++errors.points;
  errors.depthBias += depth;
  errors.depthMean += std::abs(depth);
  errors.depthWorst = std::max(errors.depthWorst, std::abs(depth));
  errors.normalMean += degrees;
  errors.normalWorst = std::max(errors.normalWorst, degrees);
}

// Integrals of max(0, d - distance to the edge) beside each edge, by face (6) and side (6).
using Strips = std::array<std::array<double, 36>, 2>;
constexpr double kStripDepths[2] = {0.5, 1.0};
constexpr double kFromCorner = 2;  // the ends of an edge are excluded

int sideOf(int axis, double x) {
  return 2 * axis + (x > 0 ? 1 : 0);
}

// The mean of max(0, x) over a piece of this width, where x rises by the width across it: a
// sample's share of a wall's force.
double positiveMean(double x, double width) {
  if (x >= width / 2) return x;
  const double in = std::max(0.0, x + width / 2);
  return in * in / (2 * width);
}

void addToStrips(Strips& strips, const Vec3& half, const SurfaceSample& s, const Vec3& at,
                 const Vec3& normal) {
  int face = 0;
  normal.cwiseAbs().maxCoeff(&face);
  const Vec3 inside = half - at.cwiseAbs();
  for (int k = 1; k <= 2; ++k) {
    const int edge = (face + k) % 3, along = (face + 3 - k) % 3;
    if (inside[along] < kFromCorner) continue;
    const int strip = 6 * sideOf(face, normal[face]) + sideOf(edge, at[edge]);
    for (std::size_t d = 0; d < 2; ++d) {
      strips[d][static_cast<std::size_t>(strip)] +=
          s.area * positiveMean(kStripDepths[d] - inside[edge], s.width);
    }
  }
}

void compareStrips(SampleSums& sums, const Strips& strips, const Vec3& half) {
  for (std::size_t d = 0; d < 2; ++d) {
    int counted = 0;
    for (int strip = 0; strip < 36; ++strip) {
      const int face = strip / 12, edge = strip % 6 / 2;
      if (face == edge) continue;
      const double length = 2 * (half[3 - face - edge] - kFromCorner);
      if (length <= 0) continue;  // across a plate
      const double truth = length * kStripDepths[d] * kStripDepths[d] / 2;
      const double error = strips[d][static_cast<std::size_t>(strip)] / truth - 1;
      sums.stripMean[d] += error;
      ++counted;
      if (std::abs(error) > std::abs(sums.stripWorst[d])) sums.stripWorst[d] = error;
    }
    sums.stripMean[d] /= counted;
  }
}

}  // namespace

void PrintTo(const SolidCase& one, std::ostream* out) {
  *out << one.name;
}

std::vector<SolidCase> solidCases() {
  const double pi = std::numbers::pi;
  std::vector<SolidCase> all;
  for (const double r : {10.0, 16.0, 40.0}) {
    all.push_back({"sphere" + std::to_string(std::lround(r)),
                   [r](BodyMaker& make) { return make.sphere(r); },
                   [r](const Vec3& p) { return trueSphere(r, p); }, Vec3::Constant(r),
                   4 * pi * r * r, 4 * pi / 3 * r * r * r, r});
    all.push_back({"cylinder" + std::to_string(std::lround(r)),
                   [r](BodyMaker& make) { return make.cylinder(r, 30); },
                   [r](const Vec3& p) { return trueCylinder(r, 15, p); }, Vec3(r, r, 15),
                   2 * pi * r * (r + 30), pi * r * r * 30, r});
  }
  for (const auto& [name, aligned, z] : {std::tuple{"box", false, 20.6},
                                         {"box-aligned", true, 20.6},
                                         {"plate3", false, 3.0},
                                         {"plate2", false, 2.0}}) {
    const Vec3 edges(26.3, 31.2, z);
    const bool alongAxes = aligned;
    all.push_back({name, [=](BodyMaker& make) { return make.box(edges, alongAxes); },
                   [=](const Vec3& p) { return trueBox(edges / 2, p); }, edges / 2,
                   2 * (edges.x() * edges.y() + edges.y() * edges.z() + edges.z() * edges.x()),
                   edges.prod(), 1e9, std::min(1.0, edges.z() / 2 - 0.2), true});
  }
  return all;
}

FieldErrors fieldErrors(const SolidCase& one, double least, double most, double outermost,
                        int clouds, const BodyMaker& settings) {
  BodyMaker maker = settings;
  FieldErrors errors;
  for (int k = 0; k < clouds; ++k) {
    const Body body = one.make(maker);
    for (int drawn = 0; drawn < 20000; ++drawn) {
      const Vec3 at =
          (2 * maker.random.inCube() - Vec3::Ones()).cwiseProduct(one.half + Vec3::Constant(1.5));
      const TrueSurface truth = one.truth(at);
      if (truth.depth > one.deepest || truth.depth < -outermost) continue;
      if (truth.toEdge < least || truth.toEdge >= most) continue;
      compareAt(errors, body, at, truth);
    }
  }
  errors.depthBias /= errors.points;
  errors.depthMean /= errors.points;
  errors.normalMean /= errors.points;
  return errors;
}

FieldSides fieldSides(const SolidCase& one, int clouds, const BodyMaker& settings) {
  BodyMaker maker = settings;
  FieldSides sides;
  for (int k = 0; k < clouds; ++k) {
    const Body body = one.make(maker);
    const double voxel = body.field->cloud().voxelSize();
    for (int drawn = 0; drawn < 200000; ++drawn) {
      const Vec3 at =
          (2 * maker.random.inCube() - Vec3::Ones()).cwiseProduct(one.half + Vec3::Constant(4));
      const double truth = one.truth(at).depth;
      const bool outside = truth < -kSideSlack;
      if (!outside && (truth < kSideSlack || truth > one.deepest)) continue;
      const auto found = body.field->at(body.grid.toWorld(at * voxel));
      if (!found) continue;
      const double depth = found->depth / voxel;
      ++(outside ? sides.outside : sides.inside);
      if (outside) {
        sides.falseOverlap = std::max(sides.falseOverlap, depth);
        sides.falseOutside += depth > kSideSlack ? 1 : 0;
      } else {
        sides.falseGap = std::min(sides.falseGap, depth);
        sides.falseInside += depth < -kSideSlack ? 1 : 0;
      }
    }
  }
  return sides;
}

SampleSums sampleSums(const SolidCase& one, const Body& body) {
  SampleSums sums;
  Strips strips{};
  const double voxel = body.field->cloud().voxelSize();
  const Vec3 origin = body.field->cloud().origin();
  for (std::size_t k = 0; k < body.field->sampleCount(); ++k) {
    const SurfaceSample s = body.field->sample(k);
    const Vec3 inGrid = Eigen::Map<const Eigen::Vector3f>(s.position).cast<double>();
    const Vec3 normalInGrid = Eigen::Map<const Eigen::Vector3f>(s.normal).cast<double>();
    const Vec3 at = body.grid.toLocal(origin + voxel * inGrid) / voxel;
    const Vec3 normal = body.grid.orientation.conjugate() * normalInGrid;
    const TrueSurface truth = one.truth(at);
    if (one.box) addToStrips(strips, one.half, s, at, normal);
    sums.area += s.area;
    sums.vectorArea += s.area * normal;
    sums.volume += s.area * normal.dot(at) / 3;  // divergence theorem
    sums.offMean += s.area * std::abs(truth.depth);
    sums.offWorst = std::max(sums.offWorst, std::abs(truth.depth));
    // [deg]; closer to an edge, either face may be the nearest.
    if (truth.toEdge > 1) {
      sums.normalMean += s.area * truth.normal.cross(normal).norm() * 180 / std::numbers::pi;
    }
  }
  sums.offMean /= sums.area;
  sums.normalMean /= sums.area;
  if (one.box) compareStrips(sums, strips, one.half);
  return sums;
}

}  // namespace cloudcontact::testing
