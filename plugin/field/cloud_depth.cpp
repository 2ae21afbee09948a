// Depth by nearest surface points. Voxels that the surface crosses get the quadric of their 3x3x3
// block (surface_fit.h), hence a point of the surface and its normal; every other voxel takes over
// the nearest such point that one of its 26 neighbours knows, in sweeps through the grid there and
// back (vector distance transform, Danielsson 1980). Beside the point, within a voxel, the surface
// goes on as its plane; farther off the point itself is the nearest.
#include "field/cloud_depth.h"

#include "field/field_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr std::int32_t kNone = -1;
// [voxels] beside a surface point, within which its plane stands for the surface: half the diagonal
// of a voxel's face and a little.
constexpr double kPlane = 0.75;

struct SurfacePoint {
  Vec3 at, normal;  // voxels, the grid's frame
};

struct Depths {
  Eigen::Vector3i size;
  std::vector<SurfacePoint> points;
  std::vector<std::int32_t> nearest;  // of each voxel, kNone at first

  std::size_t index(const Eigen::Vector3i& v) const {
    return static_cast<std::size_t>(v.x()) +
           static_cast<std::size_t>(size.x()) *
               (static_cast<std::size_t>(v.y()) +
                static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(v.z()));
  }
  bool contains(const Eigen::Vector3i& v) const {
    return (v.array() >= 0).all() && (v.array() < size.array()).all();
  }
  static Vec3 center(const Eigen::Vector3i& v) { return v.cast<double>() + Vec3::Constant(0.5); }
  double squaredDistance(const Eigen::Vector3i& v, std::int32_t point) const {
    return point == kNone ? std::numeric_limits<double>::infinity()
                          : (points[static_cast<std::size_t>(point)].at - center(v)).squaredNorm();
  }
};

void findPoints(const Cloud& cloud, const Eigen::Vector3i& v, Depths& depths) {
  const int own = cloud.coverage(v.x(), v.y(), v.z());
  bool crossed = own > 0 && own < 255;
  for (int k = 0; k < 6 && !crossed; ++k) {
    Eigen::Vector3i beside = v;
    beside[k / 2] += k % 2 ? 1 : -1;
    crossed = cloud.coverage(beside.x(), beside.y(), beside.z()) == 255 - own;
  }
  if (!crossed) return;
  float block[CC_WINDOW_VOXELS];
  gatherBlock(cloud, v.x(), v.y(), v.z(), block);
  const CcSurface f = ccFitSurface(block, 0);
  if (f.weight == 0.0f) return;
  const Vec3 normal(f.n[0], f.n[1], f.n[2]);
  depths.nearest[depths.index(v)] = static_cast<std::int32_t>(depths.points.size());
  depths.points.push_back({Depths::center(v) + f.s * normal, normal});
}

// Neighbours that a sweep has visited before this voxel.
void takeOver(Depths& depths, const Eigen::Vector3i& v, int side) {
  std::int32_t& mine = depths.nearest[depths.index(v)];
  double least = depths.squaredDistance(v, mine);
  for (int k = 0; k < 13; ++k) {  // the first half of the 27 places about the voxel
    const Eigen::Vector3i beside =
        v + side * (Eigen::Vector3i(k % 3, k / 3 % 3, k / 9) - Eigen::Vector3i::Ones());
    if (!depths.contains(beside)) continue;
    const std::int32_t other = depths.nearest[depths.index(beside)];
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
        takeOver(depths, {place(i, n.x()), place(j, n.y()), place(k, n.z())}, side);
      // Back along the row: what lies behind on it is the nearest for a third of all voxels.
      for (int i = n.x() - 2; i >= 0; --i) {
        const Eigen::Vector3i v(place(i, n.x()), place(j, n.y()), place(k, n.z()));
        const Eigen::Vector3i beside = v + Eigen::Vector3i(side, 0, 0);
        const std::int32_t other = depths.nearest[depths.index(beside)];
        std::int32_t& mine = depths.nearest[depths.index(v)];
        if (depths.squaredDistance(v, other) < depths.squaredDistance(v, mine)) mine = other;
      }
    }
}

double depthOf(const Depths& depths, const Eigen::Vector3i& v, bool inside) {
  const std::int32_t nearest = depths.nearest[depths.index(v)];
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
  forEach([&] { findPoints(cloud, v, depths); });
  for (const int side : {1, -1, 1, -1}) sweep(depths, side);
  std::vector<float> result(count);
  forEach([&] {
    const bool inside = cloud.coverage(v.x(), v.y(), v.z()) >= 128;
    result[depths.index(v)] = static_cast<float>(cloud.voxelSize() * depthOf(depths, v, inside));
  });
  return result;
}

}  // namespace cloudcontact
