// SampleSet: a surface's samples in levels from coarse to fine. Each cell of a coarse level refers
// to the finer samples within it: a search visits few coarse samples first, then only the cells
// where these are near.
#pragma once

#include <cloudcontact/field/surface_sample.h>

#include "base/large_memory.h"
#include "kernels/contact/search.h"
#include "voxels/voxel_set.h"

#include <cstdint>
#include <vector>

namespace cloudcontact {

constexpr int kLevels = 3;  // level 0: every piece; level 1: cells of 2 voxels; level 2: of 4

// One column per quantity, so that many samples are looked up side by side.
struct SampleColumns {
  LargeVector<float> x, y, z;     // [voxels], grid's frame
  LargeVector<float> nx, ny, nz;  // outward unit vector
  LargeVector<float> area, width;

  std::size_t size() const { return x.size(); }
  std::size_t bytes() const { return 8 * sizeof(float) * size(); }
  SurfaceSample operator[](std::size_t k) const {
    return {{x[k], y[k], z[k]}, {nx[k], ny[k], nz[k]}, area[k], width[k]};
  }
  void push_back(const SurfaceSample& s) {  // inline for the contact search
    x.push_back(s.position[0]), y.push_back(s.position[1]), z.push_back(s.position[2]);
    nx.push_back(s.normal[0]), ny.push_back(s.normal[1]), nz.push_back(s.normal[2]);
    area.push_back(s.area), width.push_back(s.width);
  }
  void append(const SampleColumns& from, std::size_t first, std::size_t count);
  void reserve(std::size_t count);
  void fit(const SampleColumns& other);  // reserves the other's capacity
  void clear();
};

// What the samples of a coarse level stand for (CcCluster).
struct ClusterColumns {
  LargeVector<float> rise, spread[6];

  std::size_t size() const { return rise.size(); }
  CcCluster operator[](std::size_t k) const {
    return {rise[k],
            {spread[0][k], spread[1][k], spread[2][k], spread[3][k], spread[4][k], spread[5][k]}};
  }
  void push_back(const CcCluster& cluster);
  void append(const ClusterColumns& from, std::size_t first, std::size_t count);
  void reserve(std::size_t count);
  void clear();
};

struct SampleRun {
  std::uint32_t first = 0, count = 0;
};

// Pieces of a cell that face the same way are one sample. Cells are 2 and 4 voxels wide; on level
// 1, each sample has a cell of its own.
struct SampleLevel {
  SampleColumns samples;
  // Empty on level 0:
  ClusterColumns clusters;            // of each sample
  LargeVector<std::uint32_t> cellOf;  // its cell
  LargeVector<SampleRun> finer;       // a cell's samples on the next finer level
};

// Bricks of 8x8x8 voxels. A sphere holds all pieces of a brick (grid's frame, voxels). The runs are
// of the coarsest level.
struct SampleBricks {
  LargeVector<float> x, y, z, radius;
  LargeVector<SampleRun> runs;
};

struct SampleSet {
  SampleLevel levels[kLevels];
  SampleBricks bricks;

  std::size_t bytes() const;
};

// The voxel that a piece of surface belongs to, and its rank in the order in which a full build
// cuts the surface.
struct SampleOrigin {
  std::uint64_t order = 0;
  std::int32_t brick = 0;
  std::int16_t cell = 0;

  // The n-th piece of a voxel.
  static SampleOrigin ofVoxel(std::int32_t brick, std::int16_t cell, int n) {
    return {static_cast<std::uint64_t>(brick) << 24 | static_cast<std::uint64_t>(cell) << 15 |
                static_cast<std::uint64_t>(n),
            brick, cell};
  }
  // The n-th piece found from a neighboring voxel. These rank after all of the first kind.
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

// Sorts pieces of surface into bricks and cells and creates the coarse levels. The order depends on
// the pieces alone. Returns the origins of level 0 in `origins`.
SampleSet sortSamples(std::vector<CutSample> pieces, std::vector<SampleOrigin>& origins);

// The set that sortSamples() creates from `before` without the samples of voxels in `removed`, and
// with `fresh` ones. Unaffected bricks are copied.
SampleSet renewSamples(const SampleSet& before, const std::vector<SampleOrigin>& originsBefore,
                       const VoxelSet& removed, std::vector<CutSample> fresh,
                       std::vector<SampleOrigin>& origins);

}  // namespace cloudcontact
