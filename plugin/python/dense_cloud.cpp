// Clouds from arrays of voxels, and back (dense_cloud.h).
#include "python/dense_cloud.h"

#include <algorithm>
#include <stdexcept>

#include "base/grid_index.h"
#include "voxels/cloud_builder.h"

namespace cloudcontact::python {
namespace {

constexpr int kBorder = 1;  // bricks on every side

void check(const DenseVoxels& voxels, const std::vector<std::string>& materials) {
  if (voxels.size.minCoeff() < 1)
    throw std::invalid_argument("voxels: the array is empty; give at least one voxel");
  if (std::all_of(voxels.coverage.begin(), voxels.coverage.end(), [](auto c) { return c == 0; }))
    throw std::invalid_argument("voxels: no voxel has material; give coverage above 0");
  if (voxels.material.empty()) return;
  if (materials.empty() || materials.size() > 256)
    throw std::invalid_argument("materials: give the names of 1 to 256 materials");
  const auto most = *std::max_element(voxels.material.begin(), voxels.material.end());
  if (most >= materials.size())
    throw std::invalid_argument("materials: a voxel is of number " + std::to_string(most) + " of " +
                                std::to_string(materials.size()) + "; name them all");
}

// The part of the array in a brick, whose lowest voxel is at `low` of the array.
template <typename Brick>
void take(const DenseVoxels& voxels, std::span<const std::uint8_t> numbers,
          const Eigen::Vector3i& low, Brick& brick) {
  brick.fill(0);
  for (int z = 0; z < kBrickEdge; ++z)
    for (int y = 0; y < kBrickEdge; ++y)
      for (int x = 0; x < kBrickEdge; ++x) {
        const Eigen::Vector3i v = low + Eigen::Vector3i(x, y, z);
        if ((v.array() >= voxels.size.array()).any()) continue;
        brick[static_cast<std::size_t>(cellIndex(x, y, z))] = numbers[gridIndex(v, voxels.size)];
      }
}

template <typename Of>
std::vector<std::uint8_t> dense(const Cloud& cloud, Of of) {
  const Eigen::Vector3i size = cloud.size();
  std::vector<std::uint8_t> numbers;
  numbers.reserve(size.cast<std::size_t>().prod());
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) numbers.push_back(of(x, y, z));
  return numbers;
}

}  // namespace

Cloud cloudFromDense(const DenseVoxels& voxels, double voxelSize, const Vec3& origin,
                     const std::vector<std::string>& materials) {
  check(voxels, materials);
  const Eigen::Vector3i inner =
      (voxels.size + Eigen::Vector3i::Constant(kBrickEdge - 1)) / kBrickEdge;
  const bool several = !voxels.material.empty();
  auto out = emptyVoxels(inner + Eigen::Vector3i::Constant(2 * kBorder),
                         several ? materials : std::vector<std::string>());
  BrickCoverage coverage;
  BrickMaterial material;
  for (int z = 0; z < inner.z(); ++z)
    for (int y = 0; y < inner.y(); ++y)
      for (int x = 0; x < inner.x(); ++x) {
        const Eigen::Vector3i low = kBrickEdge * Eigen::Vector3i(x, y, z);
        take(voxels, voxels.coverage, low, coverage);
        if (several) take(voxels, voxels.material, low, material);
        storeBrick(*out, gridIndex(x + kBorder, y + kBorder, z + kBorder, out->bricks), coverage,
                   several ? &material : nullptr);
      }
  return Cloud(voxelSize, origin - Vec3::Constant(kBorder * kBrickEdge * voxelSize),
               std::move(out));
}

std::vector<std::uint8_t> denseCoverage(const Cloud& cloud) {
  return dense(cloud, [&](int x, int y, int z) { return cloud.coverage(x, y, z); });
}

std::vector<std::uint8_t> denseMaterial(const Cloud& cloud) {
  return dense(cloud, [&](int x, int y, int z) { return cloud.material(x, y, z); });
}

}  // namespace cloudcontact::python
