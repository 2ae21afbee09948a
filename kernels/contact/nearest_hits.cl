// Looks places up among the hits of a patch (wet_hits.h). First, the hits of all patches are lined
// up, patch by patch. Then a team takes a patch, and goes through its hits in float, for all its
// places at once: the hit that promises most tells which others may be nearer. Few are; they are
// listed, and tried in double, a work-item each. The nearest of all is the answer. Of equally near
// ones the first in the order of PatchHits::nearest() (plugin/contact/patch_hits.cpp) counts, so
// results equal those of the CPU.

#define CC_MAY_BE 64             // hits that may be nearest to a place and wait to be tried
#define CC_AHEAD (32 * CC_TEAM)  // hits among which they are found at a time
#define CC_NOBODY 0xffffffffu    // comes after all others

// Numbers in float are less exact, so a little more is looked at: of a way, and in cells.
#define CC_ROUNDING 1e-4f
#define CC_MORE 1e-3f

// A number, and its place in an order.
typedef struct {
  double square;
  uint order;
} CcLeast;

int ccIsBefore(CcLeast a, CcLeast b) {
  return (a.square < b.square) | ((a.square == b.square) & (a.order < b.order));
}

// The least number of every `of` work-items, a power of two, and of equals the first; all of the
// team must call it. `room` is memory of the team.
#if defined(CC_NVIDIA)
uint ccFromLane(uint value, uint apart) {
  uint other;
  asm volatile("shfl.sync.bfly.b32 %0, %1, %2, 0x1f, 0xffffffff;"
               : "=r"(other)
               : "r"(value), "r"(apart));
  return other;
}
CcLeast ccLeastOf(__local CcLeast* room, uint of, CcLeast own) {
  for (uint apart = of / 2; apart > 0; apart /= 2) {
    const uint2 halves = as_uint2(own.square);
    const uint2 others = (uint2)(ccFromLane(halves.x, apart), ccFromLane(halves.y, apart));
    const CcLeast other = {as_double(others), ccFromLane(own.order, apart)};
    if (ccIsBefore(other, own)) own = other;
  }
  return own;
}
#else
CcLeast ccLeastOf(__local CcLeast* room, uint of, CcLeast own) {
  const uint lid = get_local_id(0), first = lid / of * of;
  barrier(CLK_LOCAL_MEM_FENCE);
  room[lid] = own;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint k = first; k < first + of; ++k)
    if (ccIsBefore(room[k], own)) own = room[k];
  return own;
}
#endif

// Lines up the hits of patches, bin by bin, each by CC_LINING_UP teams: where each is, and its
// sample's width, which is no number if the hit is none (ccTryHit()); and its normals (CcFacing).
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccLineUp(
    __global const CcPair* pairs, __global const CcResults* results,
    __global const CcListed* listed, __global const uint* queues, __global const CcGrown* grown,
    __global const CcBin* bins, __global const float4* hits, __global const uint* order,
    __global float4* places, __global CcFacing* facing) {
  __local uint ends[CC_TEAM];
  __local CcBin own[CC_TEAM];
  const uint lid = get_local_id(0), all = results->counters[CC_CONTACTS];
  for (uint k = get_group_id(0); k < CC_LINING_UP * all; k += get_num_groups(0)) {
    const CcListed from = listed[k / CC_LINING_UP];
    __global const CcDirection* ways = pairs[from.pair].ways;
    __global const uint* list = order + ways[0].hits;
    const CcGrown queue = grown[from.patch];
    uint to = from.begin;
    for (uint first = queue.begin; first < queue.end; first += CC_TEAM) {
      if (first + lid < queue.end) own[lid] = bins[queues[first + lid]];
      ends[lid] = first + lid < queue.end ? own[lid].end - own[lid].begin : 0u;
      barrier(CLK_LOCAL_MEM_FENCE);
      uint end = 0;
      for (uint i = 0; i <= lid; ++i) end += ends[i];
      barrier(CLK_LOCAL_MEM_FENCE);
      ends[lid] = end;
      barrier(CLK_LOCAL_MEM_FENCE);
      for (uint i = k % CC_LINING_UP * CC_TEAM + lid; i < ends[CC_TEAM - 1];
           i += CC_LINING_UP * CC_TEAM) {
        const uint j = ccRunOf(ends, CC_TEAM, i), n = own[j].end + i - ends[j];
        const int side = n < own[j].middle ? 0 : 1;
        const size_t room = ways[side].room;
        __global const float4* hit = hits + 4 * (size_t)ways[side].hits + list[n];
        const float4 x = hit[0], q = hit[room], r = hit[2 * room];
        const int is = ccGate(q.w, x.w) >= CC_LEAST_GATE;
        places[to + i] = (float4)(x.x, x.y, x.z, is ? sqrt(r.w) : NAN);
        const CcFacing normals = {{q.x, q.y, q.z}, {r.x, r.y, r.z}, r.w, side};
        facing[to + i] = normals;
      }
      to += ends[CC_TEAM - 1];
      barrier(CLK_LOCAL_MEM_FENCE);
    }
  }
}

