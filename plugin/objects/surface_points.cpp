// Points of a surface as voxels (point_cloud.h).
//
// A flood fill (scan_flood.h) separates inside from outside. The winding number of the normals
// would need normals that already point outward, which requires the inside; and it gives even an
// open scan some inside, where the flood finds none. Near the points the flood is too coarse: there
// the height over the surface (scan_surface.h) decides, and gives voxels their fraction of
// material.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include <cloudcontact/objects/point_cloud.h>

#include <Eigen/Eigenvalues>

#include "base/grid_index.h"
#include "base/parallel.h"
#include "kernels/base/plane_cell.h"
#include "objects/scan_surface.h"
#include "voxels/cloud_builder.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3i;

constexpr std::size_t kFewestPoints = 16;
constexpr int kMostCubes = 3;  // along a voxel's edge
// A shell ends this many point distances beyond its outermost points.
constexpr double kRim = 0.75;
// Spread of a point's neighbors, smallest over largest: 0 on a surface, 1 in a volume, 0.2 for
// noise of a fifth of the point distance.
constexpr double kVolume = 0.45;

double shareUnder(double above, const Vec3& n, double edge) {
  return ccCutCube(n[0], n[1], n[2], -above / edge).volume;
}

// Shares of cubes that are material.
class ScanBody {
 public:
  ScanBody(const ScanSurface& surface, const ScanFlood& flood, double shell, bool centered,
           double distance)
      : surface_(surface), flood_(flood), shell_(shell), centered_(centered), distance_(distance) {}

  // The share of a voxel or brick far from all points, which is 0 or 1; negative where the surface
  // may pass through it.
  double plain(const Vec3& middle, double edge) const {
    const double far = surface_.distanceTo(middle);
    const double reach = kHalfDiagonal * edge + distance_ + shell_;
    if (far <= reach) return -1;
    if (shell_ > 0 || flood_.outside(middle)) return 0;
    return flood_.inside(middle) || surface_.heightOf(middle).above < 0;
  }

  double share(const Vec3& middle, double edge) const {
    const auto all = surface_.heightOf(middle);
    const double depth = -all.above;
    if (shell_ == 0 && std::abs(depth) > (kHalfDiagonal + 0.05) * edge) return depth > 0;
    const int n = std::clamp(static_cast<int>(std::ceil(edge / distance_)), 2, kMostCubes);
    double sum = 0;
    for (int k = 0; k < n * n * n; ++k) {
      const Vec3 at(k % n + 0.5, k / n % n + 0.5, k / (n * n) + 0.5);
      sum += part(middle + edge * (at / n - Vec3::Constant(0.5)), edge / n);
    }
    return sum / (n * n * n);
  }

 private:
  double part(const Vec3& middle, double edge) const {
    const auto h = surface_.heightOf(middle);
    if (shell_ == 0) return shareUnder(h.above, h.normal, edge);
    if (h.beside > kRim * distance_) return 0;
    const double above = centered_ ? h.above - 0.5 * shell_ : h.above;
    return shareUnder(above, h.normal, edge) - shareUnder(above + shell_, h.normal, edge);
  }

  const ScanSurface& surface_;
  const ScanFlood& flood_;
  double shell_;
  bool centered_;
  double distance_;
};

void validate(const PointCloud& points, const ScanSettings& s) {
  validate(points);
  const auto fail = [](const char* why) {
    throw std::invalid_argument(std::string("points: ") + why);
  };
  if (points.positions.size() < kFewestPoints)
    fail("a surface takes at least 16 points; scan closer");
  if (!(s.gap >= 0) || !std::isfinite(s.gap)) fail("gap must be finite, not negative [m]");
  if (!(s.smoothing >= 0) || !std::isfinite(s.smoothing))
    fail("smoothing must be finite, not negative [m]");
  if (!(s.shell >= 0) || !std::isfinite(s.shell)) fail("shell must be finite, not negative [m]");
}

