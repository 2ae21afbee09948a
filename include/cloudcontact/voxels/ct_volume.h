// A body from a CT scan: densities on a grid become coverage and materials.
// Paper, Step 3: the tooth's voxels hold data of each material's quality.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

// Values of a scanner's grid, in Hounsfield units or any other that rise with density.
struct CtVolume {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  // values along x, y, z
  double voxelSize = 0;                            // edge of its cubes [m]
  Vec3 origin = Vec3::Zero();                      // lowest corner [m]
  std::vector<float> values;                       // x fastest
};

// Values from `from` up to the next range's are this material.
struct CtRange {
  double from = 0;
  std::string name;
};

// Voxels where the values are, of the grid's own size, with an empty voxel or two around. What is
// below the first range is air. A voxel that the body's surface passes through has a value between
// that of the matter and the air about it: where it stands between them is its coverage, and its
// material is that of the matter beside it, not what its own low value would say. Air is what most
// values below the first range are; that must lie above its noise. Throws std::invalid_argument
// where sizes do not fit, a value is NaN, the ranges do not ascend or are more than 256, and where
// all is air; std::length_error where the voxels would need more than `maxBytes`.
Cloud cloudFromCt(const CtVolume& volume, const std::vector<CtRange>& ranges,
                  std::size_t maxBytes = std::size_t{4} << 30);

}  // namespace cloudcontact
