// MatterSums: integer sums over the voxels of a body that is cut. They add up exactly, so the parts
// of a body and what was cut off have together the mass, momentum and angular momentum of the
// whole. For that each voxel's material is spread evenly over the voxel. Cloud::massProperties()
// places it within surface voxels by their neighbors: its inertia is better (by h^2 / 2R^2 for a
// body of radius R), but does not add up.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

// Zeroth, first and second moments of the coverage of one material [1/255]. In matterSums(),
// positions are those of the voxels' centers from the middle of the grid [half voxels].
struct MatterSums {
  std::int64_t mass = 0;
  std::array<std::int64_t, 3> first{};   // x y z
  std::array<std::int64_t, 6> second{};  // xx yy zz xy yz zx

  // Adds a voxel.
  void add(const Eigen::Vector3i& position, std::int64_t coverage) {
    const std::int64_t x = position.x(), y = position.y(), z = position.z();
    mass += coverage;
    first[0] += coverage * x, first[1] += coverage * y, first[2] += coverage * z;
    second[0] += coverage * x * x, second[1] += coverage * y * y, second[2] += coverage * z * z;
    second[3] += coverage * x * y, second[4] += coverage * y * z, second[5] += coverage * z * x;
  }
  MatterSums& operator+=(const MatterSums& other);
  MatterSums& operator-=(const MatterSums& other);
  bool operator==(const MatterSums& o) const {
    return mass == o.mass && first == o.first && second == o.second;
  }
};

// The sums of each of the cloud's materials, or one where it has no list of materials. Throws
// std::length_error where the grid is so large that sums could overflow (for example 32,767 voxels
// long and a thousand full bricks wide).
std::vector<MatterSums> matterSums(const Cloud& cloud);
// The same from `known`, the sums of `before`, a cloud of the same grid and materials. Sums up only
// the bricks that differ.
std::vector<MatterSums> matterSums(const Cloud& cloud, const Cloud& before,
                                   std::vector<MatterSums> known);

// Mass properties from sums. `grid`: any cloud in the grid of the sums. `densities` [kg/m^3]: one
// per material, or one for all. Throws std::invalid_argument where their number does not fit or one
// is not positive and finite.
MassProperties massPropertiesOf(const std::vector<MatterSums>& sums, const Cloud& grid,
                                const std::vector<double>& densities);

// The same of a cloud. Where one density is for all, its inertia is that of
// Cloud::massProperties().
MassProperties massPropertiesOf(const Cloud& cloud, const std::vector<double>& densities);

}  // namespace cloudcontact
