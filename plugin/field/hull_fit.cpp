// Faces are found one by one: the plane through a point and across its normal on which most of the
// surface lies is a face, and what lies on it is left out from then on. The planes' corners are all
// points where three of them meet and that are beyond no other; where these make a closed body, it
// is the hull. Beside its edges the points are less certain, so each plane is then fitted again to
// those away from all others.
#include "field/hull_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "law/convex_solid.h"

namespace cloudcontact {

namespace {

constexpr std::size_t kSeeds = 24;       // points that are tried for each face
constexpr double kNear = 0.3;            // from a plane that a point lies on
constexpr double kFacesPlane = 0.95;     // cosine: its normal is the plane's
constexpr double kFlatNormals = 0.998;   // cosine, 3.6 deg: as flat faces' normals are
constexpr double kFlatShare = 0.5;       // of a face, at least, is flat; of a ball's cap little is
constexpr double kOnNoPlane = 0.05;      // of the surface may lie on no plane, all beside edges
constexpr double kLeastFace = 0.002;     // of the surface
constexpr double kBeyond = 0.02;         // of the surface may lie beyond a plane ...
constexpr double kFarBeyond = 1;         // ... by more than this
constexpr double kInside = 1;            // from all other planes: points for the second fit
constexpr double kSame = 1e-6;           // corners that are nearer are one
constexpr double kParallel = 1e-4;       // volume of three unit normals that meet in no corner
constexpr std::size_t kLeastPoints = 6;  // of a face

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
  double above(const Vec3& x) const { return normal.dot(x) - offset; }
};

bool liesOn(const ShapePoint& p, const Plane& plane) {
  return std::abs(plane.above(p.position)) < kNear && p.normal.dot(plane.normal) > kFacesPlane;
}

double areaOn(const std::vector<const ShapePoint*>& points, const Plane& plane) {
  double area = 0;
  for (const ShapePoint* p : points)
    if (liesOn(*p, plane)) area += p->area;
  return area;
}

// Least squares; empty for fewer points than a plane needs.
std::optional<Plane> planeThrough(const std::vector<const ShapePoint*>& points) {
  if (points.size() < kLeastPoints) return std::nullopt;
  double area = 0;
  Vec3 middle = Vec3::Zero(), facing = Vec3::Zero();
  for (const ShapePoint* p : points) {
    area += p->area;
    middle += p->area * p->position;
    facing += p->area * p->normal;
  }
  middle /= area;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const ShapePoint* p : points) {
    const Vec3 out = p->position - middle;
    spread += p->area * out * out.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  Plane plane;
  plane.normal = solver.eigenvectors().col(0);
  if (plane.normal.dot(facing) < 0) plane.normal = -plane.normal;
  plane.offset = plane.normal.dot(middle);
  return plane;
}

template <typename Takes>
std::vector<const ShapePoint*> chosen(const std::vector<const ShapePoint*>& from, Takes takes) {
  std::vector<const ShapePoint*> points;
  for (const ShapePoint* p : from)
    if (takes(*p)) points.push_back(p);
  return points;
}

// The plane on which most of the rest lies.
std::optional<Plane> largestFace(const std::vector<const ShapePoint*>& rest) {
  const std::size_t stride = std::max<std::size_t>(1, rest.size() / kSeeds);
  Plane best;
  double most = 0;
  for (std::size_t k = 0; k < rest.size(); k += stride) {
    const Plane seed{rest[k]->normal, rest[k]->normal.dot(rest[k]->position)};
    const double area = areaOn(rest, seed);
    if (area > most) most = area, best = seed;
  }
  for (int round = 0; round < 2; ++round) {
    const auto better =
        planeThrough(chosen(rest, [&](const ShapePoint& p) { return liesOn(p, best); }));
    if (!better) return std::nullopt;
    best = *better;
  }
  return best;
}

bool isFlat(const std::vector<const ShapePoint*>& face, const Plane& plane) {
  double flat = 0, area = 0;
  for (const ShapePoint* p : face) {
    area += p->area;
    if (p->normal.dot(plane.normal) > kFlatNormals) flat += p->area;
  }
  return face.size() >= kLeastPoints && flat >= kFlatShare * area;
}

double areaOf(const std::vector<const ShapePoint*>& points) {
  double area = 0;
  for (const ShapePoint* p : points) area += p->area;
  return area;
}

// Whether a plane that most of the rest lies on is a face of a convex body.
bool isFace(const Plane& plane, const std::vector<const ShapePoint*>& on,
            const std::vector<const ShapePoint*>& all, double whole) {
  const auto beyond =
      chosen(all, [&](const ShapePoint& p) { return plane.above(p.position) > kFarBeyond; });
  return isFlat(on, plane) && areaOf(on) >= kLeastFace * whole && areaOf(beyond) <= kBeyond * whole;
}

// The faces, largest first. `enough`: how many of them are most of the surface; the others are
// narrow, or what edges look like. None if the surface is not made of flat faces or is not convex.
std::vector<Plane> facesOf(const std::vector<const ShapePoint*>& all, std::size_t& enough) {
  const double whole = areaOf(all);
  std::vector<Plane> planes;
  std::vector<const ShapePoint*> rest = all;
  enough = 0;
  while (planes.size() < kMostFaces) {
    if (enough == 0 && areaOf(rest) <= kOnNoPlane * whole) enough = planes.size();
    const auto plane = largestFace(rest);
    if (!plane) break;
    const auto on = chosen(rest, [&](const ShapePoint& p) { return liesOn(p, *plane); });
    if (!isFace(*plane, on, all, whole)) break;
    planes.push_back(*plane);
    rest = chosen(rest, [&](const ShapePoint& p) { return !liesOn(p, *plane); });
  }
  if (areaOf(rest) > kOnNoPlane * whole) planes.clear();
  if (enough == 0) enough = planes.size();
  return planes;
}

// A corner and the planes that meet there, sorted.
struct Corner {
  Vec3 at = Vec3::Zero();
  std::vector<std::size_t> planes;
};

void addCorner(const Vec3& at, const std::array<std::size_t, 3>& planes,
               std::vector<Corner>& corners) {
  auto same = std::find_if(corners.begin(), corners.end(),
                           [&](const Corner& c) { return (c.at - at).norm() < kSame; });
  if (same == corners.end()) same = corners.insert(same, Corner{at, {}});
  for (const std::size_t plane : planes) {
    const auto place = std::lower_bound(same->planes.begin(), same->planes.end(), plane);
    if (place == same->planes.end() || *place != plane) same->planes.insert(place, plane);
  }
}

std::vector<Corner> cornersOf(const std::vector<Plane>& planes) {
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t j = i + 1; j < planes.size(); ++j)
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        Eigen::Matrix3d normals;
        normals << planes[i].normal.transpose(), planes[j].normal.transpose(),
            planes[k].normal.transpose();
        if (std::abs(normals.determinant()) < kParallel) continue;
        const Vec3 at =
            normals.inverse() * Vec3(planes[i].offset, planes[j].offset, planes[k].offset);
        const bool beyond = std::any_of(planes.begin(), planes.end(),
                                        [&](const Plane& p) { return p.above(at) > kSame; });
        if (!beyond) addCorner(at, {i, j, k}, corners);
      }
  return corners;
}

