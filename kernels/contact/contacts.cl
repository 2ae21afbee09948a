// Patches become contacts. A team for each pair finds the patches' forces, lists the patches that
// count, and sums what belongs to the pair as a whole. Then the points of all pairs' patches are
// placed as PatchHits::place() does: teams look places up (nearest_hits.cl), and in between a
// work-item for each patch plans and moves its places. Last, a team for each pair shares the depths
// out.

// Sums a pair's patches and lists those that count in `kept`. Returns their number.
uint ccPairSumsOf(__global const CcTerms* terms, __global const CcSums* patches,
                  __global const CcPatchForce* forces, uint count, __local ushort* kept,
                  CcPairSums* sums) {
  double all = 0.0;
  for (uint k = 0; k < count; ++k) all += forces[k].size;
  *sums = ccNoPatches();
  uint counted = 0;
  for (uint k = 0; k < count; ++k) {
    if (!ccCounts(&patches[k], forces[k].size, all, terms->voxel, terms->foundation)) continue;
    ccAddPatch(sums, &patches[k], forces[k].size, forces[k].trustA, forces[k].fall,
               forces[k].lean, terms->oneSided);
    kept[counted++] = (ushort)k;
  }
  return counted;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccForces(
    __global const CcPair* pairs, __global CcResults* results, __global const CcSums* patches,
    __global CcPatchForce* forces, __global CcWhole* wholes, __global CcListed* listed,
    __global const CcField* fields, __global const CcVoxel* records,
    __global const int* ints, __global const CcFound* found, __global const float4* hits,
    __global const CcShape* shapes, uint firstShape) {
  __local ushort kept[CC_MOST_BINS];
  __local uint count, place;
  __local int sharp;
  __local CcSharpRoom room;
  __global CcAnswer* answers = results->answers;
  const uint lid = get_local_id(0), p = get_group_id(0);
  const uint all = answers[p].failed ? 0u : answers[p].patches, first = answers[p].firstPatch;
  if (all == 0u) return;
  __global const CcTerms* terms = &pairs[p].terms;
  const CcSharpData data = {fields, records, ints};
  const int level = answers[p].level;
  for (uint k = lid; k < all; k += CC_TEAM) {
    CcFlat flat;
    forces[first + k] = ccForceOf(&patches[first + k], terms->foundation, terms->oneSided,
                                  terms->sampled, &flat);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  CcPairSums sums = ccNoPatches();
  CcPairDepth depth = {0.0, 0.0, 0.0};
  double edged = 0.0, edge = 0.0;
  if (lid == 0) {
    count = ccPairSumsOf(terms, patches + first, forces + first, all, kept, &sums);
    depth = ccDepthOfPair(&sums, terms->oneSided, terms->voxel);
    const int shape = terms->oneSided && !terms->foundation;
    edged = sums.size > 0.0 ? shape ? ccEdged(&sums, &depth) : ccEdgedOnFace(&sums, &depth) : 0.0;
    sharp = edged > 0.0 && !terms->foundation && !shape;
    // The CPU walks along a shape's edges.
    if (edged > 0.0 && shape && shapes[p - firstShape].solid.edged) {
      answers[p].failed = CC_SHAPE_EDGE;
      count = 0;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint side = 0; side < (terms->oneSided ? 0u : 2u); ++side)
    edge = ccMax64(edge, ccEdgeOf(&pairs[p].ways[side], &found[(2 * p + side) * CC_LEVELS],
                                  sharp ? level : CC_LEVELS, &data, hits, &room));
  if (lid == 0) {
    const int gives = !terms->oneSided && edge > depth.depth;
    if (gives) ccTakeEdge(&depth, edged, edge);
    CcWhole whole = ccWholeOf(
        &sums, sums.size, depth.depth,
        ccDepthError(&sums, &depth, gives ? edged : 0.0, level, terms->oneSided, terms->voxel),
        terms);
    for (uint i = 0; i < count; ++i)
      whole.shares +=
          ccShareOf(patches[first + kept[i]].area, forces[first + kept[i]].size, &whole);
    wholes[p] = whole;
    place = atomic_add(&results->counters[CC_CONTACTS], count);
    answers[p].firstPatch = place;
    answers[p].patches = count;
    const double cell = pairs[p].cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0);
    uint begin = pairs[p].ways[0].hits;
    for (uint i = 0; i < count; ++i) {
      const uint patch = first + kept[i], all = (uint)patches[patch].hits;
      const CcListed one = {p, patch, begin, all, cell, terms->voxel};
      listed[place + i] = one;
      begin += all;
    }
  }
}

// Asks what is nearest to a plan's places.
void ccAskPlaces(const CcPlan* plan, const CcPatchForce* force, const CcFlat* flat,
                 __global CcPlaced* to) {
  for (int i = 0; i < 4; ++i)
    to->found[i] = ccNoHit(ccPlannedPlace(plan, force, flat, i), ccPlannedNormal(plan, flat, i),
                           CC_COVERS, CC_ABOVE);
}

// Plans where the points of contacts stand.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccPlans(
    __global const CcPair* pairs, __global const CcResults* results,
    __global const CcSums* patches, __global const CcPatchForce* forces,
    __global const CcListed* listed, __global CcPlaced* placed) {
  const uint all = results->counters[CC_CONTACTS];
  for (uint k = get_global_id(0); k < all; k += get_global_size(0)) {
    const CcListed from = listed[k];
    const CcPatchForce force = forces[from.patch];
    const CcFlat flat = ccFlatten(&patches[from.patch], force.normal);
    __global const CcTerms* terms = &pairs[from.pair].terms;
    const CcPlan plan = ccPlanOf(&patches[from.patch], &force, &flat, ccLeverOf(terms, &force),
                                 terms->voxel);
    placed[k].plan = plan;
    placed[k].moved = 1;
    ccAskPlaces(&plan, &force, &flat, &placed[k]);
  }
}

// Moves places that are dry, and asks again for those that moved.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccMovePlaces(
    __global const CcResults* results, __global const CcSums* patches,
    __global const CcPatchForce* forces, __global const CcListed* listed,
    __global CcPlaced* placed) {
  const uint all = results->counters[CC_CONTACTS];
  for (uint k = get_global_id(0); k < all; k += get_global_size(0)) {
    if (!placed[k].moved) continue;
    const CcListed from = listed[k];
    const CcPatchForce force = forces[from.patch];
    const CcFlat flat = ccFlatten(&patches[from.patch], force.normal);
    CcPlan plan = placed[k].plan;
    const int moved = ccMoveToWet(&plan, &flat, placed[k].found);
    placed[k].moved = moved;
    if (!moved) continue;
    placed[k].plan = plan;
    ccAskPlaces(&plan, &force, &flat, &placed[k]);
  }
}

