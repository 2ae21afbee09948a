// Sums the voxels of a cloud, brick by brick of the coarser one.
#include <cloudcontact/voxels/coarser_cloud.h>

#include <algorithm>
#include <stdexcept>

#include "base/grid_index.h"
#include "voxels/cloud_builder.h"
#include "voxels/grid.h"

namespace cloudcontact {

namespace {

constexpr int kMostHalvings = 10;

// A coarse brick's sums [1/255 of a fine voxel]: of all matter, and of each material.
class BrickSum {
 public:
  BrickSum(const Cloud::Voxels& fine, int halvings)
      : fine_(fine),
        halvings_(halvings),
        materials_(fine.materialTable.empty() ? 0 : fine.materials.size()),
        sums_(kBrickVoxels),
        parts_(materials_ * kBrickVoxels) {}

  // Of the coarse brick whose first voxel is the fine voxel `corner`. False if it is empty.
  bool sum(const Eigen::Vector3i& corner) {
    isEmpty_ = true;
    std::fill(sums_.begin(), sums_.end(), 0);
    std::fill(parts_.begin(), parts_.end(), 0);
    const Eigen::Vector3i end = corner + Eigen::Vector3i::Constant(kBrickEdge << halvings_);
    // `corner` need not lie on the fine bricks.
    for (int z = corner.z() >> 3; z <= (end.z() - 1) >> 3; ++z)
      for (int y = corner.y() >> 3; y <= (end.y() - 1) >> 3; ++y)
        for (int x = corner.x() >> 3; x <= (end.x() - 1) >> 3; ++x)
          if (insideGrid(x, y, z, fine_.bricks)) add({x, y, z}, corner, end);
    return !isEmpty_;
  }

  BrickCoverage coverage() const {
    BrickCoverage mean;
    const std::uint64_t voxels = std::uint64_t{1} << 3 * halvings_, half = voxels / 2;
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      const std::uint64_t whole = sums_[k] / voxels, rest = sums_[k] % voxels;
      const bool up = rest > half || (rest == half && rest > 0 && whole % 2 == 1);
      mean[k] = static_cast<std::uint8_t>(whole + (up ? 1 : 0));
    }
    return mean;
  }
  // The first of those with the most matter.
  BrickMaterial material() const {
    BrickMaterial most{};
    for (std::size_t k = 0; k < kBrickVoxels; ++k)
      for (std::size_t m = 1; m < materials_; ++m)
        if (part(m, k) > part(most[k], k)) most[k] = static_cast<std::uint8_t>(m);
    return most;
  }
  bool hasMaterials() const { return materials_ > 0; }

 private:
  std::uint64_t part(std::size_t m, std::size_t k) const { return parts_[m * kBrickVoxels + k]; }

  void add(const Eigen::Vector3i& brick, const Eigen::Vector3i& corner,
           const Eigen::Vector3i& end) {
    const std::size_t entry = gridIndex(brick, fine_.bricks);
    const std::int32_t b = fine_.table[entry];
    if (b == kEmptyBrick) return;
    isEmpty_ = false;
    const BrickCoverage* const coverage = b == kSolidBrick ? nullptr : &fine_.coverage[b];
    const std::int32_t m = materials_ > 0 ? fine_.materialTable[entry] : -1;
    const Eigen::Vector3i low = corner.cwiseMax(kBrickEdge * brick),
                          high = end.cwiseMin(kBrickEdge * (brick + Eigen::Vector3i::Ones()));
    for (int z = low.z(); z < high.z(); ++z)
      for (int y = low.y(); y < high.y(); ++y)
        for (int x = low.x(); x < high.x(); ++x) {
          const auto cell = static_cast<std::size_t>(cellIndex(x, y, z));
          const std::uint64_t c = coverage ? (*coverage)[cell] : 255;
          const Eigen::Vector3i at = Eigen::Vector3i(x, y, z) - corner;
          const auto to = static_cast<std::size_t>(
              cellIndex(at.x() >> halvings_, at.y() >> halvings_, at.z() >> halvings_));
          sums_[to] += c;
          if (materials_ > 0)
            parts_[(m < 0 ? static_cast<std::size_t>(-1 - m) : fine_.material[m][cell]) *
                       kBrickVoxels +
                   to] += c;
        }
  }

  const Cloud::Voxels& fine_;
  int halvings_;
  std::size_t materials_;
  std::vector<std::uint64_t> sums_, parts_;
  bool isEmpty_ = true;
};

}  // namespace

Cloud coarserCloud(const Cloud& cloud, int halvings) {
  if (halvings < 0 || halvings > kMostHalvings)
    throw std::invalid_argument("coarserCloud: halvings must be in 0..10");
  if (halvings == 0 || cloud.empty()) return cloud;
  const int edge = 1 << halvings;
  const Eigen::Array3i across = (cloud.size().array() + (edge - 1)) / edge + 2 * kEmptyMargin;
  auto voxels = emptyVoxels((across + (kBrickEdge - 1)) / kBrickEdge, cloud.materials());
  BrickSum sum(cloud.voxels(), halvings);
  for (std::size_t entry = 0; entry < voxels->table.size(); ++entry) {
    const Eigen::Vector3i first = kBrickEdge * gridCell(entry, voxels->bricks);
    if (!sum.sum((first - Eigen::Vector3i::Constant(kEmptyMargin)) * edge)) continue;
    const BrickMaterial material = sum.material();
    storeBrick(*voxels, entry, sum.coverage(), sum.hasMaterials() ? &material : nullptr);
  }
  voxels->coverage.shrink_to_fit();
  voxels->material.shrink_to_fit();
  return Cloud(edge * cloud.voxelSize(),
               cloud.origin() - Vec3::Constant(kEmptyMargin * edge * cloud.voxelSize()),
               std::move(voxels));
}

}  // namespace cloudcontact
