// Sums shares per brick: see cloud_builder.h.
#include "voxels/cloud_builder.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "base/grid_index.h"
#include "voxels/grid.h"

namespace cloudcontact {

namespace {

constexpr double kHair = 1e-6;        // rounding error of a length [voxels]
constexpr double kLeastShare = 1e-7;  // of a voxel; the resolution of coverage is 1/255
constexpr double kMostPlaces = double(std::int64_t{1} << 30);  // 4 GB of table

}  // namespace

CloudGrid cloudGrid(const char* what, const Eigen::AlignedBox3d& box, double voxelSize,
                    const std::optional<Vec3>& lattice) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw std::invalid_argument(std::string(what) +
                                ": voxelSize must be positive and finite [m]; give one");
  if (box.isEmpty() || !box.min().allFinite() || !box.max().allFinite())
    throw std::invalid_argument(std::string(what) +
                                ": there is nothing, or it has no end; give finite points");
  const double brick = voxelSize * kBrickEdge;
  const Vec3 extent = (box.max() - box.min()) / brick;
  const Vec3 about = (extent.array() + (2.0 * kEmptyMargin + 1) / kBrickEdge).ceil();
  if (!(about.prod() <= kMostPlaces)) {
    std::ostringstream text;
    text << what << ": voxels of " << voxelSize << " m over " << (box.max() - box.min()).transpose()
         << " m would need more than 4 GB; choose a voxelSize of "
         << voxelSize * std::cbrt(about.prod() / kMostPlaces) * 1.1 << " m or larger";
    throw std::length_error(text.str());
  }
  CloudGrid grid;
  grid.voxelSize = voxelSize;
  if (lattice) {
    const Vec3 steps = ((box.min() - *lattice) / voxelSize).array() + kHair;
    grid.origin = *lattice + voxelSize * (steps.array().floor() - kEmptyMargin).matrix();
  } else {
    grid.origin = box.min() - Vec3::Constant(kEmptyMargin * voxelSize);
  }
  const Vec3 span = (box.max() - grid.origin) / voxelSize;
  grid.bricks = ((span.array() + kEmptyMargin - kHair) / kBrickEdge).ceil().cast<int>();
  if (!lattice)
    grid.origin = 0.5 * (box.min() + box.max()) - 0.5 * brick * grid.bricks.cast<double>();
  return grid;
}

CloudBuilder::CloudBuilder(const CloudGrid& grid, std::vector<std::string> materials)
    : grid_(grid), materials_(std::move(materials)) {
  const Eigen::Matrix<std::size_t, 3, 1> n = grid.bricks.cast<std::size_t>();
  table_.assign(n.prod(), kEmptyBrick);
}

void CloudBuilder::add(const Eigen::Vector3i& voxel, double share, std::uint8_t material) {
  if (!(share > kLeastShare)) return;
  if (!insideGrid(voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3, grid_.bricks)) return;
  std::int32_t& slot = table_[brickIndex(voxel, grid_.bricks)];
  if (slot < 0) {
    slot = static_cast<std::int32_t>(bricks_.size());
    bricks_.emplace_back();
  }
  Brick& brick = bricks_[slot];
  const auto v = static_cast<std::size_t>(cellIndex(voxel));
  const auto piece = static_cast<float>(share);
  brick.share[v] += piece;
  if (piece <= brick.most[v]) return;
  brick.most[v] = piece;
  brick.material[v] = material;
}

void CloudBuilder::addBox(const Vec3& low, const Vec3& high, double share, std::uint8_t material) {
  const Vec3 a = (low - grid_.origin) / grid_.voxelSize,
             b = (high - grid_.origin) / grid_.voxelSize;
  const Vec3 first = (a.array() + kHair).floor(), last = (b.array() - kHair).ceil();
  // The share of voxel k along an axis that lies in the box. Ends within kHair of a face snap to
  // it.
  const auto part = [&](int axis, int k) {
    const double from = k == first[axis] && a[axis] - k < kHair ? k : std::max<double>(a[axis], k);
    const double to =
        k + 1 == last[axis] && k + 1 - b[axis] < kHair ? k + 1 : std::min<double>(b[axis], k + 1);
    return to - from;
  };
  const Eigen::Vector3i from = first.cast<int>(), to = last.cast<int>();
  for (int z = from[2]; z < to[2]; ++z)
    for (int y = from[1]; y < to[1]; ++y) {
      const double across = share * part(2, z) * part(1, y);
      for (int x = from[0]; x < to[0]; ++x) add({x, y, z}, across * part(0, x), material);
    }
}

std::shared_ptr<Cloud::Voxels> emptyVoxels(const Eigen::Vector3i& bricks,
                                           const std::vector<std::string>& materials) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = bricks;
  voxels->table.assign(bricks.cast<std::size_t>().prod(), kEmptyBrick);
  voxels->materials = materials;
  if (!materials.empty()) voxels->materialTable.assign(voxels->table.size(), -1);
  return voxels;
}

void storeBrick(Cloud::Voxels& voxels, std::size_t entry, const BrickCoverage& coverage,
                const BrickMaterial* material) {
  const auto [least, most] = std::minmax_element(coverage.begin(), coverage.end());
  if (*most == 0) return;
  if (*least == 255) {
    voxels.table[entry] = kSolidBrick;
  } else {
    voxels.table[entry] = static_cast<std::int32_t>(voxels.coverage.size());
    voxels.coverage.push_back(coverage);
  }
  if (!material) return;
  int only = -1;  // the material of all voxels with coverage; -2: several
  for (std::size_t v = 0; v < coverage.size(); ++v)
    if (coverage[v] > 0 && (*material)[v] != only) only = only == -1 ? (*material)[v] : -2;
  if (only >= 0) {
    voxels.materialTable[entry] = -1 - only;
  } else {
    voxels.materialTable[entry] = static_cast<std::int32_t>(voxels.material.size());
    voxels.material.push_back(*material);
  }
}

Cloud CloudBuilder::build() const {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = grid_.bricks;
  voxels->table.assign(table_.size(), kEmptyBrick);
  voxels->materials = materials_;
  if (!materials_.empty()) voxels->materialTable.assign(table_.size(), -1);
  BrickCoverage coverage;
  for (std::size_t entry = 0; entry < table_.size(); ++entry) {
    if (table_[entry] < 0) continue;
    const Brick& brick = bricks_[table_[entry]];
    for (std::size_t v = 0; v < coverage.size(); ++v)
      coverage[v] = static_cast<std::uint8_t>(std::clamp(255 * brick.share[v] + 0.5f, 0.f, 255.f));
    storeBrick(*voxels, entry, coverage, materials_.empty() ? nullptr : &brick.material);
  }
  return Cloud(grid_.voxelSize, grid_.origin, std::move(voxels));
}

}  // namespace cloudcontact