// The hits of a patch.
typedef struct {
  __global const float4* places;
  __global const CcFacing* facing;
  uint count;
  double cell;
  // Its bins, which hardly ever count.
  __global const CcBin* bins;
  __global const uint* queues;
  __global const CcGrown* grown;
} CcPatchHits;

// A place that is looked up, and the line through it along its normal.
typedef struct {
  float4 place, normal;  // x, y, z; at first CC_ABOVE, then how near hits may be; the reach
  CcNearestHit asked;    // and the answer so far
  int asks;              // whether it is
  uint known;            // a hit that is near, or CC_NOBODY
  uint found;            // the nearest hit
  uint count, left;      // hits that may be nearest, and of those the ones that had no room
  uint may[CC_MAY_BE];
  double square[CC_MAY_BE];  // of the ways to them
  uint more[CC_AHEAD / 32];  // those for which there is no room, a bit for each
} CcLookUp;

// Memory of a team: the places.
typedef struct {
  CcLookUp at[4];
  CcLeast least[CC_TEAM];
} CcWetRoom;

// The square of a hit's way from a line.
float ccFromLine(float4 place, float4 normal, float4 hit) {
  const float3 from = hit.xyz - place.xyz;
  const float along = dot(from, normal.xyz);
  return dot(from, from) - along * along;
}

// The way to the k-th hit, where it is, and its normal from A to B.
CcWayToHit ccWayTo(const CcPatchHits* p, const CcNearestHit* asked, uint k, CcVec* where,
                   CcVec* surface) {
  const float4 place = p->places[k];
  const CcFacing f = p->facing[k];
  *where = ccVec(place.x, place.y, place.z);
  *surface = ccSurfaceOf(f.own, f.other, f.side);
  CcWayToHit way = ccWayBeside(asked, p->cell, *where, CC_SQRT64((double)f.area));
  ccAddAbove(asked, *surface, &way);
  return way;
}

// The hits of the bin whose cell is nearest to the place come first, from `begin` to `end`.
typedef struct {
  uint begin, end;
} CcFirst;

CcFirst ccFirstOf(const CcPatchHits* p, const CcNearestHit* asked) {
  CcFirst first = {0u, 0u};
  double least = INFINITY;
  uint begin = 0;
  for (uint k = p->grown->begin; k < p->grown->end; ++k) {
    __global const CcBin* bin = &p->bins[p->queues[k]];
    const CcVec middle = ccVec((bin->cell[0] + 0.5) * p->cell, (bin->cell[1] + 0.5) * p->cell,
                               (bin->cell[2] + 0.5) * p->cell);
    const double square = ccSquareTo(asked, middle);
    const uint end = begin + (bin->end - bin->begin);
    if (square < least) least = square, first.begin = begin, first.end = end;
    begin = end;
  }
  return first;
}

uint ccRankOf(uint k, CcFirst first) {
  if (k >= first.begin && k < first.end) return k - first.begin;
  return k < first.begin ? k + (first.end - first.begin) : k;
}

