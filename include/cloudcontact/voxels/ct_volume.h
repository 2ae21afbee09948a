// A body from a CT scan: densities on a grid become coverage and materials (paper, step 3: the
// voxels of a tooth hold the properties of enamel, dentin and pulp).
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

// The grid of a scanner, in Hounsfield units or any other value that increases with density.
struct CtVolume {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  // values along x, y, z
  Vec3 spacing = Vec3::Zero();                     // edges of a value's cell along x, y, z [m]
  Vec3 origin = Vec3::Zero();                      // lowest corner [m]
  std::vector<float> values;                       // x fastest
};

// A material: values from `from` up to the start of the next range.
struct CtRange {
  double from = 0;
  std::string name;
};

// How a CT volume becomes a cloud.
struct CtSettings {
  double voxelSize = 0;  // edge of the cloud's voxels [m]; 0: the smallest spacing
  // Of the voxels, if each of them stored numbers [bytes].
  std::size_t maxBytes = std::size_t{4} << 30;
};

// The body, with two empty voxels or more around. Values below the first range are air. The value
// of a cell at the surface lies between those of air and of the material next to it; its position
// between the two gives the coverage, and the neighbor gives the material. The first range must
// begin above the noise of the air. Where cells are no cubes of `voxelSize`, they are divided along
// the surface inside them. Throws std::invalid_argument where sizes do not fit, a value is NaN, the
// ranges do not ascend or are more than 256, or everything is air; std::length_error that names a
// voxel that fits where the voxels could need more than `maxBytes`.
Cloud cloudFromCt(const CtVolume& volume, const std::vector<CtRange>& ranges,
                  const CtSettings& settings = {});

}  // namespace cloudcontact
