// The table is measured: a plane moves through the window, with the coverage of each voxel in
// closed form (plane_cell.h), and its offset is stored where the fraction reaches an entry's. The
// fraction grows with depth for any shape of window, so each entry has one offset.
#include "field/depth_table.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/plane_cell.h"

namespace cloudcontact {

namespace {

constexpr int kFractions = 64;  // entries per direction, linear between
constexpr int kSteps = 8;       // of the plane per voxel
// Directions along a side of the octahedral map; odd, so that one is the z axis. Large windows
// depend less on the direction and cost more.
constexpr int kEdge = 17, kCoarseEdge = 7;
constexpr std::size_t kLargeWindow = 400;  // voxels

// The direction at a place of the octahedral map.
Vec3 directionAt(double u, double v) {
  Vec3 n(u, v, 1 - std::abs(u) - std::abs(v));
  if (n.z() < 0) {
    const double x = (1 - std::abs(n.y())) * (n.x() < 0 ? -1 : 1);
    n.y() = (1 - std::abs(n.x())) * (n.y() < 0 ? -1 : 1);
    n.x() = x;
  }
  return n.normalized();
}

// The fraction of the window below the plane n.x = offset.
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
  bound();
}

void DepthTable::bound() {
  int low = kFractions, high = 0;
  for (std::size_t k = 0; k < depth_.size(); ++k) {
    const int mark = static_cast<int>(k % (kFractions + 1));
    if (depth_[k] > -1) low = std::min(low, mark);
    if (depth_[k] < 1) high = std::max(high, mark);
  }
  least_ = static_cast<double>(low - 1) / kFractions;
  most_ = static_cast<double>(high + 1) / kFractions;
}

std::size_t DepthTable::direction(double x, double y, double z) const {
  const double scale = 1 / (std::abs(x) + std::abs(y) + std::abs(z));
  double u = x * scale, v = y * scale;
  if (z < 0) {
    const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
    v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
    u = folded;
  }
  const auto place = [&](double t) {
    return std::clamp(static_cast<int>((t * 0.5 + 0.5) * edge_), 0, edge_ - 1);
  };
  return static_cast<std::size_t>(place(v) * edge_ + place(u)) * (kFractions + 1);
}

double DepthTable::at(double x, double y, double z, double fraction) const {
  const double f = std::clamp(fraction, 0.0, 1.0) * kFractions;
  const int low = std::min(static_cast<int>(f), kFractions - 1);
  const float* const d = &depth_[direction(x, y, z) + static_cast<std::size_t>(low)];
  return static_cast<double>(d[0]) + (f - low) * static_cast<double>(d[1] - d[0]);
}

}  // namespace cloudcontact
