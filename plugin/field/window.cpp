// Cuts an area into the voxels around one voxel, by 8x8x8 sample points per voxel, each with the
// weight of the area at it.
#include <cloudcontact/field/window.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/digitize/window_sums.h"

namespace cloudcontact {

namespace {

constexpr int kPoints = 8;               // along a voxel's edge
constexpr double kMostVoxels = 1 << 18;  // of C
constexpr int kFarthestVoxel = 1 << 13;  // from the voxel [voxels]

double weightAt(const WindowSettings& settings, double depth, double greatest) {
  if (!(depth > 0)) return 0;
  if (settings.weight == WindowWeight::Even) return 1;
  // For a sphere 1 - s is r/R: the weight is (1 - r^2/R^2)^2.
  const double away = 1 - std::min(depth / greatest, 1.0);
  return (1 - away * away) * (1 - away * away);
}

// Means over the voxel at `at`: of the weight, and of the weight times the position.
struct Weighed {
  double weight = 0;
  Vec3 moment = Vec3::Zero();
};
Weighed weigh(const WindowSettings& settings, double voxel, double greatest, const Vec3& at) {
  constexpr double kShare = 1.0 / (kPoints * kPoints * kPoints);
  Weighed sum;
  for (int k = 0; k < kPoints * kPoints * kPoints; ++k) {
    const Vec3 part(k % kPoints, k / kPoints % kPoints, k / (kPoints * kPoints));
    const Vec3 p = at + (part + Vec3::Constant(0.5)) / kPoints - Vec3::Constant(0.5);
    const double weight = kShare * weightAt(settings, depthOf(settings.area, voxel * p), greatest);
    sum.weight += weight;
    sum.moment += weight * p;
  }
  return sum;
}

double greatestDepth(const Solid& solid) {
  struct Deepest {
    double operator()(const HalfSpace&) const { return std::numeric_limits<double>::infinity(); }
    double operator()(const Sphere& s) const { return s.radius; }
    double operator()(const Box& b) const { return b.halfExtents.minCoeff(); }
    double operator()(const Ellipsoid& e) const { return e.semiAxes.minCoeff(); }
    double operator()(const Capsule& c) const { return c.radius; }
    double operator()(const Cylinder& c) const { return std::min(c.radius, c.halfHeight); }
    double operator()(const Cone& c) const {  // the ball in the triangle of its section
      const double height = 2 * c.halfHeight;
      return c.margin + c.radius * height / (c.radius + std::hypot(c.radius, height));
    }
    // At the corners' mean: close enough, since deeper points count as that deep.
    double operator()(const Hull& hull) const {
      Vec3 mean = Vec3::Zero();
      for (const Vec3& corner : hull.corners)
        mean += corner / static_cast<double>(hull.corners.size());
      return solidAt(hull, mean).depth;
    }
    double operator()(const CloudSolid& c) const {
      return *std::max_element(c.depth->begin(), c.depth->end());
    }
    double operator()(const SurfaceSolid&) const { return std::numeric_limits<double>::infinity(); }
  };
  return std::visit(Deepest{}, solid);
}

}  // namespace

WindowSettings sphereWindow(double voxelSize, double radiusInVoxels) {
  return {{Sphere{radiusInVoxels * voxelSize}}, WindowWeight::Smooth, Vec3::Zero()};
}

Vec3 Window::center() const {
  Vec3 sum = Vec3::Zero();
  for (const WindowTap& t : taps) sum += Vec3(t.moment[0], t.moment[1], t.moment[2]);
  return sum / static_cast<double>(weights);
}

Window makeWindow(const WindowSettings& settings, double voxelSize) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw std::invalid_argument("makeWindow: the voxel size must be positive and finite");
  validate(settings.area);
  if (!settings.representative.allFinite())
    throw std::invalid_argument("makeWindow: the representative point must be finite");
  const Eigen::AlignedBox3d bounds = boundsOf(settings.area);
  const Vec3 low = (bounds.min() / voxelSize).array().round();
  const Vec3 high = (bounds.max() / voxelSize).array().round();
  if (!((high - low + Vec3::Ones()).prod() <= kMostVoxels) ||
      low.cwiseAbs().maxCoeff() > kFarthestVoxel || high.cwiseAbs().maxCoeff() > kFarthestVoxel)
    throw std::length_error("makeWindow: the cuttable area holds " +
                            std::to_string((high - low + Vec3::Ones()).prod()) +
                            " voxels or lies too far away; take a smaller one or larger voxels");
  Window window;
  window.representative = settings.representative / voxelSize;
  window.low = Eigen::Vector3i::Constant(std::numeric_limits<int>::max());
  window.high = -window.low;
  const double greatest = greatestDepth(settings.area.solid);
  const Eigen::Vector3i first = low.cast<int>(), last = high.cast<int>();
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const Weighed w = weigh(settings, voxelSize, greatest, Vec3(x, y, z));
        const auto weight = static_cast<std::uint8_t>(std::lround(255 * w.weight));
        if (weight == 0) continue;
        const auto moment = [&](int axis) {
          return static_cast<std::int32_t>(std::lround(255 * w.moment[axis]));
        };
        window.taps.push_back({static_cast<std::int16_t>(x),
                               static_cast<std::int16_t>(y),
                               static_cast<std::int16_t>(z),
                               weight,
                               {moment(0), moment(1), moment(2)}});
        window.low = window.low.cwiseMin(Eigen::Vector3i(x, y, z));
        window.high = window.high.cwiseMax(Eigen::Vector3i(x, y, z));
        window.weights += weight;
      }
  double moment = 0;
  for (const WindowTap& t : window.taps)
    moment += std::max({std::abs(t.moment[0]), std::abs(t.moment[1]), std::abs(t.moment[2])});
  if (moment > CC_MOST_MOMENT)
    throw std::length_error(
        "makeWindow: the cuttable area is too large or too far away for exact sums");
  if (window.taps.empty())
    throw std::invalid_argument(
        "makeWindow: the cuttable area holds no voxel's part; take a larger one");
  return window;
}

}  // namespace cloudcontact