// Finds the hit that promises most of each place of which none is known to be near.
void ccPromise(__local CcWetRoom* r, const CcPatchHits* p, uint places) {
  const uint lid = get_local_id(0);
  float least[4];
  uint known[4];
  int seeks = 0;
  for (uint i = 0; i < 4; ++i) least[i] = INFINITY, known[i] = CC_NOBODY;
  for (uint i = 0; i < places; ++i) seeks |= r->at[i].asks && r->at[i].known == CC_NOBODY;
  const uint end = seeks ? p->count : 0u;
#pragma unroll 2
  for (uint k = lid; k < end; k += CC_TEAM) {
    const float4 hit = p->places[k];
    for (uint i = 0; i < 4; ++i) {
      const float3 from = hit.xyz - r->at[i].place.xyz;
      const float along = dot(from, r->at[i].normal.xyz);
      const float square = dot(from, from) - (1.0f - r->at[i].place.w) * (along * along);
      const int is = (hit.w >= 0.0f) & (square < least[i]);
      least[i] = is ? square : least[i];
      known[i] = is ? k : known[i];
    }
  }
  for (uint i = 0; i < places; ++i) {
    const CcLeast own = {least[i], known[i]};
    const uint order = ccLeastOf(r->least, CC_TEAM, own).order;
    if (lid == i && r->at[i].known == CC_NOBODY) r->at[i].known = order;
  }
}

// Others must be as near as the hit that is known, and none where nothing is asked.
void ccLimit(const CcPatchHits* p, __local CcLookUp* l) {
  const CcNearestHit asked = l->asked;
  CcVec where, surface;
  l->place.w = l->asks ? INFINITY : -INFINITY;
  if (l->asks && l->known != CC_NOBODY)
    l->place.w = (1.0f + CC_ROUNDING) *
                 (float)CC_SQRT64(ccWayTo(p, &asked, l->known, &where, &surface).square);
}

// Lists a hit that may be nearest to a place; `at`: its place among those that are looked through.
void ccListOne(__local CcLookUp* l, uint k, uint at) {
  const uint to = atomic_inc(&l->count);
  if (to < CC_MAY_BE)
    l->may[to] = k;
  else
    atomic_or(&l->more[at / 32u], 1u << at % 32u);
}

// Lists the hits from `first` on that may be nearest to the places.
void ccListNear(__local CcWetRoom* r, const CcPatchHits* p, uint first, uint places) {
  const float largest = (float)(CC_LARGEST * p->cell), rounding = CC_MORE * (float)p->cell;
  const uint end = min(first + CC_AHEAD, p->count);
#pragma unroll 2
  for (uint k = first + get_local_id(0); k < end; k += CC_TEAM) {
    const float4 hit = p->places[k];
    for (uint i = 0; i < places; ++i) {
      const float4 place = r->at[i].place, normal = r->at[i].normal;
      const float most = place.w + (fmin(normal.w * hit.w, largest) + rounding);
      if ((hit.w >= 0.0f) & (most >= 0.0f) & (ccFromLine(place, normal, hit) <= most * most))
        ccListOne(&r->at[i], k, k - first);
    }
  }
}

// Takes the nearest of the hits that were tried.
void ccTakeNearest(const CcPatchHits* p, __local CcLookUp* l) {
  const CcNearestHit asked = l->asked;
  double least = asked.square;
  uint found = l->found;
  const uint count = min(l->count, (uint)CC_MAY_BE), left = l->count - count;
  for (uint c = 0; c < count; ++c) {
    const uint k = l->may[c];
    if (l->square[c] > least) continue;
    if (l->square[c] == least && found != CC_NOBODY) {
      const CcFirst start = ccFirstOf(p, &asked);
      if (ccRankOf(k, start) > ccRankOf(found, start)) continue;
    }
    least = l->square[c];
    found = k;
  }
  l->asked.square = least;
  l->found = found;
  l->count = 0u;
  l->left = left;
}

// Lists those of 32 hits for which there was no room.
void ccListMore(__local CcLookUp* l, uint first, uint word) {
  for (uint left = l->more[word]; left != 0u; left &= left - 1u) {
    const uint bit = 31u - clz(left & (0u - left)), to = atomic_inc(&l->count);
    if (to >= CC_MAY_BE) return;
    l->may[to] = first + 32u * word + bit;
    l->more[word] &= ~(1u << bit);
  }
}

