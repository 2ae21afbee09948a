// The table is measured: a plane is moved through the window, each voxel's coverage is the closed
// form of plane_cell.h, and where the window's fraction passes a table's mark the plane's place is
// noted. The fraction grows with depth whatever the window's shape, so each mark has one place.
#include "depth_table.h"

#include <algorithm>
#include <cmath>

#include "plane_cell.h"

namespace cloudcontact {

namespace {

constexpr int kFractions = 64;  // depths between two marks are off by 0.002 voxel in the middle
constexpr int kSteps = 8;       // of the plane a voxel
// Directions along a side of the map: 17 leave 0.005 voxel between neighbours. Large windows see
// the grid less and cost more.
constexpr int kEdge = 17, kCoarseEdge = 7;
constexpr std::size_t kLargeWindow = 400;  // voxels

Vec3 directionAt(double u, double v) {
  Vec3 n(u, v, 1 - std::abs(u) - std::abs(v));
  if (n.z() < 0) {
    const double x = (1 - std::abs(n.y())) * (n.x() < 0 ? -1 : 1);
    n.y() = (1 - std::abs(n.x())) * (n.y() < 0 ? -1 : 1);
    n.x() = x;
  }
  return n.normalized();
}

// Of the window, below the plane n.x < offset.
double fractionBelow(const Window& window, const Vec3& n, double offset) {
  double sum = 0;
  for (const WindowTap& t : window.taps) {
    const double to = offset - n.dot(Vec3(t.x, t.y, t.z));
    const CcCut cut = ccCutCube(static_cast<float>(n.x()), static_cast<float>(n.y()),
                                static_cast<float>(n.z()), static_cast<float>(to));
    sum += t.weight * static_cast<double>(cut.volume);
  }
  return sum / static_cast<double>(window.weights);
}

void measure(const Window& window, const Vec3& n, float* depth) {
  double low = 1e30, high = -1e30;
  for (const WindowTap& t : window.taps) {
    const double at = n.dot(Vec3(t.x, t.y, t.z)), half = 0.5 * n.cwiseAbs().sum();
    low = std::min(low, at - half), high = std::max(high, at + half);
  }
  const int steps = static_cast<int>(std::ceil((high - low) * kSteps));
  double before = 0, place = low;
  int mark = 1;
  depth[0] = static_cast<float>(low);
  for (int k = 1; k <= steps && mark < kFractions; ++k) {
    const double offset = low + (high - low) * k / steps;
    const double now = fractionBelow(window, n, offset);
    for (; mark < kFractions && now * kFractions >= mark; ++mark)
      depth[mark] = static_cast<float>(
          place +
          (offset - place) * (static_cast<double>(mark) / kFractions - before) / (now - before));
    before = now, place = offset;
  }
  for (; mark <= kFractions; ++mark) depth[mark] = static_cast<float>(high);
}

}  // namespace

DepthTable::DepthTable(const Window& window)
    : edge_(window.taps.size() > kLargeWindow ? kCoarseEdge : kEdge) {
  depth_.resize(static_cast<std::size_t>(edge_ * edge_) * (kFractions + 1));
  for (int v = 0; v < edge_; ++v)
    for (int u = 0; u < edge_; ++u)
      measure(window, directionAt((2 * u + 1.0) / edge_ - 1, (2 * v + 1.0) / edge_ - 1),
              &depth_[static_cast<std::size_t>(v * edge_ + u) * (kFractions + 1)]);
}

std::size_t DepthTable::direction(const Vec3& outward) const {
  const Vec3 n = outward / outward.cwiseAbs().sum();
  double u = n.x(), v = n.y();
  if (n.z() < 0) {
    u = (1 - std::abs(n.y())) * (n.x() < 0 ? -1 : 1);
    v = (1 - std::abs(n.x())) * (n.y() < 0 ? -1 : 1);
  }
  const auto place = [&](double x) {
    return std::clamp(static_cast<int>((x * 0.5 + 0.5) * edge_), 0, edge_ - 1);
  };
  return static_cast<std::size_t>(place(v) * edge_ + place(u)) * (kFractions + 1);
}

double DepthTable::at(const Vec3& outward, double fraction) const {
  const double f = std::clamp(fraction, 0.0, 1.0) * kFractions;
  const int low = std::min(static_cast<int>(f), kFractions - 1);
  const float* const d = &depth_[direction(outward) + static_cast<std::size_t>(low)];
  return static_cast<double>(d[0]) + (f - low) * static_cast<double>(d[1] - d[0]);
}

}  // namespace cloudcontact
