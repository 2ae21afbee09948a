// Lengths, runs and numbers of samples.
#include "field/sample_check.h"

#include <cmath>

namespace cloudcontact {

namespace {

// [voxels, voxels^2] Beyond all that a sample can be, and far from where floats overflow.
constexpr float kMostValue = 1e6f;
constexpr float kBesideGrid = 8;   // [voxels] that a sample may lie beside the grid
constexpr float kLongest = 1.01f;  // of a normal

bool within(const LargeVector<float>& column, float low, float high) {
  bool all = true;
  for (const float v : column) all = all & (v >= low) & (v <= high);  // NaN is not
  return all;
}

bool sameLengths(const SampleLevel& level, std::size_t coarse) {
  const SampleColumns& s = level.samples;
  for (const auto* column : {&s.y, &s.z, &s.nx, &s.ny, &s.nz, &s.area, &s.width})
    if (column->size() != s.size()) return false;
  for (const LargeVector<float>& column : level.clusters.spread)
    if (column.size() != coarse) return false;
  return level.clusters.size() == coarse && level.cellOf.size() == coarse;
}

bool soundNumbers(const SampleLevel& level, const Eigen::Vector3i& size) {
  const SampleColumns& s = level.samples;
  const LargeVector<float>* const places[] = {&s.x, &s.y, &s.z};
  for (int k = 0; k < 3; ++k)
    if (!within(*places[k], -kBesideGrid, static_cast<float>(size[k]) + kBesideGrid)) return false;
  for (const auto* column : {&s.nx, &s.ny, &s.nz})
    if (!within(*column, -kLongest, kLongest)) return false;
  for (const auto* column : {&s.area, &s.width, &level.clusters.rise})
    if (!within(*column, 0, kMostValue)) return false;
  for (const LargeVector<float>& column : level.clusters.spread)
    if (!within(column, -kMostValue, kMostValue)) return false;
  return true;
}

// One run behind the other, through all of `count` samples.
bool areParts(const LargeVector<SampleRun>& runs, std::size_t count) {
  std::size_t at = 0;
  for (const SampleRun& run : runs) {
    if (run.first != at) return false;
    at += run.count;
  }
  return at == count;
}

bool areCells(const SampleLevel& level) {
  std::size_t last = 0;
  for (const std::uint32_t cell : level.cellOf) {
    if (cell < last || cell >= level.finer.size()) return false;
    last = cell;
  }
  return true;
}

}  // namespace

bool consistent(const SampleSet& samples, const Eigen::Vector3i& size) {
  for (int number = 0; number < kLevels; ++number) {
    const SampleLevel& level = samples.levels[number];
    if (!sameLengths(level, number > 0 ? level.samples.size() : 0) || !soundNumbers(level, size))
      return false;
    if (number == 0
            ? !level.finer.empty()
            : !areCells(level) || !areParts(level.finer, samples.levels[number - 1].samples.size()))
      return false;
  }
  const SampleBricks& b = samples.bricks;
  for (const auto* column : {&b.x, &b.y, &b.z, &b.radius})
    if (column->size() != b.runs.size() || !within(*column, -kMostValue, kMostValue)) return false;
  return samples.levels[0].samples.size() > 0 &&
         areParts(b.runs, samples.levels[kLevels - 1].samples.size());
}

}  // namespace cloudcontact