// Makes contacts of patches with placed points.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccContacts(
    __global const CcPair* pairs, __global const CcResults* results,
    __global const CcSums* patches, __global const CcPatchForce* forces,
    __global const CcWhole* wholes, __global const CcListed* listed,
    __global const CcPlaced* placed, __global CcContactPatch* contacts, uint contactsAt) {
  const uint all = results->counters[CC_CONTACTS];
  for (uint k = get_global_id(0); k < all; k += get_global_size(0)) {
    const CcListed from = listed[k];
    const CcPatchForce force = forces[from.patch];
    const CcFlat flat = ccFlatten(&patches[from.patch], force.normal);
    const CcPlan plan = placed[k].plan;
    const CcWhole whole = wholes[from.pair];
    ccContactOf(&patches[from.patch], &force, &flat, &plan, placed[k].found,
                &pairs[from.pair].terms, &whole, &contacts[contactsAt + k]);
  }
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccLevels(
    __global const CcPair* pairs, __global const CcResults* results,
    __global const CcWhole* wholes, __global CcContactPatch* contacts, uint contactsAt) {
  __local CcLeast room[CC_TEAM];
  __global const CcAnswer* answer = &results->answers[get_group_id(0)];
  const uint lid = get_local_id(0), count = answer->failed ? 0u : answer->patches;
  __global CcContactPatch* own = contacts + contactsAt + answer->firstPatch;
  __global const CcTerms* terms = &pairs[get_group_id(0)].terms;
  const CcWhole whole = wholes[get_group_id(0)];
  CcLeast level = {0.0, lid};
  for (uint i = lid; i < count; i += CC_TEAM)
    level.square = ccMin64(level.square, -ccLevelling(&own[i], terms, &whole));
  // Without an early return, after which PoCL would share the depths out twice.
  const double most = -ccLeastOf(room, CC_TEAM, level).square;
  for (uint i = lid; i < count; i += CC_TEAM) ccLevelDepths(&own[i], terms, &whole, most);
}
