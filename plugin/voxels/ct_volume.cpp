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
#include <stdexcept>

#include "base/grid_index.h"

namespace cloudcontact {

namespace {

constexpr float kClear = 4;  // standard deviations
constexpr int kBorder = 2;   // empty voxels around: a field needs its surface inside the grid

void validate(const CtVolume& volume, const std::vector<CtRange>& ranges) {
  if ((volume.size.array() < 1).any() || !(volume.voxelSize > 0) ||
      !std::isfinite(volume.voxelSize) || !volume.origin.allFinite())
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

}  // namespace

Cloud cloudFromCt(const CtVolume& volume, const std::vector<CtRange>& ranges,
                  std::size_t maxBytes) {
  validate(volume, ranges);
  auto voxels = std::make_shared<Cloud::Voxels>();
  const Eigen::Vector3i all = volume.size + Eigen::Vector3i::Constant(2 * kBorder);
  voxels->bricks = (all + Eigen::Vector3i::Constant(kBrickEdge - 1)) / kBrickEdge;
  const double bytes = voxels->bricks.cast<double>().prod() * 2.0 * kBrickVoxels;
  if (bytes > static_cast<double>(maxBytes))
    throw std::length_error("cloudFromCt: the voxels may need " + std::to_string(bytes / 1e9) +
                            " GB; take every second value");
  for (const CtRange& range : ranges) voxels->materials.push_back(range.name);
  if (ranges.size() == 1) voxels->materials.clear();
  const Reader reader(volume, ranges, airOf(volume, ranges[0].from));
  bool any = false;
  for (int bz = 0; bz < voxels->bricks.z(); ++bz)
    for (int by = 0; by < voxels->bricks.y(); ++by)
      for (int bx = 0; bx < voxels->bricks.x(); ++bx) {
        BrickCoverage coverage;
        BrickMaterial material;
        for (int k = 0; k < kBrickVoxels; ++k) {
          const Eigen::Vector3i v = kBrickEdge * Eigen::Vector3i(bx, by, bz) + cellOffset(k) -
                                    Eigen::Vector3i::Constant(kBorder);
          const Voxel m = reader.at(v.x(), v.y(), v.z());
          coverage[k] = m.coverage;
          material[k] = m.coverage > 0 ? m.material : std::uint8_t{0};
        }
        const auto same = [](const auto& values, int v) {
          return std::all_of(values.begin(), values.end(), [v](int x) { return x == v; });
        };
        const bool empty = same(coverage, 0), solid = same(coverage, 255);
        any = any || !empty;
        voxels->table.push_back(empty   ? kEmptyBrick
                                : solid ? kSolidBrick
                                        : static_cast<std::int32_t>(voxels->coverage.size()));
        if (!empty && !solid) voxels->coverage.push_back(coverage);
        if (voxels->materials.empty()) continue;
        const bool one = same(material, material[0]);
        voxels->materialTable.push_back(one ? -1 - material[0]
                                            : static_cast<std::int32_t>(voxels->material.size()));
        if (!one) voxels->material.push_back(material);
      }
  if (!any)
    throw std::invalid_argument("cloudFromCt: all values are below " +
                                std::to_string(ranges[0].from) + ": nothing but air");
  return Cloud(volume.voxelSize, volume.origin - Vec3::Constant(kBorder * volume.voxelSize),
               std::move(voxels));
}

}  // namespace cloudcontact
