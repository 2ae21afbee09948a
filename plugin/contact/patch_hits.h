// Looks places up among the hits of a patch (kernels/contact/wet_hits.h).
#pragma once

#include <cloudcontact/contact/work_counts.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "contact/binner.h"
#include "kernels/contact/patch_force.h"

namespace cloudcontact {

// The hits of a pair, and the bins and patches of their last Binner::patches().
struct PairHits {
  const Binner* binner;
  const HitColumns* hits;
  double cell;  // edge of a bin's cell [m]
};

// The hits of a patch, side by side: a patch is looked up 5 to 30 times.
class PatchHits {
 public:
  void take(const PairHits& pair, std::size_t patch);
  // The nearest of them; `best` says to what.
  CcNearestHit nearest(CcNearestHit best) const;
  // Moves the four places of a plan to where the patch is wet, and finds what is nearest to each.
  void place(const CcPatchForce& force, const CcFlat& flat, CcPlan& plan,
             CcNearestHit* found) const;
  // The largest of the numbers of its hits, all positive.
  float largestOf(const std::vector<float>& numbers) const;
  // Reserves what `other` has reserved.
  void reserveLike(const PatchHits& other);
  // What the lookups since the last call took.
  WorkCounts takeWork() { return std::exchange(work_, {}); }

 private:
  // Around hits [m]; `width`: of the largest sample.
  struct Ball {
    CcVec center;
    double radius, width;
  };
  struct Bin {
    CcVec middle;  // of its cell
    Ball ball;
    std::uint32_t begin, end;
  };
  Ball ballAround(std::uint32_t begin, std::uint32_t end) const;
  bool mayBeNearer(const Bin& bin, const CcNearestHit& best) const;
  void tryBin(const Bin& bin, CcNearestHit& best) const;
  void tryHit(std::uint32_t hit, CcNearestHit& best) const;

  const HitColumns* hits_ = nullptr;
  double cell_ = 0;
  std::vector<Bin> bins_;
  std::vector<float> x_, y_, z_;      // [m]
  std::vector<float> width_;          // root of the sample's area [m]
  std::vector<std::uint32_t> index_;  // in the pair's hits
  mutable WorkCounts work_;
  mutable std::vector<float> least_;  // of a bin's hits, in a lookup [m^2]
  mutable std::vector<float> leastOfBlock_;
};

}  // namespace cloudcontact
