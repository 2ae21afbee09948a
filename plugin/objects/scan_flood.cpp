// Flood fill around the points of a scan: see scan_flood.h.
#include "objects/scan_flood.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace cloudcontact {

using Eigen::Vector3i;

namespace {
constexpr double kMostCells = double(std::int64_t{1} << 31);
}

ScanFlood::ScanFlood(const std::vector<Vec3>& points, double gap) : cell_(0.5 * gap) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  origin_ = box.min() - Vec3::Constant(gap + 2 * cell_);
  const Vec3 cells = ((box.sizes().array() + 2 * gap + 4 * cell_) / cell_).ceil();
  if (!(cells.prod() <= kMostCells)) {
    std::ostringstream text;
    text << "points: to tell inside from outside at gaps of " << gap
         << " m takes more than 2 GB; give a larger gap, or take away points far from the rest";
    throw std::length_error(text.str());
  }
  size_ = cells.cast<int>();
  side_.assign(size_.cast<std::size_t>().prod(), Side::Unknown);
  for (const Vec3& p : points) wallAround(p, gap);
  flood();
  closed_ = std::find(side_.begin(), side_.end(), Side::Unknown) != side_.end();
}

void ScanFlood::wallAround(const Vec3& point, double gap) {
  const Vec3 at = (point - origin_) / cell_;
  const double reach = gap / cell_;
  const Vector3i low = (at.array() - reach).floor().cast<int>(),
                 high = (at.array() + reach).floor().cast<int>();
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x)
        if ((Vec3(x + 0.5, y + 0.5, z + 0.5) - at).squaredNorm() <= reach * reach)
          side_[index({x, y, z})] = Side::Wall;
}

void ScanFlood::flood() {
  std::vector<Vector3i> front{Vector3i::Zero()};
  side_[0] = Side::Outside;
  while (!front.empty()) {
    const Vector3i at = front.back();
    front.pop_back();
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        const Vector3i next = at + step * Vector3i::Unit(axis);
        if (next[axis] < 0 || next[axis] >= size_[axis]) continue;
        Side& side = side_[index(next)];
        if (side != Side::Unknown) continue;
        side = Side::Outside;
        front.push_back(next);
      }
  }
}

ScanFlood::Side ScanFlood::sideAt(const Vec3& at) const {
  const Vec3 cell = ((at - origin_) / cell_).array().floor();
  if (!((cell.array() >= 0).all() && (cell.array() < size_.cast<double>().array()).all()))
    return Side::Outside;
  return side_[index(cell.cast<int>())];
}

}  // namespace cloudcontact
