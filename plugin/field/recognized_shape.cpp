// Shapes are fitted to some of the samples, and checked at all of them.
//
// Every sample must lie on the shape, to an error. What is deeper in the shape than that, its core,
// is convex, and no surface of the cloud crosses it: it is all matter or all empty, which one place
// tells. So a hollow body is no shape; nor is one with a hole, whose walls lie as deep as the shape
// is thick, so that it leaves no core: a link of a chain once became a box.
//
// Beside edges and tips samples are up to 0.4 voxel off, which says more about the field than about
// the body. There the coverage is compared, which is exact: an edge that is blunt by e lacks e^2 of
// the voxel. So 1/255 of a voxel, all that a cloud tells, is 0.06 voxel of an edge. The same tells
// who is wrong where few samples lie off the shape, as on the sides of a cone near its tip.
#include <cloudcontact/field/recognized_shape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "field/hull_fit.h"
#include "field/shape_fit.h"

namespace cloudcontact {

namespace {

constexpr std::size_t kFitted = 3000;  // samples; more change the fit by less than their noise
constexpr double kEdgeStep = 0.4;      // [voxels] between the points of an edge that are asked
constexpr int kParts = 8;              // of a voxel, along each axis, to find how full it is
constexpr double kBeyondTolerance =
    0.4;                            // [voxels] beyond the tolerance no sample is, even at edges
constexpr double kCore = 1;         // [voxels] samples of a hole's wall are as far apart
constexpr double kOffShape = 0.02;  // of the samples may lie off the shape
constexpr double kPi = std::numbers::pi;

// Lengths in voxels, as the grid's.
std::vector<ShapePoint> piecesOf(const SurfaceField& field) {
  const std::size_t stride = std::max<std::size_t>(1, field.sampleCount() / kFitted);
  std::vector<ShapePoint> pieces;
  for (std::size_t k = 0; k < field.sampleCount(); k += stride) {
    const SurfaceSample s = field.sample(k);
    pieces.push_back({Eigen::Map<const Eigen::Vector3f>(s.position).cast<double>(),
                      Eigen::Map<const Eigen::Vector3f>(s.normal).cast<double>(), s.area});
  }
  return pieces;
}

// Points on the edges of a shape, in its frame.
void addLine(const Vec3& from, const Vec3& to, std::vector<Vec3>& points) {
  const int count = 1 + static_cast<int>((to - from).norm() / kEdgeStep);
  for (int i = 0; i <= count; ++i) points.push_back(from + double(i) / count * (to - from));
}

void addCircle(double radius, double z, std::vector<Vec3>& points) {
  const int count = 8 + static_cast<int>(2 * kPi * radius / kEdgeStep);
  for (int i = 0; i < count; ++i)
    points.emplace_back(radius * std::cos(2 * kPi * i / count),
                        radius * std::sin(2 * kPi * i / count), z);
}

std::vector<Vec3> edgePoints(const Solid& solid) {
  std::vector<Vec3> points;
  if (const auto* box = std::get_if<Box>(&solid)) {
    for (int axis = 0; axis < 3; ++axis)
      for (int corner = 0; corner < 4; ++corner) {
        Vec3 from = box->halfExtents;
        if (corner & 1) from[(axis + 1) % 3] *= -1;
        if (corner & 2) from[(axis + 2) % 3] *= -1;
        Vec3 to = from;
        to[axis] *= -1;
        addLine(from, to, points);
      }
  } else if (const auto* cylinder = std::get_if<Cylinder>(&solid)) {
    addCircle(cylinder->radius, cylinder->halfHeight, points);
    addCircle(cylinder->radius, -cylinder->halfHeight, points);
  } else if (const auto* cone = std::get_if<Cone>(&solid)) {
    addCircle(cone->radius, -cone->halfHeight, points);
    points.emplace_back(0, 0, cone->halfHeight);
  } else if (const auto* hull = std::get_if<Hull>(&solid)) {
    for (const auto& [from, to] : hull->edges)
      addLine(hull->corners[static_cast<std::size_t>(from)],
              hull->corners[static_cast<std::size_t>(to)], points);
  }
  return points;
}

using Voxel = std::array<int, 3>;

Voxel voxelAt(const Vec3& grid) {
  const Eigen::Vector3i at = grid.array().floor().cast<int>();
  return {at.x(), at.y(), at.z()};
}

void sortOnce(std::vector<Voxel>& voxels) {
  std::sort(voxels.begin(), voxels.end());
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
}

// These voxels and those beside them, sorted.
std::vector<Voxel> about(std::vector<Voxel> voxels) {
  sortOnce(voxels);
  std::vector<Voxel> all;
  for (const Voxel& v : voxels)
    for (int k = 0; k < 27; ++k)
      all.push_back({v[0] + k % 3 - 1, v[1] + k / 3 % 3 - 1, v[2] + k / 9 - 1});
  sortOnce(all);
  return all;
}

// The voxels about a shape's edges.
std::vector<Voxel> edgeVoxels(const PlacedSolid& shape) {
  std::vector<Voxel> hit;
  for (const Vec3& point : edgePoints(shape.solid))
    hit.push_back(voxelAt(shape.place.toWorld(point)));
  return about(std::move(hit));
}

// As depthOf(), and beyond a hull's edges the distance from the nearest plane: where it matters,
// below a part of a voxel, that is the same, and many times faster.
double quickDepth(const PlacedSolid& shape, const Vec3& point) {
  const auto* hull = std::get_if<Hull>(&shape.solid);
  if (!hull) return depthOf(shape, point);
  const Vec3 at = shape.place.toLocal(point);
  double least = hull->planes.front().offset;
  for (const HalfSpace& plane : hull->planes)
    least = std::min(least, plane.offset - plane.normal.dot(at));
  return least;
}

// The share of a voxel that the shape fills.
double filled(const PlacedSolid& shape, const Voxel& voxel) {
  const Vec3 corner(voxel[0], voxel[1], voxel[2]);
  const double depth = quickDepth(shape, corner + Vec3::Constant(0.5));
  if (std::abs(depth) > 0.87) return depth > 0 ? 1 : 0;  // half a diagonal
  double sum = 0;
  for (int k = 0; k < kParts * kParts * kParts; ++k) {
    const Vec3 at =
        (Vec3(k % kParts, k / kParts % kParts, k / kParts / kParts).array() + 0.5) / kParts;
    sum += std::clamp(0.5 + kParts * quickDepth(shape, corner + at), 0.0, 1.0);
  }
  return sum / (kParts * kParts * kParts);
}

// How far the cloud is from the shape in these voxels, as beside edges [voxels]; stops beyond
// `enough`.
double coverageOff(const Cloud& cloud, const PlacedSolid& shape, const std::vector<Voxel>& voxels,
                   double enough) {
  double most = 0;
  for (const Voxel& v : voxels) {
    const double has = cloud.coverage(v[0], v[1], v[2]) / 255.0;
    most = std::max(most, std::abs(filled(shape, v) - has));
    if (most > enough * enough) break;
  }
  return std::sqrt(most);
}

// How far the samples are from the shape elsewhere [voxels], but for those of `doubtful` voxels,
// which are farther than `enough`. Stops if these are too many.
double samplesOff(const SurfaceField& field, const PlacedSolid& shape,
                  const std::vector<Voxel>& atEdges, double enough, std::vector<Voxel>& doubtful) {
  const double many = kOffShape * double(field.sampleCount());
  double most = 0;
  for (std::size_t k = 0; k < field.sampleCount(); ++k) {
    const SurfaceSample s = field.sample(k);
    const Vec3 at = Eigen::Map<const Eigen::Vector3f>(s.position).cast<double>();
    const double off = std::abs(depthOf(shape, at));
    if (off <= most || std::binary_search(atEdges.begin(), atEdges.end(), voxelAt(at))) continue;
    if (off <= enough) {
      most = off;
      continue;
    }
    doubtful.push_back(voxelAt(at));
    if (double(doubtful.size()) > many) return off;
  }
  return most;
}

double errorOf(const SurfaceField& field, const PlacedSolid& shape, double enough) {
  const std::vector<Voxel> atEdges = edgeVoxels(shape);
  std::vector<Voxel> doubtful;
  double most = samplesOff(field, shape, atEdges, enough, doubtful);
  for (const std::vector<Voxel>& voxels : {atEdges, about(std::move(doubtful))})
    if (most <= enough) most = std::max(most, coverageOff(field.cloud(), shape, voxels, enough));
  return most;
}

// Whether the cloud fills the shape but for a skin of `error` [voxels].
bool fills(const Cloud& cloud, const PlacedSolid& shape, double error) {
  const Vec3& middle = shape.place.position;
  const Voxel v = voxelAt(middle);
  return depthOf(shape, middle) > error + kCore && cloud.coverage(v[0], v[1], v[2]) == 255;
}

Solid scaled(Solid solid, double by) {
  if (auto* ball = std::get_if<Sphere>(&solid)) ball->radius *= by;
  if (auto* box = std::get_if<Box>(&solid)) box->halfExtents *= by;
  if (auto* c = std::get_if<Cylinder>(&solid)) c->radius *= by, c->halfHeight *= by;
  if (auto* c = std::get_if<Capsule>(&solid)) c->radius *= by, c->halfHeight *= by;
  if (auto* c = std::get_if<Cone>(&solid)) c->radius *= by, c->halfHeight *= by;
  if (auto* hull = std::get_if<Hull>(&solid)) {
    for (HalfSpace& plane : hull->planes) plane.offset *= by;
    for (Vec3& corner : hull->corners) corner *= by;
  }
  return solid;
}

bool isFar(const PlacedSolid& shape, const std::vector<ShapePoint>& pieces, double within) {
  return std::any_of(pieces.begin(), pieces.end(), [&](const ShapePoint& piece) {
    return std::abs(depthOf(shape, piece.position)) > within + kBeyondTolerance;
  });
}

}  // namespace

std::optional<RecognizedShape> recognizedShape(const SurfaceField& field, double tolerance) {
  if (!(tolerance >= 0) || !std::isfinite(tolerance))
    throw std::invalid_argument(
        "recognizedShape: the tolerance must be at least 0 and finite, in meters");
  const Cloud& cloud = field.cloud();
  const double voxel = cloud.voxelSize(), within = tolerance / voxel;
  const std::vector<ShapePoint> pieces = piecesOf(field);
  std::optional<RecognizedShape> best;
  const auto offer = [&](const PlacedSolid& shape) {
    if (isFar(shape, pieces, within)) return;
    const double off = errorOf(field, shape, within);
    if (!(off <= within) || !fills(cloud, shape, off)) return;
    if (best && off * voxel >= best->error) return;
    best.emplace();
    best->error = off * voxel;
    best->placed.solid = scaled(shape.solid, voxel);
    best->placed.place = {shape.place.orientation, cloud.origin() + voxel * shape.place.position};
  };
  for (const PlacedSolid& shape : fittedShapes(pieces, within + kBeyondTolerance)) {
    offer(shape);
    if (best && std::holds_alternative<Sphere>(shape.solid)) break;
  }
  if (best) return best;
  for (const PlacedSolid& hull : fittedHulls(pieces)) {
    offer(hull);
    if (best) break;
  }
  return best;
}

const char* shapeName(const Solid& solid) {
  if (std::holds_alternative<Sphere>(solid)) return "ball";
  if (std::holds_alternative<Box>(solid)) return "box";
  if (std::holds_alternative<Cylinder>(solid)) return "cylinder";
  if (std::holds_alternative<Capsule>(solid)) return "capsule";
  if (std::holds_alternative<Cone>(solid)) return "cone";
  if (std::holds_alternative<Hull>(solid)) return "hull";
  return "solid";
}

}  // namespace cloudcontact
