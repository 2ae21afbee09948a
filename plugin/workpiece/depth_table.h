// From how full a window is to how deep its voxel lies (DESIGN.md, "The method", 3).
#pragma once

#include <cloudcontact/workpiece/window.h>

#include <vector>

namespace cloudcontact {

// Made for planes, for each of many directions: faces along the grid differ from askew ones.
class DepthTable {
 public:
  DepthTable() = default;
  explicit DepthTable(const Window& window);

  // [voxels] signed depth of the voxel's centre below a plane with this outward unit normal that
  // leaves `fraction` of the window full.
  double at(double x, double y, double z, double fraction) const;
  double at(const Vec3& outward, double fraction) const {
    return at(outward.x(), outward.y(), outward.z(), fraction);
  }
  // No direction's depth lies within one voxel of the surface where the fraction is outside these.
  double least() const { return least_; }
  double most() const { return most_; }

 private:
  void bound();
  std::size_t direction(double x, double y, double z) const;
  int edge_ = 0;  // directions along each side of the octahedral map
  double least_ = 0, most_ = 1;
  std::vector<float> depth_;  // kFractions + 1 a direction
};

}  // namespace cloudcontact
