// Patches become contacts. A team for each pair finds the patches' forces, lists the patches that
// count, and sums what belongs to the pair as a whole. Then teams place the points of all pairs'
// patches, each those of a patch at a time (nearest_hits.cl). Last, a team for each pair shares the
// depths out.

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
               forces[k].lean, 0);
    kept[counted++] = (ushort)k;
  }
  return counted;
}

// What belongs to the pair as a whole.
CcWhole ccWholeOf(__global const CcTerms* terms, __global const CcSums* patches,
                  __global const CcPatchForce* forces, __local const ushort* kept, uint counted,
                  const CcPairSums* sums, const CcPairDepth* found, double edged, int level) {
  CcWhole w = {sums->size, sums->area, 0.0, terms->foundation ? 0.0 : found->depth,
               ccDepthError(sums, found, edged, level, 0, terms->voxel)};
  for (uint i = 0; i < counted; ++i)
    w.shares += ccShareOf(patches[kept[i]].area, forces[kept[i]].size, &w);
  return w;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccForces(
    __global const CcPair* pairs, __global CcResults* results, __global const CcSums* patches,
    __global CcPatchForce* forces, __global CcWhole* wholes, __global uint2* listed,
    __global const CcField* fields, __global const CcVoxel* records, __global const int* ints,
    __global const CcFound* found, __global const float4* hits) {
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
    forces[first + k] = ccForceOf(&patches[first + k], terms->foundation, 0, 0, &flat);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  CcPairSums sums = ccNoPatches();
  CcPairDepth depth = {0.0, 0.0, 0.0};
  double edged = 0.0, edge = 0.0;
  if (lid == 0) {
    count = ccPairSumsOf(terms, patches + first, forces + first, all, kept, &sums);
    depth = ccDepthOfPair(&sums, 0, terms->voxel);
    edged = sums.size > 0.0 ? ccEdgedOnFace(&sums, &depth) : 0.0;
    sharp = edged > 0.0 && !terms->foundation;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint side = 0; side < 2; ++side)
    edge = ccMax64(edge, ccEdgeOf(&pairs[p].ways[side], &found[(2 * p + side) * CC_LEVELS],
                                  sharp ? level : CC_LEVELS, &data, hits, &room));
  if (lid == 0) {
    const int gives = edge > depth.depth;
    if (gives) ccTakeEdge(&depth, edged, edge);
    wholes[p] = ccWholeOf(terms, patches + first, forces + first, kept, count, &sums, &depth,
                          gives ? edged : 0.0, level);
    place = atomic_add(&results->counters[CC_CONTACTS], count);
    answers[p].firstPatch = place;
    answers[p].patches = count;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  for (uint i = lid; i < count; i += CC_TEAM) listed[place + i] = (uint2)(p, first + kept[i]);
}

// What a point's work-item asks in the stages of placing: what is nearest to its patch's center,
// which one of four asks; then, in each round, what is nearest to its place, and to the place's
// mirror image, if it may move.
#define CC_CENTER 0
#define CC_STAGES (2 * CC_WET_ROUNDS + 2)

int ccIsMirror(int stage) {
  return stage != CC_CENTER && stage % 2 == 0;
}

// A point, which the first of the work-items that look it up has, and its patch on the way;
// `moved`: whether places of the patch did in the last round.
typedef struct {
  CcPatchForce force;
  CcFlat flat;
  CcPlan plan;
  int point, moved;
} CcPlacing;

// What a point asks in a stage; returns whether it does. `nearest`: to its place.
int ccAsk(const CcPlacing* at, int stage, __local const CcNearestHit* nearest,
          __local CcNearestHit* asked) {
  const int i = at->point;
  if (stage == CC_CENTER) {
    *asked = ccNoHit(at->force.center, at->force.normal, CC_WETS, 0.0);
    return i == 0;
  }
  if (!ccIsMirror(stage)) {
    *asked = ccNoHit(ccPlannedPlace(&at->plan, &at->force, &at->flat, i),
                     ccPlannedNormal(&at->plan, &at->flat, i), CC_COVERS, CC_ABOVE);
    return at->moved;
  }
  const CcNearestHit own = *nearest;
  *asked = ccMirrored(&own);
  return at->moved && ccMayMove(&at->plan, &own);
}

// Takes the answer of a stage.
void ccHear(__local const CcWetRoom* room, __local CcNearestHit* nearest,
            __global const CcSums* patch, double voxel, int stage, CcPlacing* at) {
  const int point = at->point;
  const CcNearestHit answer = room->asked[stage == CC_CENTER ? 0 : point];
  if (stage == CC_CENTER)
    at->plan = ccPlanOf(patch, &at->force, &at->flat, &answer, voxel);
  else if (!ccIsMirror(stage) && room->asks[point])
    nearest[point] = answer;
  else if (room->asks[point])
    nearest[point].moves = ccMoves(&answer, voxel);
}

// Places a patch's points as PatchHits::place() does. `is`: whether the work-item has a point.
// Barriers are in no branches.
void ccPlace(__local CcWetRoom* room, __local CcNearestHit* nearest, __global const CcSums* patch,
             double voxel, int is, CcPlacing* at) {
  const int point = at->point;
  for (int stage = CC_CENTER; stage < CC_STAGES; ++stage) {
    if (is) room->asks[point] = ccAsk(at, stage, &nearest[point], &room->asked[point]);
    ccAnswerAll(room, stage == CC_CENTER ? CC_TEAM : CC_TEAM / 4);
    if (is) ccHear(room, nearest, patch, voxel, stage, at);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (is && ccIsMirror(stage) && at->moved)
      at->moved = ccMoveToWet(&at->plan, &at->flat, nearest);
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// `listed`: each contact's pair and patch.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccContacts(
    __global const CcPair* pairs, __global const CcResults* results,
    __global const CcSums* patches, __global const CcPatchForce* forces,
    __global const CcWhole* wholes, __global const uint2* listed, __global const uint* queues,
    __global const CcGrown* grown, __global const CcBin* bins, __global const float4* hits,
    __global const uint* order, __global CcContactPatch* contacts, uint contactsAt) {
  __local CcWetRoom room;
  __local CcNearestHit nearest[4];
  const uint lid = get_local_id(0), all = results->counters[CC_CONTACTS];
  const int is = lid % (CC_TEAM / 4) == 0;
  for (uint k = get_group_id(0); k < all; k += get_num_groups(0)) {
    const uint2 from = listed[k];
    __global const CcPair* pair = &pairs[from.x];
    __global const CcSums* patch = &patches[from.y];
    CcPlacing at;
    at.point = (int)(lid / (CC_TEAM / 4));
    at.moved = 1;
    if (is) {
      at.force = forces[from.y];
      at.flat = ccFlatten(patch, at.force.normal);
    }
    if (lid == 0)
      ccBeginPatch(&room.chunk, ccPatchHitsOf(pair, results->answers[from.x].level, bins,
                                              grown[from.y], queues, hits, order));
    ccPlace(&room, nearest, patch, pair->terms.voxel, is, &at);
    const CcWhole whole = wholes[from.x];
    if (lid == 0)
      ccContactOf(patch, &at.force, &at.flat, &at.plan, nearest, &pair->terms, &whole,
                  &contacts[contactsAt + k]);
    barrier(CLK_LOCAL_MEM_FENCE);
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
