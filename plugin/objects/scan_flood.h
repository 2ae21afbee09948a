// ScanFlood: separates the outside of a scan from its inside by flood fill. Cells near the points
// are walls; cells that the flood reaches from the border are outside, the others inside.
#pragma once

#include <cloudcontact/base/pose.h>

#include <cstdint>
#include <vector>

#include "base/grid_index.h"

namespace cloudcontact {

class ScanFlood {
 public:
  enum class Side : std::uint8_t { Unknown, Wall, Outside };  // Unknown: not reached, inside

  // Cells have an edge of gap / 2 [m]; walls lie within `gap` of a point. Throws std::length_error
  // where the cells would need more than 2 GB.
  ScanFlood(const std::vector<Vec3>& points, double gap);

  bool inside(const Vec3& at) const { return sideAt(at) == Side::Unknown; }
  bool outside(const Vec3& at) const { return sideAt(at) == Side::Outside; }
  // Whether any cell is inside.
  bool closed() const { return closed_; }
  double cell() const { return cell_; }  // [m]

 private:
  Side sideAt(const Vec3& at) const;
  std::size_t index(const Eigen::Vector3i& c) const { return gridIndex(c, size_); }
  void wallAround(const Vec3& point, double gap);
  void flood();

  double cell_;
  Vec3 origin_;
  Eigen::Vector3i size_;
  std::vector<Side> side_;
  bool closed_ = false;
};

}  // namespace cloudcontact
