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

// The hits of a pair, bin by bin.
typedef struct {
  __global const CcSums* sums;
  __global const CcBin* bins;
  __global const float4* hits[2];  // each body's
  size_t room[2];
  __global const uint* list;
  double cell;
} CcPairHits;

CcPairHits ccPairHitsOf(__global const CcPair* pair, int level, __global const CcSums* sums,
                        __global const CcBin* bins, __global const float4* hits,
                        __global const uint* order) {
  CcPairHits p;
  p.sums = sums;
  p.bins = bins;
  for (int s = 0; s < 2; ++s) {
    p.hits[s] = hits + 4 * (size_t)pair->ways[s].hits;
    p.room[s] = pair->ways[s].room;
  }
  p.list = order + pair->ways[0].hits;
  p.cell = pair->cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0);
  return p;
}

void ccTryBin(const CcPairHits* p, uint b, CcNearestHit* best) {
  const CcBin bin = p->bins[b];
  for (uint n = bin.begin; n < bin.end; ++n) {
    const int side = n < bin.middle ? 0 : 1;
    __global const float4* hit = p->hits[side] + p->list[n];
    const float4 x = hit[0], q = hit[p->room[side]], r = hit[2 * p->room[side]];
    const float at[3] = {x.x, x.y, x.z}, own[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
    ccTryHit(best, p->cell, at, own, other, q.w, x.w, r.w, side);
  }
}

// PatchHits::nearest() (plugin/contact/patch_hits.cpp) among the hits of a patch.
CcNearestHit ccNearestOf(const CcPairHits* p, __global const uint* queue, uint count,
                         CcNearestHit best) {
  uint first = 0;
  double least = INFINITY;
  for (uint k = 0; k < count; ++k) {
    const double square = ccSquareTo(&best, ccVecAt(p->sums[queue[k]].origin));
    if (square < least) {
      least = square;
      first = k;
    }
  }
  if (count > 0) ccTryBin(p, queue[first], &best);
  for (uint k = 0; k < count; ++k)
    if (k != first && ccMayBeNearer(&best, ccVecAt(p->sums[queue[k]].origin), p->cell))
      ccTryBin(p, queue[k], &best);
  return best;
}

#define CC_PLACED_AT_ONCE (CC_TEAM / 4)  // patches whose points a team places

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccContacts(
    __global const CcPair* pairs, __global CcResults* results, __global const CcSums* patches,
    __global CcPatchForce* forces, __global uint* kept, __global CcContactPatch* contacts,
    uint contactsAt, __global const CcSums* sums, __global const uint* queues,
    __global const CcGrown* grown, __global const CcBin* bins, __global const float4* hits,
    __global const uint* order) {
  __local CcWhole shared;
  __local double level;
  __local uint count, place;
  __local CcNearestHit nearest[CC_TEAM];
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
  __global CcContactPatch* own = contacts + contactsAt + place;
  const CcPairHits pairHits = ccPairHitsOf(&pairs[p], answers[p].level, sums, bins, hits, order);
  // A work-item for each point, all of a patch with the same plan.
  for (uint base = 0; base < count; base += CC_PLACED_AT_ONCE) {
    const uint i = base + lid / 4;
    const uint k = first + kept[first + min(i, count - 1u)];
    const CcPatchForce force = forces[k];
    const CcFlat flat = ccFlatten(&patches[k], force.normal);
    const CcGrown g = grown[k];
    __global const uint* queue = queues + g.begin;
    const CcNearestHit center = ccNearestOf(
        &pairHits, queue, g.end - g.begin, ccNoHit(force.center, force.normal, CC_WETS, 0.0));
    CcPlan plan = ccPlanOf(&patches[k], &force, &flat, &center, terms->voxel);
    int moved = 1;
    for (int round = 0; round <= CC_WET_ROUNDS; ++round) {
      if (moved) {
        CcNearestHit best = ccNearestOf(
            &pairHits, queue, g.end - g.begin,
            ccNoHit(ccPlannedPlace(&plan, &force, &flat, (int)(lid % 4)),
                    ccPlannedNormal(&plan, &flat, (int)(lid % 4)), CC_COVERS, CC_ABOVE));
        if (ccIsBeside(&best, terms->voxel)) {
          const CcNearestHit mirrored =
              ccNearestOf(&pairHits, queue, g.end - g.begin, ccMirrored(&best));
          best.moves = ccMoves(&mirrored, terms->voxel);
        }
        nearest[lid] = best;
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      if (moved && round < CC_WET_ROUNDS)
        moved = ccMoveToWet(&plan, &flat, nearest + lid / 4 * 4);
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (lid % 4 == 0 && i < count)
      ccContactOf(&patches[k], &force, &flat, &plan, nearest + lid, terms, &whole, &own[i]);
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  if (lid == 0) {
    level = 0.0;
    for (uint i = 0; i < count; ++i) level = ccMax64(level, ccLevelling(&own[i], terms, &whole));
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint i = lid; i < count; i += CC_TEAM) ccLevelDepths(&own[i], terms, &whole, level);
}
