// Mass, centre and inertia of a body that is cut, from sums that add up: integers over its voxels,
// each voxel's matter spread evenly over the voxel. So the parts of a body, and what was cut off,
// have together exactly the whole's mass, momentum and angular momentum. Cloud::massProperties()
// also says where in its voxel an interface voxel's matter lies: a better inertia (by h^2 / 2R^2)
// that does not add up, for there the neighbours matter.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

// Of one material: coverage [1/255], times places, times squares of places. A voxel's place is its
// centre from the grid's middle, in half voxels.
struct MatterSums {
  std::int64_t mass = 0;
  std::array<std::int64_t, 3> first{};   // x y z
  std::array<std::int64_t, 6> second{};  // xx yy zz xy yz zx

  MatterSums& operator+=(const MatterSums& other);
  MatterSums& operator-=(const MatterSums& other);
  bool operator==(const MatterSums&) const = default;
};

// One for each of the cloud's materials, or one for all of it. Throws std::length_error where the
// grid is so large that they could not be held (32,767 voxels long and a thousand full bricks
// wide).
std::vector<MatterSums> matterSums(const Cloud& cloud);

// `grid`: any cloud of the same grid as that of the sums. `densities` [kg/m^3]: one a material, or
// one for all. Throws std::invalid_argument where their number is another or one is not positive.
MassProperties massPropertiesOf(const std::vector<MatterSums>& sums, const Cloud& grid,
                                const std::vector<double>& densities);

}  // namespace cloudcontact
