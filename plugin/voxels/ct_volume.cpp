// Coverage by partial volume: a voxel at the surface averages material and air, v = c m + (1 - c)
// a, where m is the densest of the 27 values around it and a the median of the air. This needs no
// knowledge of the tissues: surfaces of enamel and dentin are found alike.
//
// Noise must make neither wisps outside nor pores inside: values within four standard deviations of
// air or material count as air or material. The deviation is that of the air. The densest of some
// dozen full voxels lies about 1.8 deviations above their mean.
#include <cloudcontact/voxels/ct_volume.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "base/grid_index.h"
#include "voxels/cloud_builder.h"
#include "voxels/divided_voxels.h"

namespace cloudcontact {

namespace {

constexpr float kClear = 4;           // standard deviations
constexpr double kSameLength = 1e-6;  // lengths whose ratio differs by less are equal
constexpr int kBorder = 2;  // empty voxels around: a field needs its surface inside the grid

void validate(const CtVolume& volume, const std::vector<CtRange>& ranges) {
  if ((volume.size.array() < 1).any() || !(volume.spacing.array() > 0).all() ||
      !volume.spacing.allFinite() || !volume.origin.allFinite())
    throw std::invalid_argument("cloudFromCt: sizes and origin must be positive and finite");
  const double count = volume.size.cast<double>().prod();
  if (count != double(volume.values.size()))
    throw std::invalid_argument("cloudFromCt: " + std::to_string(volume.values.size()) +
                                " values for a grid of " + std::to_string(count));
  if (std::any_of(volume.values.begin(), volume.values.end(),
                  [](float v) { return std::isnan(v); }))
    throw std::invalid_argument("cloudFromCt: a value is NaN");
  if (ranges.empty() || ranges.size() > 256)
    throw std::invalid_argument("cloudFromCt: give 1 to 256 ranges");
  if (std::any_of(ranges.begin(), ranges.end(),
                  [](const CtRange& r) { return std::isnan(r.from); }))
    throw std::invalid_argument("cloudFromCt: a threshold is NaN");
  for (std::size_t k = 1; k < ranges.size(); ++k)
    if (!(ranges[k].from > ranges[k - 1].from))
      throw std::invalid_argument("cloudFromCt: the ranges must ascend; " + ranges[k].name +
                                  " does not");
}

struct Voxel {
  std::uint8_t coverage = 0, material = 0;
};

// The median value of the air and its deviation. Medians are robust against partial voxels.
struct Air {
  float value = 0, noise = 0;
};
Air airOf(const CtVolume& volume, double from) {
  std::vector<float> low;
  for (const float v : volume.values)
    if (v < from) low.push_back(v);
  const auto median = [&] {
    const auto middle = low.begin() + static_cast<std::ptrdiff_t>(low.size() / 2);
    std::nth_element(low.begin(), middle, low.end());
    return *middle;
  };
  // No air: the body fills the whole scan.
  if (low.empty()) return {static_cast<float>(from - 1), 0};
  Air air{median(), 0};
  for (float& v : low) v = std::abs(v - air.value);
  air.noise =
      1.4826f * median();  // standard deviation of a normal distribution from its median deviation
  return air;
}

class Reader {
 public:
  Reader(const CtVolume& volume, const std::vector<CtRange>& ranges, const Air& air)
      : volume_(volume), ranges_(ranges), air_(air) {}

  // Coverage and material of voxel (x, y, z); air outside the volume.
  Voxel at(int x, int y, int z) const {
    const float own = value(x, y, z);
    float least = own, most = own;
    for (int k = 0; k < 27; ++k) {
      const float v = value(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1);
      least = std::min(least, v), most = std::max(most, v);
    }
    const float from = ranges_[0].from;
    if (most < from || own <= air_.value + kClear * air_.noise) return {};
    if (least >= from) return {255, materialOf(own)};
    const float full = std::max(most - 1.8f * air_.noise, own);
    const double share = (own - air_.value) / (full - air_.value);
    const bool near = own >= full - kClear * air_.noise;
    return {static_cast<std::uint8_t>(near ? 255 : std::lround(255 * share)), materialOf(most)};
  }

