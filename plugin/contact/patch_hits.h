// Looks places up among the hits of a patch (kernels/contact/wet_hits.h).
#pragma once

#include "contact/binner.h"
#include "kernels/contact/patch_force.h"

namespace cloudcontact {

// The hits of a pair, and the bins and patches of their last Binner::patches().
struct PairHits {
  const Binner* binner;
  const HitColumns* hits;
  double cell;  // edge of a bin's cell [m]
};

// The hits of a patch.
struct PatchHits {
  PairHits pair;
  std::size_t patch;

  // The nearest of them; `best` says to what.
  CcNearestHit nearest(CcNearestHit best) const;
  // Moves the four places of a plan to where the patch is wet, and finds what is nearest to each.
  void place(const CcPatchForce& force, const CcFlat& flat, CcPlan& plan,
             CcNearestHit* found) const;
};

}  // namespace cloudcontact
