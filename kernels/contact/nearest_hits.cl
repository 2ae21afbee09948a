// Looks places up among the hits of patches, a team for each look-up (wet_hits.h). A patch has
// twenty to thousands of hits, so no work-item goes over them alone: each tries every CC_TEAM-th
// hit of a bin, and the nearest of all is the answer. Of equally near ones the first in the order of
// PatchHits::nearest() (plugin/contact/patch_hits.cpp) counts, so results equal those of the CPU.

#define CC_ORDER_BITS 22                 // of a hit's place in its bin
#define CC_NOBODY 0xffffffffu            // comes after all others

// A number, and its place in an order.
typedef struct {
  double square;
  uint order;
} CcLeast;

int ccIsBefore(CcLeast a, CcLeast b) {
  return (a.square < b.square) | ((a.square == b.square) & (a.order < b.order));
}

// The team's least number, and of equals the first; all of the team must call it. `room` is memory
// of the team.
#if defined(CC_NVIDIA)
uint ccFromLane(uint value, uint apart) {
  uint other;
  asm volatile("shfl.sync.bfly.b32 %0, %1, %2, 0x1f, 0xffffffff;"
               : "=r"(other)
               : "r"(value), "r"(apart));
  return other;
}
CcLeast ccLeastOf(__local CcLeast* room, CcLeast own) {
  for (uint apart = CC_TEAM / 2; apart > 0; apart /= 2) {
    const uint2 halves = as_uint2(own.square);
    const uint2 others = (uint2)(ccFromLane(halves.x, apart), ccFromLane(halves.y, apart));
    const CcLeast other = {as_double(others), ccFromLane(own.order, apart)};
    if (ccIsBefore(other, own)) own = other;
  }
  return own;
}
#else
CcLeast ccLeastOf(__local CcLeast* room, CcLeast own) {
  const uint lid = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  room[lid] = own;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid == 0)
    for (uint k = 1; k < CC_TEAM; ++k)
      if (ccIsBefore(room[k], room[0])) room[0] = room[k];
  barrier(CLK_LOCAL_MEM_FENCE);
  return room[0];
}
#endif

// The hits of a patch, bin by bin.
typedef struct {
  __global const CcBin* bins;
  __global const uint *queue, *list;  // the patch's bins; the pair's hits
  __global const float4* hits[2];     // each body's
  size_t room[2];
  uint count;  // of the patch's bins
  double cell;
} CcPatchHits;

CcPatchHits ccPatchHitsOf(__global const CcPair* pair, int level, __global const CcBin* bins,
                          CcGrown grown, __global const uint* queues, __global const float4* hits,
                          __global const uint* order) {
  CcPatchHits p;
  p.bins = bins;
  p.queue = queues + grown.begin;
  p.list = order + pair->ways[0].hits;
  for (int s = 0; s < 2; ++s) {
    p.hits[s] = hits + 4 * (size_t)pair->ways[s].hits;
    p.room[s] = pair->ways[s].room;
  }
  p.count = grown.end - grown.begin;
  p.cell = pair->cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0);
  return p;
}

// Memory of a team: the patches whose points it places, and what each work-item asks, which
// becomes the answer.
typedef struct {
  CcPatchHits patches[CC_PLACED_AT_ONCE];
  CcNearestHit asked[CC_TEAM];
  CcLeast least[CC_TEAM];
  uint votes;
} CcWetRoom;

// The middle of the cell of a patch's k-th bin.
CcVec ccMiddleOf(__local const CcPatchHits* p, uint k) {
  __global const int* cell = p->bins[p->queue[k]].cell;
  return ccVec((cell[0] + 0.5) * p->cell, (cell[1] + 0.5) * p->cell, (cell[2] + 0.5) * p->cell);
}

// A work-item's nearest hit so far, and its place in the order.
typedef struct {
  CcNearestHit hit;
  uint order;
} CcOwnNearest;

// Tries the work-item's hits of a patch's k-th bin.
void ccTryBin(__local const CcPatchHits* p, uint k, CcOwnNearest* own) {
  const CcBin bin = p->bins[p->queue[k]];
  for (uint n = bin.begin + get_local_id(0); n < bin.end; n += CC_TEAM) {
    const int side = n < bin.middle ? 0 : 1;
    __global const float4* hit = p->hits[side] + p->list[n];
    const float4 x = hit[0], q = hit[p->room[side]], r = hit[2 * p->room[side]];
    const float at[3] = {x.x, x.y, x.z}, mine[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
    const double before = own->hit.square;
    ccTryHit(&own->hit, p->cell, at, mine, other, q.w, x.w, r.w, side);
    if (own->hit.square < before) own->order = k << CC_ORDER_BITS | (n - bin.begin);
  }
}

// Makes the nearest hit of all work-items the answer to what `who` asks, which each then has to
// beat.
void ccShareNearest(__local CcWetRoom* r, uint who, CcOwnNearest* own) {
  const CcLeast mine = {own->hit.square, own->order}, least = ccLeastOf(r->least, mine);
  if (own->order == least.order && least.order != CC_NOBODY) r->asked[who] = own->hit;
  barrier(CLK_LOCAL_MEM_FENCE);
  own->hit.square = r->asked[who].square;
  own->hit.nearest = r->asked[who].nearest;
  own->order = CC_NOBODY;
}

// The bin whose cell is nearest to the place.
uint ccFirstBin(__local CcWetRoom* r, __local const CcPatchHits* p, const CcNearestHit* asked) {
  CcLeast own = {INFINITY, CC_NOBODY};
  for (uint k = get_local_id(0); k < p->count; k += CC_TEAM) {
    const double square = ccSquareTo(asked, ccMiddleOf(p, k));
    if (square < own.square) own.square = square, own.order = k;
  }
  return min(ccLeastOf(r->least, own).order, p->count - 1u);
}

// Answers what the work-item `who` asks; all of the team must call it. The nearest bin comes first,
// and leaves few others. Barriers are in no branches, which PoCL would compile for each way.
void ccAnswer(__local CcWetRoom* r, uint who) {
  __local const CcPatchHits* p = &r->patches[who / 4];
  CcOwnNearest own = {r->asked[who], CC_NOBODY};
  const uint first = ccFirstBin(r, p, &own.hit);
  ccTryBin(p, first, &own);
  ccShareNearest(r, who, &own);
  for (uint base = 0; base < p->count; base += CC_TEAM) {
    const uint k = base + get_local_id(0);
    const int may = k < p->count && k != first &&
                    ccMayBeNearer(&own.hit, ccMiddleOf(p, min(k, p->count - 1u)), p->cell);
    for (uint left = ccVotes(&r->votes, may); left; left &= left - 1u)
      ccTryBin(p, base + ccLowest(left), &own);
  }
  ccShareNearest(r, who, &own);
}

// Answers what some work-items ask: those whose `asks` is not 0.
void ccAnswerAll(__local CcWetRoom* r, int asks) {
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint left = ccVotes(&r->votes, asks); left; left &= left - 1u) ccAnswer(r, ccLowest(left));
  barrier(CLK_LOCAL_MEM_FENCE);
}