// Tries the hits that are listed, each by a work-item; all of the team must call it. Returns
// whether more are listed.
int ccTryListed(__local CcWetRoom* r, const CcPatchHits* p, uint first, uint places) {
  const uint lid = get_local_id(0);
  for (uint i = 0, c = lid; i < places; ++i) {
    __local CcLookUp* l = &r->at[i];
    const uint count = min(l->count, (uint)CC_MAY_BE);
    for (; c < count; c += CC_TEAM) {
      const CcNearestHit asked = l->asked;
      CcVec where, surface;
      l->square[c] = ccWayTo(p, &asked, l->may[c], &where, &surface).square;
    }
    c -= count;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid < places) ccTakeNearest(p, &r->at[lid]);
  barrier(CLK_LOCAL_MEM_FENCE);
  uint left = 0;
  for (uint i = 0; i < places; ++i) {
    if (r->at[i].left > 0u) ccListMore(&r->at[i], first, lid);
    left |= r->at[i].left;
  }
  return left > 0u;
}

// Sets what a look-up is by what is asked.
void ccBeginLookUp(__local CcLookUp* l) {
  const CcNearestHit asked = l->asked;
  l->place = (float4)((float)asked.place.x, (float)asked.place.y, (float)asked.place.z,
                      (float)asked.above);
  l->normal = (float4)((float)asked.normal.x, (float)asked.normal.y, (float)asked.normal.z,
                       (float)asked.reach);
  l->found = CC_NOBODY;
  l->count = 0u;
}

// Answers what is asked of four places; all of the team must call it.
void ccAnswer(__local CcWetRoom* r, const CcPatchHits* p, uint places) {
  const uint lid = get_local_id(0);
  if (lid < places) ccBeginLookUp(&r->at[lid]);
  for (uint i = 0; i < places; ++i) r->at[i].more[lid] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  ccPromise(r, p, places);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid < places) ccLimit(p, &r->at[lid]);
  barrier(CLK_LOCAL_MEM_FENCE);
  int any = 0;
  for (uint i = 0; i < places; ++i) any |= r->at[i].asks;
  for (uint first = 0; first < (any ? p->count : 0u); first += CC_AHEAD) {
    ccListNear(r, p, first, places);
    int left = 1;
    while (left) {
      barrier(CLK_LOCAL_MEM_FENCE);
      left = ccTryListed(r, p, first, places);
    }
  }
  if (lid < places && r->at[lid].found != CC_NOBODY) {
    CcNearestHit best = r->at[lid].asked;
    CcVec where, surface;
    const CcWayToHit way = ccWayTo(p, &best, r->at[lid].found, &where, &surface);
    ccTakeHit(&best, where, surface, &way);
    r->at[lid].asked = best;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Finds what is nearest to the places of all contacts' points, and to the places' mirror images if
// these may move in this round.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccNearest(
    __global const CcResults* results, __global const CcListed* listed,
    __global const uint* queues, __global const CcGrown* grown, __global const CcBin* bins,
    __global const float4* lined, __global const CcFacing* facing, __global CcPlaced* placed,
    int round) {
  __local CcWetRoom room;
  const uint lid = get_local_id(0), places = 4u;
  const uint all = results->counters[CC_CONTACTS];
  for (uint k = get_group_id(0); k < all; k += get_num_groups(0)) {
    if (!placed[k].moved) continue;
    const CcListed from = listed[k];
    const CcPatchHits p = {lined + from.begin, facing + from.begin, from.count, from.cell, bins,
                           queues, &grown[from.patch]};
    __local CcLookUp* own = &room.at[lid & 3u];
    CcNearestHit found;
    if (lid < places) {
      own->asked = placed[k].found[lid];
      own->asks = 1;
      own->known = CC_NOBODY;
    }
    for (int mirrored = 0; mirrored < (round == CC_WET_ROUNDS ? 1 : 2); ++mirrored) {
      ccAnswer(&room, &p, places);
      if (lid >= places) continue;
      const CcNearestHit answer = own->asked;
      if (mirrored) {
        if (own->asks) found.moves = ccMoves(&answer, from.voxel);
        continue;
      }
      found = answer;
      own->asks = placed[k].plan.pressed > 0.0 && ccIsBeside(&found, from.voxel);
      own->known = own->found;
      own->asked = ccMirrored(&found);
    }
    if (lid < places) placed[k].found[lid] = found;
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}
