// A surface's samples in levels from coarse to fine, each level's in cells that know the finer
// cells within them: a search looks at few coarse samples first, then only where these were near.
#pragma once

#include <cloudcontact/surface_field.h>

#include <vector>

namespace cloudcontact {

constexpr int kLevels =
    3;  // level 0 holds every piece; level 1 has cells of 2 voxels, level 2 of 4

// A run of samples of one level, and the finer level's cells within it (level 0 has none).
struct SampleCell {
  std::uint32_t first, count;
  std::uint32_t child, children;
};

// Of a cell's pieces those that look the same way are one sample.
struct SampleLevel {
  std::vector<SurfaceSample> samples;
  std::vector<SampleCell> cells;
};

// 8x8x8 voxels; `radius` about `center` holds all pieces (grid frame, voxels). Cells of the
// coarsest level.
struct SampleBrick {
  float center[3];
  float radius;
  std::uint32_t first, count;
};

struct SampleSet {
  SampleLevel levels[kLevels];
  std::vector<SampleBrick> bricks;

  std::size_t bytes() const;
};

// Sorts pieces of surface, in voxels, into bricks and cells, and makes the coarse levels. The order
// depends on the pieces alone.
SampleSet sortSamples(std::vector<SurfaceSample> pieces);

}  // namespace cloudcontact
