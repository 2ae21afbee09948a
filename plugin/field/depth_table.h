// A lookup table from how full a window is to how deep its voxel lies (docs/engine.md, "Depth from
// the window").
#pragma once

#include <cloudcontact/field/window.h>

#include <vector>

namespace cloudcontact {

// Measured on planes in many directions, since faces along the grid differ from oblique ones.
class DepthTable {
 public:
  DepthTable() = default;
  explicit DepthTable(const Window& window);

  // Signed depth of the voxel's center below a plane with this outward unit normal that leaves
  // `fraction` of the window full [voxels].
  double at(double x, double y, double z, double fraction) const;
  double at(const Vec3& outward, double fraction) const {
    return at(outward.x(), outward.y(), outward.z(), fraction);
  }
  // Outside these fractions, the depth is more than a voxel in all directions.
  double least() const { return least_; }
  double most() const { return most_; }

 private:
  void bound();
  std::size_t direction(double x, double y, double z) const;
  int edge_ = 0;  // directions along each side of the octahedral map
  double least_ = 0, most_ = 1;
  std::vector<float> depth_;  // kFractions + 1 per direction
};

}  // namespace cloudcontact
