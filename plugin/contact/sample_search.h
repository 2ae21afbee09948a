// One direction of a search, the samples of one body looked up in the other: what it reads, and
// what it collects besides hits.
#pragma once

#include <cloudcontact/base/task_runner.h>
#include <cloudcontact/contact/work_counts.h>

#include "contact/hit_columns.h"
#include "field/owned_voxels.h"
#include "kernels/contact/search.h"

#include <algorithm>
#include <span>
#include <vector>

namespace cloudcontact::search {

using V3 = Eigen::Vector3f;

constexpr std::size_t kAllSamples = ~std::size_t{0};

// The number of hits that makes a level fine enough, if the coarsest needs `enough`. Finer levels
// need a third as many: with a fifth the force on cylinders of 16 voxels pressed by 0.3 is off by
// 3.7 %, with a third by less than 3.
constexpr std::size_t neededOf(int level, std::size_t enough) {
  constexpr std::size_t kFinerNeeds = 3;
  return level == kLevels - 1 ? enough : enough / kFinerNeeds;
}
// [own voxels] Samples this far outside the other body may own voxels in it.
constexpr float kOwnedAside = 2;

// Where a part of a divided sample is looked up: the record of its voxel, and its place from that
// voxel's center.
struct Part {
  CcVoxel record;
  float x, y, z;
};

// What a search found at samples of the coarsest level. Where nothing touches, the search for near
// misses begins with these and need not look them up again.
struct CoarseFound {
  bool known = false;
  std::vector<std::uint32_t> bricks;   // whose samples were looked up, ascending
  std::vector<float> estimate, depth;  // by sample [m]: estimateNearest()

  void begin(std::size_t samples);
  void reserveLike(const CoarseFound& other);
};

// A sample whose own voxels may lie in the other body.
struct TouchedSample {
  std::uint32_t sample;
  float depth;         // [m] in the other body, negative outside
  V3 other;            // normal there, in the other body's frame; zero below its band
  bool plain = false;  // the other's surface there is one plane
  std::uint32_t hit = kNoHit;

  static constexpr std::uint32_t kNoHit = ~0u;  // it is no hit itself
};

// Samples near the other body, from level to level: the next finer level searches only their cells.
struct Candidates {
  bool all = true;                     // the coarsest level: every brick
  std::vector<SampleRun> runs;         // else the samples of this level, from the level before
  std::vector<SampleRun> finer;        // of the next level, until this one is left
  std::vector<std::uint32_t> next;     // found on this level
  std::vector<std::uint32_t> bricks;   // that may touch
  WorkCounts work;                     // so far
  std::vector<std::uint32_t> deep;     // samples below the band
  SampleColumns parts;                 // of samples that lie over an edge
  std::vector<Part> places;            // of the parts
  std::vector<TouchedSample> touched;  // of this level, where Direction::owned asks for them
  CoarseFound* coarse = nullptr;       // to be filled on the coarsest level; null: not wanted

  // Reserves what `other` has reserved.
  void reserveLike(const Candidates& other);
};

// One task's part of a large level, and what it found.
struct Share {
  std::size_t last = 0;  // end of its runs
  Candidates candidates;
  HitColumns hits;
};
struct Shares {
  const TaskRunner* runner = nullptr;  // null: no sharing
  std::vector<SampleRun> runs;
  std::vector<Share> all;

  void reserveLike(const Shares& other);
};

// The samples of one body on their way into the other.
struct Direction : CcWay {
  const FieldData& body;
  const SampleSet& samples;
  int level;
  Side side;
  float voxel;                         // of the samples' body [m]
  std::size_t needed = kAllSamples;    // hits of both bodies that make the level fine enough
  const OwnedVoxels* owned = nullptr;  // of the samples, where the touched ones are wanted

  CcLimits limits() const { return ccLimitsOf(level, voxel); }
};

inline V3 applied(const CcMap& map, const V3& x) {
  V3 out;
  ccApply(&map, x.data(), out.data());
  return out;
}
inline V3 turned(const float* turn, const V3& x) {
  V3 out;
  ccTurn(turn, x.data(), out.data());
  return out;
}

// A sample at `depth` [m] in the other body, negative outside, as a hit. `other`: the other body's
// normal there, in that body's frame.
Hit hitOf(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep);

}  // namespace cloudcontact::search
