// A surface's samples in levels from coarse to fine. Each of a coarse level's cells knows the finer
// samples within it: a search looks at few coarse samples first, then only where these were near.
#pragma once

#include "field/sample_columns.h"
#include "voxels/voxel_set.h"

#include <vector>

namespace cloudcontact {

constexpr int kLevels =
    3;  // level 0 holds every piece; level 1 has cells of 2 voxels, level 2 of 4

// A run of samples.
struct SampleRun {
  std::uint32_t first = 0, count = 0;
};

// Of a cell's pieces those that look the same way are one sample.
struct SampleLevel {
  SampleColumns samples;
  std::vector<std::uint32_t> cellOf;  // each sample's cell; level 0 has none
  std::vector<SampleRun> finer;       // a cell's samples of the next finer level
};

// 8x8x8 voxels; `radius` about the centre holds all pieces (grid frame, voxels). Runs of the
// coarsest level.
struct SampleBricks {
  std::vector<float> x, y, z, radius;
  std::vector<SampleRun> runs;
};

struct SampleSet {
  SampleLevel levels[kLevels];
  SampleBricks bricks;

  std::size_t bytes() const;
};

// Where a piece of surface was cut: the voxel that it belongs to, and its place among all pieces in
// the order in which a whole surface is cut.
struct SampleOrigin {
  std::uint64_t order = 0;
  std::int32_t brick = 0;
  std::int16_t cell = 0;

  // The n-th of a voxel.
  static SampleOrigin ofVoxel(std::int32_t brick, std::int16_t cell, int n) {
    return {static_cast<std::uint64_t>(brick) << 24 | static_cast<std::uint64_t>(cell) << 15 |
                static_cast<std::uint64_t>(n),
            brick, cell};
  }
  // The n-th that is found from a voxel beside it; these come after all of the first kind.
  static SampleOrigin ofSliver(std::int32_t brick, std::int16_t cell, int n) {
    SampleOrigin origin = ofVoxel(brick, cell, n);
    origin.order |= std::uint64_t{1} << 63;
    return origin;
  }
};

struct CutSample {
  SurfaceSample sample;
  SampleOrigin origin;
};

// Sorts pieces of surface, in voxels, into bricks and cells, and makes the coarse levels. The order
// depends on the pieces alone. `origins` are those of level 0's samples.
SampleSet sortSamples(std::vector<CutSample> pieces, std::vector<SampleOrigin>& origins);

// The set that sortSamples() makes of `before` without the samples of the voxels in `gone`, and
// with `fresh` ones. Bricks of which nothing goes and to which nothing comes are copied.
SampleSet renewSamples(const SampleSet& before, const std::vector<SampleOrigin>& originsBefore,
                       const VoxelSet& gone, std::vector<CutSample> fresh,
                       std::vector<SampleOrigin>& origins);

}  // namespace cloudcontact
