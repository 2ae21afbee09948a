// clipToBox(): the part of a segment that lies in a box.
#pragma once

#include <cloudcontact/base/pose.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <utility>

namespace cloudcontact {

// The part of `from` to `from + way` in the box, ends included, as fractions of `way`. Empty if
// there is none.
inline std::optional<std::pair<double, double>> clipToBox(const Vec3& from, const Vec3& way,
                                                          const Eigen::AlignedBox3d& box) {
  double first = 0, last = 1;
  for (int i = 0; i < 3; ++i) {
    double low = box.min()[i] - from[i], high = box.max()[i] - from[i];
    if (way[i] == 0 && (low > 0 || high < 0)) return std::nullopt;
    if (way[i] == 0) continue;
    if (way[i] < 0) std::swap(low, high);
    first = std::max(first, low / way[i]);
    last = std::min(last, high / way[i]);
  }
  if (first > last) return std::nullopt;
  return std::pair(first, last);
}

}  // namespace cloudcontact
