// Depth by nearest surface points (vector distance transform, Danielsson 1980). Each voxel that the
// surface crosses has a fitted quadric, and with it a point of the surface and its normal. Every
// other voxel takes the nearest such point that one of its 26 neighbors knows, in sweeps through
// the grid in both directions. Within a voxel of the point the surface is continued as its plane;
// farther away the distance to the point itself counts.
#include "field/cloud_depth.h"

#include "base/grid_index.h"
#include "field/field_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr std::int32_t kNone = -1;
// Distance [voxels] from a surface point within which its plane represents the surface: slightly
// more than half the diagonal of a voxel's face.
constexpr double kPlane = 0.75;

struct SurfacePoint {
  Vec3 at, normal;  // [voxels], grid's frame
};

struct Depths {
  Eigen::Vector3i size;
  std::vector<SurfacePoint> points;
  std::vector<std::int32_t> nearest;  // by voxel: index into `points`, or kNone

  std::int32_t& nearestOf(const Eigen::Vector3i& v) { return nearest[gridIndex(v, size)]; }
  std::int32_t nearestOf(const Eigen::Vector3i& v) const { return nearest[gridIndex(v, size)]; }
  static Vec3 center(const Eigen::Vector3i& v) { return v.cast<double>() + Vec3::Constant(0.5); }
  double squaredDistance(const Eigen::Vector3i& v, std::int32_t point) const {
    return point == kNone ? std::numeric_limits<double>::infinity()
                          : (points[static_cast<std::size_t>(point)].at - center(v)).squaredNorm();
  }
};

void findPoint(const Cloud& cloud, const Eigen::Vector3i& v, Depths& depths) {
  const CcSurface f = fitVoxel(cloud, v.x(), v.y(), v.z());
  if (f.weight == 0.0f) return;
  const Vec3 normal(f.n[0], f.n[1], f.n[2]);
  depths.nearestOf(v) = static_cast<std::int32_t>(depths.points.size());
  depths.points.push_back({Depths::center(v) + f.s * normal, normal});
}

// Takes the nearest point known to the neighbors that the sweep has visited before this voxel.
void takeNearest(Depths& depths, const Eigen::Vector3i& v, int side) {
  std::int32_t& mine = depths.nearestOf(v);
  double least = depths.squaredDistance(v, mine);
  for (int k = 0; k < 13; ++k) {  // the first half of the 27 voxels around it
    const Eigen::Vector3i beside =
        v + side * (Eigen::Vector3i(k % 3, k / 3 % 3, k / 9) - Eigen::Vector3i::Ones());
    if (!insideGrid(beside, depths.size)) continue;
    const std::int32_t other = depths.nearestOf(beside);
    const double distance = depths.squaredDistance(v, other);
    if (distance < least) mine = other, least = distance;
  }
}

void sweep(Depths& depths, int side) {
  const Eigen::Vector3i n = depths.size;
  const auto place = [&](int i, int count) { return side > 0 ? i : count - 1 - i; };
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j) {
      for (int i = 0; i < n.x(); ++i)
        takeNearest(depths, {place(i, n.x()), place(j, n.y()), place(k, n.z())}, side);
      // Back along the row, which holds the nearest point of a third of all voxels.
      for (int i = n.x() - 2; i >= 0; --i) {
        const Eigen::Vector3i v(place(i, n.x()), place(j, n.y()), place(k, n.z()));
        const Eigen::Vector3i beside = v + Eigen::Vector3i(side, 0, 0);
        const std::int32_t other = depths.nearestOf(beside);
        std::int32_t& mine = depths.nearestOf(v);
        if (depths.squaredDistance(v, other) < depths.squaredDistance(v, mine)) mine = other;
      }
    }
}

double depthOf(const Depths& depths, const Eigen::Vector3i& v, bool inside) {
  const std::int32_t nearest = depths.nearestOf(v);
  if (nearest == kNone) return inside ? 1e30 : -1e30;
  const SurfacePoint& p = depths.points[static_cast<std::size_t>(nearest)];
  const Vec3 to = p.at - Depths::center(v);
  const double along = to.dot(p.normal);
  const double aside = std::sqrt(std::max(to.squaredNorm() - along * along, 0.0));
  if (aside < kPlane) return along;
  return inside ? to.norm() : -to.norm();
}

}  // namespace

std::vector<float> cloudDepth(const Cloud& cloud) {
  Depths depths{cloud.size(), {}, {}};
  const Eigen::Vector3i n = depths.size;
  const std::size_t count = static_cast<std::size_t>(n.x()) * static_cast<std::size_t>(n.y()) *
                            static_cast<std::size_t>(n.z());
  depths.nearest.assign(count, kNone);
  Eigen::Vector3i v;
  const auto forEach = [&](auto&& what) {
    for (v.z() = 0; v.z() < n.z(); ++v.z())
      for (v.y() = 0; v.y() < n.y(); ++v.y())
        for (v.x() = 0; v.x() < n.x(); ++v.x()) what();
  };
  forEach([&] { findPoint(cloud, v, depths); });
  for (const int side : {1, -1, 1, -1}) sweep(depths, side);
  std::vector<float> result(count);
  forEach([&] {
    const bool inside = cloud.coverage(v.x(), v.y(), v.z()) >= 128;
    result[gridIndex(v, n)] = static_cast<float>(cloud.voxelSize() * depthOf(depths, v, inside));
  });
  return result;
}

}  // namespace cloudcontact