Cloud fill(const ScanBody& body, const CloudGrid& grid, int threads) {
  struct FilledBrick {
    double plain = -1;
    BrickCoverage coverage;
  };
  const Vector3i n = grid.bricks;
  std::vector<std::unique_ptr<FilledBrick>> filled(n.cast<std::size_t>().prod());
  parallelFor(filled.size(), threads, [&](std::size_t entry, int) {
    const Vec3 brick = gridCell(entry, n).cast<double>();
    const double h = grid.voxelSize, edge = kBrickEdge * h;
    const Vec3 low = grid.origin + edge * brick;
    filled[entry] = std::make_unique<FilledBrick>();
    FilledBrick& f = *filled[entry];
    f.plain = body.plain(low + Vec3::Constant(0.5 * edge), edge);
    for (int v = 0; v < kBrickVoxels && f.plain < 0; ++v) {
      const Vec3 middle = low + h * (cellOffset(v).cast<double>() + Vec3::Constant(0.5));
      double share = body.plain(middle, h);
      if (share < 0) share = body.share(middle, h);
      f.coverage[v] = static_cast<std::uint8_t>(255 * std::clamp(share, 0.0, 1.0) + 0.5);
    }
    if (f.plain >= 0) f.coverage.fill(f.plain > 0 ? 255 : 0);
  });
  auto voxels = emptyVoxels(n, {});
  for (std::size_t e = 0; e < filled.size(); ++e)
    storeBrick(*voxels, e, filled[e]->coverage, nullptr);
  return Cloud(grid.voxelSize, grid.origin, std::move(voxels));
}

[[noreturn]] void refuseOpen(double gap) {
  std::ostringstream text;
  text << "points: they close no volume: holes are wider than " << 2 * gap
       << " m, or the body thinner; give a shell's thickness (--shell), a larger gap, or "
          "the spacing of points that fill a volume";
  throw std::invalid_argument(text.str());
}

}  // namespace

double pointDistance(const PointCloud& points) {
  const PointTree tree(points.positions);
  constexpr std::size_t kSamples = 2000, kFourth = 4;
  const std::size_t step = std::max<std::size_t>(1, points.positions.size() / kSamples);
  std::vector<double> distances;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.positions.size(); i += step) {
    tree.nearest(points.positions[i], kFourth + 1, near);  // the point itself is one of them
    distances.push_back((points.positions[near.back()] - points.positions[i]).norm());
  }
  if (distances.empty()) return 0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

bool recognizeVolume(PointCloud& points) {
  if (points.fillsVolume()) return true;
  if (points.positions.size() < kFewestPoints) return false;
  const PointTree tree(points.positions);
  constexpr std::size_t kSamples = 500, kNeighbors = 19;  // a lattice point and its 18 nearest
  const std::size_t step = std::max<std::size_t>(1, points.positions.size() / kSamples);
  std::vector<double> spreads;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.positions.size(); i += step) {
    tree.nearest(points.positions[i], kNeighbors, near);
    Vec3 sum = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const std::size_t k : near) {
      const Vec3 r = points.positions[k] - points.positions[i];
      sum += r, second += r * r.transpose();
    }
    second -= sum * sum.transpose() / static_cast<double>(near.size());
    const Vec3 along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(second).eigenvalues();
    spreads.push_back(along[2] > 0 ? std::sqrt(std::max(0.0, along[0]) / along[2]) : 0);
  }
  const auto middle = spreads.begin() + static_cast<std::ptrdiff_t>(spreads.size() / 2);
  std::nth_element(spreads.begin(), middle, spreads.end());
  if (*middle < kVolume) return false;
  points.spacing = pointDistance(points);
  return points.fillsVolume();
}

Cloud toCloud(const PointCloud& points, const ScanSettings& settings, ScanReport* report) {
  validate(points, settings);
  ScanReport found;
  found.pointDistance = pointDistance(points);
  if (!(found.pointDistance > 0))
    throw std::invalid_argument("points: they lie on one another; remove doubles");
  const double gap = settings.gap > 0 ? settings.gap : 2 * found.pointDistance;
  const double smoothing = settings.smoothing > 0 ? settings.smoothing : 2.5 * found.pointDistance;
  const ScanFlood flood(points.positions, gap);
  std::vector<Vec3> normals;
  for (const Eigen::Vector3f& n : points.normals) normals.push_back(n.cast<double>());
  ScanSurface surface(points.positions, normals, found.pointDistance, smoothing, settings.threads);
  const ScanSurface::Sides sides = surface.orient(flood);
  // Where the flood leaks in, pockets may remain. A body has inside behind most of its points.
  found.closed = 2 * sides.known > points.positions.size();
  if (!found.closed && settings.shell == 0) refuseOpen(gap);
  if (found.closed) found.turned = sides.turned;
  surface.fit();
  const double shell = found.closed ? 0 : settings.shell;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points.positions) box.extend(p);
  box.min().array() -= shell + settings.voxelSize;
  box.max().array() += shell + settings.voxelSize;
  const CloudGrid grid = cloudGrid("points", box, settings.voxelSize);
  const ScanBody body(surface, flood, shell, normals.empty(), found.pointDistance);
  if (report) *report = found;
  return fill(body, grid, settings.threads);
}

}  // namespace cloudcontact
