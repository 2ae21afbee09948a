// Patches become contacts: one team for each pair, one work-item for each patch. The first
// work-item also computes what belongs to the pair as a whole.

// Lists the patches of a pair that count, and computes the pair's sums. Returns their number.
uint ccPairOf(__global const CcTerms* terms, __global const CcSums* patches,
              __global const CcPatchForce* forces, uint count, __global uint* kept,
              int level, __local CcWhole* whole) {
  const double voxel = terms->voxel;
  const int foundation = terms->foundation;
  double all = 0.0;
  for (uint k = 0; k < count; ++k) all += forces[k].size;
  CcPairSums sums = ccNoPatches();
  uint counted = 0;
  for (uint k = 0; k < count; ++k) {
    if (!ccCounts(&patches[k], forces[k].size, all, voxel, foundation)) continue;
    ccAddPatch(&sums, &patches[k], forces[k].size, forces[k].trustA, forces[k].fall,
               forces[k].lean, 0);
    kept[counted++] = k;
  }
  const CcPairDepth found = ccDepthOfPair(&sums, 0, voxel);
  CcWhole w = {sums.size, sums.area, 0.0, foundation ? 0.0 : found.depth,
               ccDepthError(&sums, &found, 0.0, level, 0, voxel)};
  for (uint i = 0; i < counted; ++i)
    w.shares += ccShareOf(patches[kept[i]].area, forces[kept[i]].size, &w);
  *whole = w;
  return counted;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccContacts(
    __global const CcPair* pairs, __global CcResults* results, __global const CcSums* patches,
    __global CcPatchForce* forces, __global uint* kept, __global CcContactPatch* contacts,
    uint contactsAt) {
  __local CcWhole shared;
  __local uint count, place;
  __global CcAnswer* answers = results->answers;
  const uint lid = get_local_id(0), p = get_group_id(0);
  const uint all = answers[p].failed ? 0u : answers[p].patches, first = answers[p].firstPatch;
  if (all == 0u) return;
  __global const CcTerms* terms = &pairs[p].terms;
  for (uint k = lid; k < all; k += CC_TEAM) {
    CcFlat flat;
    forces[first + k] = ccForceOf(&patches[first + k], terms->foundation, 0, 0, &flat);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  if (lid == 0) {
    count = ccPairOf(terms, patches + first, forces + first, all, kept + first,
                     answers[p].level, &shared);
    place = atomic_add(&results->counters[CC_CONTACTS], count);
    answers[p].firstPatch = place;
    answers[p].patches = count;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  const CcWhole whole = shared;
  for (uint i = lid; i < count; i += CC_TEAM) {
    const uint k = first + kept[first + i];
    const CcPatchForce force = forces[k];
    const CcFlat flat = ccFlatten(&patches[k], force.normal);
    ccContactOf(&patches[k], &force, &flat, terms, &whole, &contacts[contactsAt + place + i]);
  }
}
