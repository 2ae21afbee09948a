// Chooses the settings of clouds for a tolerance: trials at finer and finer voxels until the error
// that the contacts state is within it (docs/engine.md, "Settings for a tolerance").
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace cloudcontact::program {

struct TuneSetting {
  double voxel = 0;         // [m]
  std::size_t samples = 0;  // ContactSettings::samples
};

// One setting at work in several places: a pair in its poses, or all pairs of a scene at several
// instants.
struct Trial {
  static constexpr double kApart = -std::numeric_limits<double>::infinity();

  TuneSetting setting;
  // For each place: depth of the contact, kApart without one, and the error that it states [m].
  std::vector<double> depths, stated;
  double lookups = 0;       // samples and hits, as many lookups of samples
  double microseconds = 0;  // of a query; of a scene's step, all its pairs
  std::size_t bytes = 0;    // of all clouds and fields
  int level = 0;            // ContactResult::level, the finest of all places

  // What 95 % of the places state at most. Infinite where nothing touches.
  double predicted() const;
  // What 95 % of the places are off by, with `truth` as the truth. Places where neither touches do
  // not count.
  double measured(const Trial& truth) const;
};

struct TuneLimits {
  double coarsest = 0;    // [m] voxel of the first trial
  bool fixed = false;     // a saved cloud: no other voxel
  std::size_t bytes = 0;  // that the clouds and fields of a trial may take
};

struct Tuned {
  Trial chosen;
  std::optional<Trial> finer, coarser;  // one step
  // Of half the voxel and all samples; empty where that does not fit in memory.
  std::optional<Trial> reference;
};

// A step is a factor of root 2 in the voxel. Throws BadInput naming --tolerance where the clouds
// would not fit in memory, or a fixed voxel is too coarse, with the tolerance that can be met; and
// where nothing touches.
Tuned tune(double tolerance, const TuneLimits& limits,
           const std::function<Trial(const TuneSetting&)>& attempt);

// Memory that is free now [bytes].
std::size_t freeMemory();

}  // namespace cloudcontact::program
