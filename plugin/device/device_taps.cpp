// Which kernels a window suits, and its taps for them.
#include "device/device_taps.h"

#include <cloudcontact/voxels/cloud.h>

#include <algorithm>
#include <tuple>

#include "field/brick_layout.h"

namespace cloudcontact::opencl {

namespace {

constexpr std::size_t kMaxFlatTaps = 1024;  // twice 16 kB of constant memory
constexpr double kExactInFloat = 1 << 24;

Eigen::Vector3i tileEdges(const Window& window) {
  return Eigen::Vector3i::Constant(kBrickEdge) + window.high - window.low;
}

std::size_t tileOf(const Window& window) {
  const Eigen::Vector3i edge = tileEdges(window);
  return static_cast<std::size_t>(CC_TILE_ROW * edge.y() * edge.z()) * sizeof(cl_half);
}

// An upper bound of the local memory in use [bytes].
std::size_t localBytesOf(const Window& window) {
  const std::size_t taps = window.taps.size() * (sizeof(cl_float4) + sizeof(CcFlatRun)),
                    lostColumns = CC_TILE_ROW * CC_TILE_ROW * sizeof(cl_uint),
                    neighbors = 27 * sizeof(cl_int);
  return tileOf(window) + taps + lostColumns + neighbors;
}

bool suitsFlat(const Window& window, std::size_t localBytes) {
  const Eigen::Vector3i edge = tileEdges(window);
  double most[4] = {0, 0, 0, 0};
  for (const WindowTap& t : window.taps) {
    most[3] += 255.0 * t.weight;
    for (int k = 0; k < 3; ++k) most[k] += 255.0 * std::abs(t.moment[k]);
  }
  return (window.low.array() <= 0).all() && (window.high.array() >= 0).all() &&
         (window.low.array() >= -8).all() && (window.high.array() <= 8).all() &&
         edge.x() <= CC_TILE_ROW &&
         std::int64_t{CC_TILE_ROW} * edge.y() * edge.z() <= CC_TILE_CELLS &&
         window.taps.size() <= kMaxFlatTaps && *std::max_element(most, most + 4) < kExactInFloat &&
         localBytesOf(window) <= localBytes;
}

}  // namespace

void DeviceTaps::send(Device& device, const Window& window, const char* label) {
  flat_ = suitsFlat(window, device.localBytes());
  tile_ = tileOf(window);
  any_.clear();
  by_.clear();
  runs_.clear();
  if (!flat_) {
    any_ = windowTaps(window);
    deviceTaps_.fill(device, any_, label);
    return;
  }
  addRuns(window);
  deviceTaps_.fill(device, by_, label);
  deviceRuns_.fill(device, runs_, label);
}

std::size_t DeviceTaps::sentBytes() const {
  return any_.size() * sizeof(CcWindowTap) + by_.size() * sizeof(cl_float4) +
         runs_.size() * sizeof(CcFlatRun);
}

void DeviceTaps::addRuns(const Window& window) {
  std::vector<WindowTap> sorted = window.taps;
  std::stable_sort(sorted.begin(), sorted.end(), [](const WindowTap& a, const WindowTap& b) {
    return std::tie(a.y, a.x, a.z) < std::tie(b.y, b.x, b.z);
  });
  const int edgeY = tileEdges(window).y();
  const WindowTap* last = nullptr;
  for (const WindowTap& t : sorted) {
    const bool continues = last && last->x == t.x && last->y == t.y && last->z + 1 == t.z &&
                           runs_.back().count < CC_RUN;
    if (!continues)
      runs_.push_back({t.x + CC_TILE_ROW * (t.y + edgeY * t.z), static_cast<cl_int>(by_.size()), 0,
                       t.z - window.low.z()});
    ++runs_.back().count;
    by_.push_back({{float(t.weight), float(t.moment[0]), float(t.moment[1]), float(t.moment[2])}});
    last = &t;
  }
}

}  // namespace cloudcontact::opencl
