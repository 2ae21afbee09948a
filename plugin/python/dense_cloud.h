// Clouds from arrays of voxels, and back.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <span>
#include <string>
#include <vector>

namespace cloudcontact::python {

// Numbers of voxels, x fastest. `size`: along each axis.
struct DenseVoxels {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  std::span<const std::uint8_t> coverage;
  std::span<const std::uint8_t> material;  // empty: one material
};

// The array in the middle of a grid that is a brick wider on every side: a field needs its surface
// inside the grid. `origin`: the array's lowest corner [m]. Throws std::invalid_argument where the
// array is empty, holds no coverage or a material without a name.
Cloud cloudFromDense(const DenseVoxels& voxels, double voxelSize, const Vec3& origin,
                     const std::vector<std::string>& materials);

// All voxels of the cloud's grid, x fastest.
std::vector<std::uint8_t> denseCoverage(const Cloud& cloud);
std::vector<std::uint8_t> denseMaterial(const Cloud& cloud);

}  // namespace cloudcontact::python
