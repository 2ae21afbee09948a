// Bins whose cells are too far away are left out, which leaves a few hits of each patch.
#include "contact/patch_hits.h"

namespace cloudcontact {

CcNearestHit PatchHits::nearest(CcNearestHit best) const {
  const HitColumns::Columns<const float> c = pair.hits->columns();
  for (const std::uint32_t bin : pair.binner->binsOf(patch)) {
    const CcSums& sums = pair.binner->sums(bin);
    if (!ccMayBeNearer(&best, ccVecAt(sums.origin), pair.cell)) continue;
    for (const std::uint32_t i : pair.binner->hitsOf(bin)) {
      const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                  other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
      ccTryHit(&best, pair.cell, at, own, other, c.facing[i], c.area[i], pair.hits->side(i));
    }
  }
  return best;
}

void PatchHits::place(const CcPatchForce& force, const CcFlat& flat, CcPlan& plan,
                      CcNearestHit* found) const {
  for (int round = 0; round <= CC_WET_ROUNDS; ++round) {
    for (int i = 0; i < 4; ++i) {
      found[i] = nearest(ccNoHit(ccPlannedPlace(&plan, &force, &flat, i),
                                 ccPlannedNormal(&plan, &flat, i), CC_COVERS, CC_ABOVE));
      if (!ccIsBeside(&found[i], plan.voxel)) continue;
      const CcNearestHit mirrored = nearest(ccMirrored(&found[i]));
      found[i].moves = ccMoves(&mirrored, plan.voxel);
    }
    if (round == CC_WET_ROUNDS || !ccMoveToWet(&plan, &flat, found)) return;
  }
}

}  // namespace cloudcontact