 private:
  float value(int x, int y, int z) const {
    if (!insideGrid(x, y, z, volume_.size)) return air_.value;
    return volume_.values[gridIndex(x, y, z, volume_.size)];
  }
  std::uint8_t materialOf(float v) const {
    std::size_t k = ranges_.size() - 1;
    while (k > 0 && v < ranges_[k].from) --k;
    return static_cast<std::uint8_t>(k);
  }

  const CtVolume& volume_;
  const std::vector<CtRange>& ranges_;
  Air air_;
};

// Throws where voxels of that edge over that box could need more than `most` bytes.
void refuseMemory(const Vec3& extent, double voxel, std::size_t most) {
  const double bytes = (extent / voxel).array().ceil().prod() * 2;  // coverage and material
  if (!(bytes > static_cast<double>(most))) return;
  std::ostringstream text;
  text << "cloudFromCt: voxels of " << voxel << " m over " << extent.transpose() << " m could need "
       << bytes / 1e9 << " GB; choose a voxelSize of "
       << voxel * std::cbrt(bytes / static_cast<double>(most)) * 1.1 << " m or larger";
  throw std::length_error(text.str());
}

// A voxel for each value, in a border of air.
std::shared_ptr<const Cloud::Voxels> cellsOf(const CtVolume& volume,
                                             const std::vector<CtRange>& ranges) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  const Eigen::Vector3i all = volume.size + Eigen::Vector3i::Constant(2 * kBorder);
  voxels->bricks = (all + Eigen::Vector3i::Constant(kBrickEdge - 1)) / kBrickEdge;
  if (ranges.size() > 1)
    for (const CtRange& range : ranges) voxels->materials.push_back(range.name);
  const auto count = voxels->bricks.cast<std::size_t>().prod();
  voxels->table.assign(count, kEmptyBrick);
  if (ranges.size() > 1) voxels->materialTable.assign(count, -1);
  const Reader reader(volume, ranges, airOf(volume, ranges[0].from));
  for (std::size_t entry = 0; entry < count; ++entry) {
    const Eigen::Vector3i b = gridCell(entry, voxels->bricks);
    BrickCoverage coverage;
    BrickMaterial material;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Eigen::Vector3i v = kBrickEdge * b + cellOffset(k) - Eigen::Vector3i::Constant(kBorder);
      const Voxel m = reader.at(v.x(), v.y(), v.z());
      coverage[k] = m.coverage;
      material[k] = m.coverage > 0 ? m.material : std::uint8_t{0};
    }
    storeBrick(*voxels, entry, coverage, ranges.size() > 1 ? &material : nullptr);
  }
  return voxels;
}

}  // namespace

Cloud cloudFromCt(const CtVolume& volume, const std::vector<CtRange>& ranges,
                  const CtSettings& settings) {
  validate(volume, ranges);
  const double least = volume.spacing.minCoeff();
  const double voxel = settings.voxelSize != 0 ? settings.voxelSize : least;
  if (!(voxel > 0) || !std::isfinite(voxel))
    throw std::invalid_argument("cloudFromCt: voxelSize must be positive and finite [m]");
  const Vec3 extent = volume.size.cast<double>().cwiseProduct(volume.spacing);
  refuseMemory(extent, voxel, settings.maxBytes);
  const Vec3 origin = volume.origin - kBorder * volume.spacing;
  const Cloud cells(voxel, origin, cellsOf(volume, ranges));
  if (cells.counts().inside + cells.counts().interface == 0)
    throw std::invalid_argument(
        "cloudFromCt: all values are below the first range: nothing but air");
  const bool areVoxels = (volume.spacing.array() - voxel).abs().maxCoeff() <= kSameLength * voxel;
  if (areVoxels) return cells;
  return inVoxels("cloudFromCt", cells, volume.spacing, origin, voxel);
}

}  // namespace cloudcontact