std::vector<std::pair<int, int>> edgesOf(const std::vector<Corner>& corners) {
  std::vector<std::pair<int, int>> edges;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t j = i + 1; j < corners.size(); ++j) {
      std::vector<std::size_t> shared;
      std::set_intersection(corners[i].planes.begin(), corners[i].planes.end(),
                            corners[j].planes.begin(), corners[j].planes.end(),
                            std::back_inserter(shared));
      if (shared.size() >= 2) edges.emplace_back(static_cast<int>(i), static_cast<int>(j));
    }
  return edges;
}

// By Euler's formula an open body, or a plane without a face, is none.
bool isClosed(const std::vector<Plane>& planes, const std::vector<Corner>& corners,
              const std::vector<std::pair<int, int>>& edges) {
  return corners.size() >= 4 && corners.size() + planes.size() == edges.size() + 2;
}

// Each plane again, by its points that are away from all others; one that has few stays.
void fitAgain(const std::vector<const ShapePoint*>& all, std::vector<Plane>& planes) {
  const std::vector<Plane> before = planes;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto inside = chosen(all, [&](const ShapePoint& p) {
      if (!liesOn(p, before[i])) return false;
      for (std::size_t j = 0; j < before.size(); ++j)
        if (j != i && before[j].above(p.position) > -kInside) return false;
      return true;
    });
    if (const auto better = planeThrough(inside)) planes[i] = *better;
  }
}

PlacedSolid placed(const std::vector<Plane>& planes, const std::vector<Corner>& corners,
                   std::vector<std::pair<int, int>> edges) {
  Vec3 middle = Vec3::Zero();
  for (const Corner& corner : corners) middle += corner.at;
  middle /= static_cast<double>(corners.size());
  Hull hull;
  for (const Plane& plane : planes) hull.planes.push_back({plane.normal, -plane.above(middle)});
  for (const Corner& corner : corners) hull.corners.push_back(corner.at - middle);
  hull.edges = std::move(edges);
  return {hull, {Eigen::Quaterniond::Identity(), middle}};
}

// The hull inside the planes, which are fitted again; empty if they enclose none, or one of them is
// beyond the others.
std::optional<PlacedSolid> hullOf(const std::vector<const ShapePoint*>& all,
                                  std::vector<Plane> planes) {
  std::vector<Corner> corners = cornersOf(planes);
  if (!isClosed(planes, corners, edgesOf(corners))) return std::nullopt;
  fitAgain(all, planes);
  corners = cornersOf(planes);
  auto edges = edgesOf(corners);
  if (!isClosed(planes, corners, edges)) return std::nullopt;
  PlacedSolid hull = placed(planes, corners, std::move(edges));
  if (!isSimple(hull.solid)) return std::nullopt;
  return hull;
}

}  // namespace

std::vector<PlacedSolid> fittedHulls(const std::vector<ShapePoint>& surface) {
  std::vector<const ShapePoint*> all;
  for (const ShapePoint& p : surface) all.push_back(&p);
  std::size_t enough = 0;
  const std::vector<Plane> planes = facesOf(all, enough);
  std::vector<PlacedSolid> hulls;
  for (std::size_t n = std::max<std::size_t>(4, enough); n <= planes.size(); ++n)
    if (auto hull = hullOf(all, {planes.begin(), planes.begin() + static_cast<long>(n)}))
      hulls.push_back(std::move(*hull));
  return hulls;
}

}  // namespace cloudcontact
