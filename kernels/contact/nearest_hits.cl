// A team looks places up among the hits of a patch, all at once (wet_hits.h). The hits are in local
// memory, a chunk at a time, which for most patches is all of them: so the reads that wait for each
// other are done once. Each place has some work-items, and each of these tries every so many hits.
// The nearest of all is the answer. Of equally near ones the first in the order
// of PatchHits::nearest() (plugin/contact/patch_hits.cpp) counts, so results equal those of the CPU.

#define CC_CHUNK 256           // hits
#define CC_CHUNK_BINS CC_TEAM  // a bin for each work-item
#define CC_ORDER_BITS 22       // of a hit's place in its bin
#define CC_NOBODY 0xffffffffu  // comes after all others

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

// Hits of a patch, side by side.
typedef struct {
  CcPatchHits patch;
  uint bin, place;  // the next chunk's first bin, and the first hit in it
  uint count;       // hits
  int whole;        // all of the patch's hits
  uint counts[CC_CHUNK_BINS];                    // of hits in each bin
  uint which[CC_CHUNK];                          // bin << CC_ORDER_BITS | place in the bin
  float x[CC_CHUNK], y[CC_CHUNK], z[CC_CHUNK];   // not a number: is none
  double u[CC_CHUNK], v[CC_CHUNK], w[CC_CHUNK];  // ccSurfaceOf()
  double width[CC_CHUNK];                        // root of the sample's area
} CcChunk;

// Memory of a team: hits of its patch, what each of the patch's points asks, which becomes the
// answer, and whether it asks.
typedef struct {
  CcChunk chunk;
  CcNearestHit asked[4];
  int asks[4];
  CcLeast least[CC_TEAM];
} CcWetRoom;

void ccBeginPatch(__local CcChunk* c, CcPatchHits patch) {
  c->patch = patch;
  c->bin = c->place = c->count = 0u;
  c->whole = 0;
}

// Counts the hits that are left in the chunk's bins.
void ccCountHits(__local CcChunk* c) {
  __local const CcPatchHits* p = &c->patch;
  const uint j = get_local_id(0);
  uint count = 0;
  if (c->bin + j < p->count) {
    __global const CcBin* bin = &p->bins[p->queue[c->bin + j]];
    count = bin->end - bin->begin - (j == 0 ? c->place : 0u);
  }
  c->counts[j] = count;
}

// Lists as many of them as have room.
void ccListChunk(__local CcChunk* c) {
  const uint j = get_local_id(0);
  uint to = 0;
  for (uint i = 0; i < j; ++i) to += c->counts[i];
  const uint end = min(to + c->counts[j], (uint)CC_CHUNK);
  uint which = (c->bin + j) << CC_ORDER_BITS | (j == 0 ? c->place : 0u);
  for (; to < end; ++to) c->which[to] = which++;
}

// Counts what was listed, and finds where the next chunk begins.
void ccEndChunk(__local CcChunk* c) {
  uint count = 0, j = 0;
  while (j < CC_CHUNK_BINS && count + c->counts[j] <= CC_CHUNK) count += c->counts[j++];
  const int whole = c->bin == 0 && c->place == 0;
  if (j < CC_CHUNK_BINS) {
    c->place = (j == 0 ? c->place : 0u) + CC_CHUNK - count;
    count = CC_CHUNK;
  } else {
    c->place = 0u;
  }
  c->bin += j;
  c->count = count;
  c->whole = whole && c->bin >= c->patch.count;
}

