// A surface's samples in levels from coarse to fine. Each of a coarse level's cells knows the finer
// samples within it: a search looks at few coarse samples first, then only where these were near.
#pragma once

#include "sample_columns.h"

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

// Sorts pieces of surface, in voxels, into bricks and cells, and makes the coarse levels. The order
// depends on the pieces alone.
SampleSet sortSamples(std::vector<SurfaceSample> pieces);

}  // namespace cloudcontact
