// The visible voxels of a cloud, packed for a page.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <vector>

namespace cloudcontact::program {

// Voxels that are at least half full and have a neighbor that is not. Large clouds are merged into
// blocks of 2, 4 or at most 8 voxels' edge.
struct VoxelShell {
  double edge = 0;             // of a cube [m]
  int block = 1;               // voxels along it
  Vec3 origin = Vec3::Zero();  // lowest corner of cube (0,0,0), in the grid's frame [m]
  std::vector<std::uint16_t> x, y, z;
  std::vector<std::uint8_t> coverage;  // in 1/255
  std::vector<std::uint8_t> open;      // visible faces: bit 0 -x, 1 +x, 2 -y ... 5 +z

  bool operator==(const VoxelShell&) const = default;
};

VoxelShell voxelShell(const Cloud& cloud, std::size_t mostCubes = 250'000);

}  // namespace cloudcontact::program