// Reads the hits that are listed.
void ccReadHits(__local CcChunk* c) {
  __local const CcPatchHits* p = &c->patch;
  for (uint k = get_local_id(0); k < c->count; k += CC_TEAM) {
    const uint which = c->which[k];
    const CcBin bin = p->bins[p->queue[which >> CC_ORDER_BITS]];
    const uint n = bin.begin + (which & ((1u << CC_ORDER_BITS) - 1u));
    const int side = n < bin.middle ? 0 : 1;
    __global const float4* hit = p->hits[side] + p->list[n];
    const float4 x = hit[0], q = hit[p->room[side]], r = hit[2 * p->room[side]];
    const float mine[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
    const CcVec surface = ccSurfaceOf(mine, other, side);
    c->x[k] = ccGate(q.w, x.w) < CC_LEAST_GATE ? NAN : x.x;
    c->y[k] = x.y;
    c->z[k] = x.z;
    c->u[k] = surface.x;
    c->v[k] = surface.y;
    c->w[k] = surface.z;
    c->width[k] = CC_SQRT64((double)r.w);
  }
}

// Takes in the next chunk of the patch if it `must`; all of the team must call it.
void ccTakeChunk(__local CcChunk* c, int must) {
  barrier(CLK_LOCAL_MEM_FENCE);
  if (must) ccCountHits(c);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (must) ccListChunk(c);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (must && get_local_id(0) == 0) ccEndChunk(c);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (must) ccReadHits(c);
  barrier(CLK_LOCAL_MEM_FENCE);
}

CcVec ccWhereIs(__local const CcChunk* c, uint k) {
  return ccVec(c->x[k], c->y[k], c->z[k]);
}

// The way to the chunk's k-th hit.
CcWayToHit ccWayTo(__local const CcChunk* c, const CcNearestHit* asked, uint k) {
  CcWayToHit way = ccWayBeside(asked, c->patch.cell, ccWhereIs(c, k), c->width[k]);
  ccAddAbove(asked, ccVec(c->u[k], c->v[k], c->w[k]), &way);
  return way;
}

// What a work-item looks up: every `of`-th hit for the point `who`, one of each `of` work-items.
typedef struct {
  CcNearestHit asked;
  uint who, of, part;
  int asks;
  uint first;     // the bin whose hits come first
  CcLeast least;  // nearest hit so far
} CcLookUp;

// The bin whose cell is nearest to the place.
uint ccFirstBin(__local CcLeast* room, __local const CcPatchHits* p, const CcLookUp* l) {
  CcLeast own = {INFINITY, CC_NOBODY};
  for (uint k = l->part; k < (l->asks ? p->count : 0u); k += l->of) {
    __global const int* cell = p->bins[p->queue[k]].cell;
    const CcVec middle = ccVec((cell[0] + 0.5) * p->cell, (cell[1] + 0.5) * p->cell,
                               (cell[2] + 0.5) * p->cell);
    const double square = ccSquareTo(&l->asked, middle);
    if (square < own.square) own.square = square, own.order = k;
  }
  return ccLeastOf(room, l->of, own).order;
}

// A hit's place in the order of bins and hits, if those of the bin `first` come first.
uint ccRankOf(uint which, uint first) {
  const uint bin = which >> CC_ORDER_BITS;
  if (bin == first) return which & ((1u << CC_ORDER_BITS) - 1u);
  return bin < first ? which + (1u << CC_ORDER_BITS) : which;
}

// How near the hit of the chunk is that is most nearly on the line: others must be as near.
void ccLimit(__local CcLeast* room, __local const CcChunk* c, CcLookUp* l) {
  CcLeast own = {INFINITY, CC_NOBODY};
  for (uint k = l->part; k < (l->asks ? c->count : 0u); k += l->of) {
    const double square = ccSquareAside(ccMinus(ccWhereIs(c, k), l->asked.place), l->asked.normal);
    if (square < own.square) own.square = square, own.order = k;
  }
  const uint nearly = ccLeastOf(room, l->of, own).order;
  if (nearly != CC_NOBODY) {
    const double square = ccWayTo(c, &l->asked, nearly).square;
    if (square < l->asked.square) {
      l->asked.square = square;
      l->asked.nearest = CC_SQRT64(square);
    }
  }
}

// The work-item's nearest hit of the chunk that is nearer than `least`, which it becomes; or
// CC_NOBODY.
uint ccNearestOf(__local const CcChunk* c, CcLookUp* l) {
  uint nearest = CC_NOBODY;
  for (uint k = l->part; k < (l->asks ? c->count : 0u); k += l->of) {
    const CcVec from = ccMinus(ccWhereIs(c, k), l->asked.place);
    const double most = l->asked.nearest +
                        ccMin64(l->asked.reach * c->width[k], CC_LARGEST * c->patch.cell);
    if (!(ccSquareAside(from, l->asked.normal) <= most * most)) continue;
    const CcLeast own = {ccWayTo(c, &l->asked, k).square, ccRankOf(c->which[k], l->first)};
    if (ccIsBefore(own, l->least)) l->least = own, nearest = k;
  }
  return nearest;
}

// Tries the hits of a chunk; all of the team must call it.
void ccTryChunk(__local CcWetRoom* r, __local const CcChunk* c, CcLookUp* l) {
  ccLimit(r->least, c, l);
  const uint k = ccNearestOf(c, l), order = l->least.order;
  l->least = ccLeastOf(r->least, l->of, l->least);
  if (k != CC_NOBODY && order == l->least.order) {
    CcNearestHit best = r->asked[l->who];
    const CcWayToHit way = ccWayTo(c, &best, k);
    ccTakeHit(&best, ccWhereIs(c, k), ccVec(c->u[k], c->v[k], c->w[k]), &way);
    r->asked[l->who] = best;
  }
}

// Answers what points ask; all of the team must call it. Each `of` work-items look one up: all 32
// the first, or 8 each. Barriers are in no branches, which PoCL would compile for each way.
void ccAnswerAll(__local CcWetRoom* r, uint of) {
  const uint lid = get_local_id(0);
  __local CcChunk* c = &r->chunk;
  barrier(CLK_LOCAL_MEM_FENCE);
  CcLookUp l;
  l.of = of;
  l.who = lid / of;
  l.part = lid % of;
  l.asks = r->asks[l.who];
  l.asked = r->asked[l.who];
  l.first = ccFirstBin(r->least, &c->patch, &l);
  l.least.square = l.asked.square;
  l.least.order = CC_NOBODY;
  if (!c->whole && lid == 0) c->bin = c->place = 0u;
  int left = r->asks[0] | r->asks[1] | r->asks[2] | r->asks[3];
  while (left) {
    ccTakeChunk(c, !c->whole);
    ccTryChunk(r, c, &l);
    left = !c->whole && c->bin < c->patch.count;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}
