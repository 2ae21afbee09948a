// Integer moments, brick by brick: first about the brick's corner, where they are small, then moved
// to the middle of the grid.
#include <cloudcontact/voxels/matter_sums.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "base/grid_index.h"
#include "voxels/cut_between.h"

namespace cloudcontact {

namespace {

using Int = std::int64_t;

// The sums about another point: all positions increase by `by`.
MatterSums moved(MatterSums s, const Eigen::Vector3i& by) {
  const Int b[3] = {by.x(), by.y(), by.z()};
  const std::array<Int, 3> f = s.first;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    s.second[i] += 2 * b[i] * f[i] + b[i] * b[i] * s.mass;
    s.second[i + 3] += b[i] * f[j] + b[j] * f[i] + b[i] * b[j] * s.mass;
    s.first[i] += b[i] * s.mass;
  }
  return s;
}

template <typename CoverageAt>
MatterSums brickSums(CoverageAt&& coverageAt) {
  MatterSums sums;
  for (int k = 0; k < kBrickVoxels; ++k)
    if (const Int c = coverageAt(k)) sums.add(2 * cellOffset(k) + Eigen::Vector3i::Ones(), c);
  return sums;
}

void checkSize(const Cloud& cloud) {
  double bricks = 0;
  for (const std::int32_t b : cloud.voxels().table) bricks += b != kEmptyBrick;
  const double far = cloud.size().maxCoeff();
  if (255.0 * kBrickVoxels * bricks * far * far > 9e18)
    throw std::length_error(
        "matterSums: the cloud is too large for exact sums; take larger voxels");
}

// Adds a brick's sums to those of its materials.
void addBrick(const Cloud& cloud, std::size_t t, std::vector<MatterSums>& sums) {
  static const MatterSums kSolid = brickSums([](int) { return 255; });
  const Cloud::Voxels& voxels = cloud.voxels();
  const std::int32_t b = voxels.table[t];
  if (b == kEmptyBrick) return;
  const Eigen::Vector3i corner = 2 * kBrickEdge * gridCell(t, cloud.bricks()) - cloud.size();
  const auto coverage = [&](int k) { return int(coverageIn(voxels, b, k)); };
  const std::int32_t m = voxels.materialTable.empty() ? -1 : voxels.materialTable[t];
  if (m < 0) {
    sums[-1 - m] += moved(b == kSolidBrick ? kSolid : brickSums(coverage), corner);
    return;
  }
  const BrickMaterial& of = voxels.material[m];
  for (std::size_t which = 0; which < sums.size(); ++which)
    sums[which] +=
        moved(brickSums([&](int k) { return of[k] == which ? coverage(k) : 0; }), corner);
}

}  // namespace

MatterSums& MatterSums::operator+=(const MatterSums& other) {
  mass += other.mass;
  for (std::size_t i = 0; i < 3; ++i) first[i] += other.first[i];
  for (std::size_t i = 0; i < 6; ++i) second[i] += other.second[i];
  return *this;
}

MatterSums& MatterSums::operator-=(const MatterSums& other) {
  mass -= other.mass;
  for (std::size_t i = 0; i < 3; ++i) first[i] -= other.first[i];
  for (std::size_t i = 0; i < 6; ++i) second[i] -= other.second[i];
  return *this;
}

std::vector<MatterSums> matterSums(const Cloud& cloud) {
  std::vector<MatterSums> sums(std::max<std::size_t>(1, cloud.materials().size()));
  if (cloud.empty()) return sums;
  checkSize(cloud);
  for (std::size_t t = 0; t < cloud.voxels().table.size(); ++t) addBrick(cloud, t, sums);
  return sums;
}

std::vector<MatterSums> matterSums(const Cloud& cloud, const Cloud& before,
                                   std::vector<MatterSums> known) {
  std::vector<MatterSums> more(known.size()), less(known.size());
  for (std::size_t t = 0; t < cloud.voxels().table.size(); ++t) {
    if (sameCoverage(cloud.voxels(), before.voxels(), t) &&
        sameMaterial(cloud.voxels(), before.voxels(), t))
      continue;
    addBrick(cloud, t, more);
    addBrick(before, t, less);
  }
  for (std::size_t m = 0; m < known.size(); ++m) {
    known[m] += more[m];
    known[m] -= less[m];
  }
  return known;
}

namespace {

void validate(const std::vector<double>& densities, std::size_t materials) {
  if (densities.size() != 1 && densities.size() != materials)
    throw std::invalid_argument("massPropertiesOf: " + std::to_string(densities.size()) +
                                " densities for " + std::to_string(materials) +
                                " materials; give one for each, or one for all");
  for (const double d : densities)
    if (!(d > 0) || !std::isfinite(d))
      throw std::invalid_argument(
          "massPropertiesOf: a density must be positive and finite [kg/m^3]");
}

}  // namespace

MassProperties massPropertiesOf(const std::vector<MatterSums>& sums, const Cloud& grid,
                                const std::vector<double>& densities) {
  validate(densities, sums.size());
  double volume = 0, mass = 0;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t m = 0; m < sums.size(); ++m) {
    const double density = densities[densities.size() == 1 ? 0 : m];
    const auto f = [&](int i) { return double(sums[m].first[i]); };
    const auto s = [&](int i) { return double(sums[m].second[i]); };
    Eigen::Matrix3d all;
    all << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
    volume += double(sums[m].mass);
    mass += density * double(sums[m].mass);
    first += density * Vec3(f(0), f(1), f(2));
    second += density * all;
  }
  MassProperties matter;
  if (mass <= 0) return matter;
  const double h = grid.voxelSize(), unit = h * h * h / 255;
  const Vec3 mean = first / mass;
  // Half voxels to meters; a voxel's own second moment is a twelfth of its edge squared.
  const Eigen::Matrix3d about =
      unit * h * h *
      ((second - mass * mean * mean.transpose()) / 4 + mass / 12 * Eigen::Matrix3d::Identity());
  matter.volume = unit * volume;
  matter.mass = unit * mass;
  matter.centerOfMass = grid.origin() + 0.5 * h * (mean + grid.size().cast<double>());
  matter.inertia = about.trace() * Eigen::Matrix3d::Identity() - about;
  return matter;
}

MassProperties massPropertiesOf(const Cloud& cloud, const std::vector<double>& densities) {
  if (densities.size() != 1) return massPropertiesOf(matterSums(cloud), cloud, densities);
  validate(densities, 1);
  MassProperties matter = cloud.massProperties();
  matter.mass *= densities[0];
  matter.inertia *= densities[0];
  return matter;
}

}  // namespace cloudcontact
