// A level of the search, of all pairs that want it: a group for each direction of a pair. Samples
// are asked in windows, in their order, and what is found keeps it: hits of whole samples, then of
// those below the band, then of parts of samples over an edge (parts.cl), as lane_search.h of
// plugin/contact has them. A sample in five is a hit: which ones may be is found out first, so that
// all work-items have one when hits are worked out.

#define CC_SOURCES 4  // of a work-item at a time

// All fields' numbers: one buffer, seen as each of its types.
typedef struct {
  __global const float4* floats;
  __global const CcVoxel* records;
  __global const int* ints;
  __global const uint* uints;
  __global const uint2* runs;
} CcFields;

// What a group's work-items share.
typedef struct {
  CcDirection dir;
  CcField own, other;
  CcLimits limits;
  int level, side;
  float perCell, unit;  // [1/m] of a bin's cell; [m^2] of a sample's area
} CcTask;

// Where hits go.
typedef struct {
  __global float4* hits;
  __global ulong* keys;
} CcOut;

// Room of a group for a window of samples.
typedef struct {
  uint samples[CC_WINDOW];
  ushort tried[CC_WINDOW];  // those that may be hits, by their place in the window
  uint sums[2 * CC_GROUP];
  CcMarks marks;
  CcFlags flags;
  uint triedCount, near, below, over;  // so far
  uint rounds;                         // 2 where samples lie below the band or over an edge
} CcWindow;

typedef struct {
  float x[3], n[3], width, area;
} CcSample;

CcSample ccSampleOf(__local const CcTask* t, CcFields all, uint k) {
  __local const CcField* f = &t->own;
  const float4 p = all.floats[f->samples[t->level] + k],
               q = all.floats[f->samples[t->level] + f->counts[t->level] + k];
  const CcSample s = {{p.x, p.y, p.z}, {q.x, q.y, q.z}, p.w, q.w};
  return s;
}

CcPlace ccPlaceIn(__local const CcTask* t, const float* x) {
  float at[3];
  ccApply(&t->dir.way.toOther, x, at);
  const CcBricks bricks = {t->other.nx, t->other.ny, t->other.nz};
  return ccPlaceOf(bricks, at);
}

CcVoxel ccRecordAt(__local const CcTask* t, CcFields all, const CcPlace* place) {
  const int first = all.ints[t->other.firsts + (uint)place->brick];
  return all.records[t->other.records + (uint)(first + place->cell)];
}

// The i-th hit of the direction.
void ccPut(__local const CcTask* t, CcOut out, uint i, const CcHit* h, float area, float depth) {
  const uint room = t->dir.room;
  __global float4* hits = out.hits + 4 * (size_t)t->dir.hits + i;
  hits[0] = (float4)(h->position[0], h->position[1], h->position[2], depth);
  hits[room] = (float4)(h->own[0], h->own[1], h->own[2], h->facing);
  hits[2 * (size_t)room] = (float4)(h->other[0], h->other[1], h->other[2], area);
  hits[3 * (size_t)room] = (float4)(h->wet.share, h->wet.depth1, h->wet.depth2, h->wet.depth3);
  const CcBinOfHit b = ccBinOf(h->position, h->own, h->other, h->facing, t->side, t->perCell);
  out.keys[t->dir.hits + i] = ccBinKey(b.x, b.y, b.z, b.direction);
}

CcHit ccHitFrom(__local const CcTask* t, const float* x, const float* n, const CcDepth* d,
                float width) {
  return ccHitIn(&t->dir.way.toFrame, t->dir.way.frameFromOwn, t->dir.way.frameFromOther, x, n,
                 d->normal, d->depth, t->limits.halfWidth * width);
}

// A source of samples: of the coarsest level a brick that may touch, else a sample's cell.
uint2 ccRunFrom(__local const CcTask* t, uint i, uint sources, CcFields all,
                __global const uint* nearby) {
  if (i >= sources) return (uint2)(0, 0);
  if (t->level == CC_LEVELS - 1) {
    const float4 b = all.floats[t->own.bricks + i];
    const float center[3] = {b.x, b.y, b.z};
    const CcBricks bricks = {t->other.nx, t->other.ny, t->other.nz};
    const int touches =
        ccBrickTouches(&t->dir.way.toOther, center, b.w, t->own.voxel / t->other.voxel, bricks,
                       all.ints + t->other.between);
    return touches ? all.runs[t->own.runs + i] : (uint2)(0, 0);
  }
  // A cell's samples lie side by side: it is looked into once, for the first of them.
  __global const uint* cells = all.uints + t->own.cells[t->level + 1];
  const uint cell = cells[nearby[i]];
  if (i > 0 && cells[nearby[i - 1]] == cell) return (uint2)(0, 0);
  return all.runs[t->own.finer[t->level + 1] + cell];
}

// What ccAsk() tells of a sample.
#define CC_MAY_HIT 1u
#define CC_FINER 2u    // finer samples beside it are asked for
#define CC_BELOW 4u    // below the band
#define CC_DIVIDED 8u  // over an edge

uint ccAsk(__local const CcTask* t, CcFields all, uint k) {
  const CcSample s = ccSampleOf(t, all, k);
  const CcPlace place = ccPlaceIn(t, s.x);
  const CcVoxel record = ccRecordAt(t, all, &place);
  const uint count = ccPlaneCount(record);
  if (count == 0u && record.b == 0u) return 0u;
  __global const CcVoxel* planes = all.records + t->other.planes;
  CcDepth d = {0.0f, {0.0f, 0.0f, 0.0f}};
  if (count > 0u) {
    d = ccVoxelDepth(record, planes, place.r);
    d.depth *= t->other.voxel;
  }
  float turned[3];
  ccTurn(t->dir.way.turnToOther, s.n, turned);
  const int kind = ccKindOf(&t->limits, record, d.depth, turned, d.normal, s.width);
  uint is = (kind & CC_NEARBY ? CC_FINER : 0u) | (kind & CC_DEEP ? CC_BELOW : 0u);
  if (count > 1u && t->level < CC_LEVELS - 1 &&
      ccEdgeWithin(&t->limits, record, planes, place.r, d.depth, d.normal, s.width, t->other.voxel,
                   t->own.voxel))
    is |= CC_DIVIDED;
  else if ((kind & CC_WET) && ccMayHit(&t->limits, d.depth, ccDot(turned, d.normal), s.width))
    is |= CC_MAY_HIT;
  return is;
}

// Asks for the window's samples. Those that may be hits are listed; numbers of the others that
// matter go to `next`, `deep` and `divided`.
void ccAskWindow(__local const CcTask* t, CcFields all, __local CcWindow* w, uint some,
                 __global uint* next, __global uint* deep, __global uint* divided) {
  const uint lid = get_local_id(0), room = t->dir.room;
  uint first = 0, second = 0;
  for (uint j = 0; j * CC_GROUP < some; ++j) {
    const uint k = j * CC_GROUP + lid;
    const uint is = k < some ? ccAsk(t, all, w->samples[k]) : 0u;
    first |= ((is & 1u) | (is & 2u) << 15) << j;
    second |= ((is >> 2 & 1u) | (is >> 2 & 2u) << 15) << j;
  }
  if (second) w->rounds = 2;
  ccMark(&w->marks, w->sums, first);
  const uint near = w->near;
  for (uint j = 0; j * CC_GROUP < some; ++j) {
    const uint k = j * CC_GROUP + lid;
    if (first >> j & 1u) w->tried[ccMarked(&w->marks, 0, j)] = (ushort)k;
    if (first >> (16 + j) & 1u) next[near + ccMarked(&w->marks, 1, j)] = w->samples[k];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid == 0) {
    w->triedCount = w->marks.all & 0xffffu;
    w->near += w->marks.all >> 16;
  }
  for (uint n = 1; n < w->rounds; ++n) {
    ccMark(&w->marks, w->sums, second);
    const uint below = w->below, over = w->over;
    for (uint j = 0; j * CC_GROUP < some; ++j) {
      const uint sample = w->samples[j * CC_GROUP + lid];
      const uint atBelow = below + ccMarked(&w->marks, 0, j),
                 atOver = over + ccMarked(&w->marks, 1, j);
      if (second >> j & 1u && atBelow < room) deep[atBelow] = sample;
      if (second >> (16 + j) & 1u && atOver < room) divided[atOver] = sample;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0) {
      w->below += w->marks.all & 0xffffu;
      w->over += w->marks.all >> 16;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Hits among the samples listed, counted by the window's flags.
void ccTakeWhole(__local const CcTask* t, CcFields all, __local CcWindow* w, CcOut out) {
  const uint count = w->triedCount;
  for (uint base = 0; base < count; base += CC_GROUP) {
    const uint k = base + get_local_id(0);
    CcHit h;
    float area = 0.0f, depth = 0.0f;
    uint is = 0;
    if (k < count) {
      const CcSample s = ccSampleOf(t, all, w->samples[w->tried[k]]);
      const CcPlace place = ccPlaceIn(t, s.x);
      CcDepth d = ccVoxelDepth(ccRecordAt(t, all, &place), all.records + t->other.planes, place.r);
      d.depth *= t->other.voxel;
      h = ccHitFrom(t, s.x, s.n, &d, s.width);
      is = h.wet.depth1 > 0.0f;
      area = s.area * t->unit;
      depth = d.depth;
    }
    ccFlag(&w->flags, 1, is);
    const uint at = is ? ccFlagged(&w->flags, 0) : t->dir.room;
    if (at < t->dir.room) ccPut(t, out, at, &h, area, depth);
  }
}

// Samples below the band, by their numbers; hits from the one numbered `begin`.
void ccTakeDeep(__local const CcTask* t, CcFields all, uint count, __global const uint* deep,
                uint begin, CcOut out) {
  for (uint i = get_local_id(0); i < count; i += CC_GROUP) {
    const CcSample s = ccSampleOf(t, all, deep[i]);
    const CcPlace place = ccPlaceIn(t, s.x);
    const float depth =
        ccDepthBelow(all.ints[t->other.distance + (uint)place.brick], t->other.voxel);
    float at[3], normal[3], back[3];
    ccApply(&t->dir.way.toFrame, s.x, at);
    ccTurn(t->dir.way.frameFromOwn, s.n, normal);
    for (int k = 0; k < 3; ++k) back[k] = -normal[k];
    const CcHit h = ccHitOf(at, normal, back, depth, t->limits.halfWidth * s.width);
    ccPut(t, out, begin + i, &h, s.area * t->own.voxel * t->own.voxel, depth);
  }
}

// The window's samples, of runs of which this work-item has some: `before` samples of the others.
void ccList(__local CcWindow* w, const uint2* runs, uint before, uint begin) {
  for (uint s = 0; s < CC_SOURCES; ++s) {
    for (uint j = 0; j < runs[s].y; ++j) {
      const uint k = before + j - begin;
      if (k < CC_WINDOW) w->samples[k] = runs[s].x + j;
    }
    before += runs[s].y;
  }
}

// What a group shares of the direction d; all wait for it.
void ccBegin(__local CcTask* t, int level, uint d, __global const CcField* fields,
             __global const CcPair* pairs, __global const CcDirection* directions) {
  if (get_local_id(0) == 0) {
    t->dir = directions[d];
    t->own = fields[t->dir.own];
    t->other = fields[t->dir.other];
    t->limits = ccLimitsOf(level, t->own.voxel, pairs[d / 2].margin);
    t->level = level;
    t->side = (int)(d & 1u);
    t->perCell = (float)(1.0 / (pairs[d / 2].cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0)));
    t->unit = t->own.voxel * t->own.voxel;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSearch(
    int level, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs,
    __global const CcDirection* directions, __global CcFound* found, __global uint* nearby,
    __global float4* hits, __global ulong* keys, __global uint* aside, __global uint* counters) {
  __local CcTask t;
  __local CcWindow w;
  const uint lid = get_local_id(0), d = get_group_id(0);
  if (level == CC_LEVELS - 1 && d == 0 && lid < CC_COUNTERS) counters[lid] = 0u;
  if (level < CC_LEVELS - 1 &&
      ccLastLevel(&pairs[d / 2], found + (d & ~1u) * CC_LEVELS, level + 1) > level)
    return;
  const CcFields all = {floats, records, ints, uints, runs};
  const CcOut out = {hits, keys};
  ccBegin(&t, level, d, fields, pairs, directions);
  if (lid == 0) w.near = w.below = w.over = 0;
  ccNoFlags(&w.flags);
  barrier(CLK_LOCAL_MEM_FENCE);
  __global const uint* from = nearby + t.dir.nearby[level == 0];
  __global uint* next = nearby + t.dir.nearby[level == 1];
  __global uint *deep = aside + 2 * (size_t)t.dir.hits, *divided = deep + t.dir.room;
  const uint sources =
      level == CC_LEVELS - 1 ? t.own.brickCount : found[d * CC_LEVELS + (uint)level + 1u].nearby;
  uint asked = 0;
  for (uint chunk = 0; chunk < sources; chunk += CC_SOURCES * CC_GROUP) {
    uint2 run[CC_SOURCES];
    uint mine = 0;
    for (uint s = 0; s < CC_SOURCES; ++s) {
      run[s] = ccRunFrom(&t, chunk + CC_SOURCES * lid + s, sources, all, from);
      mine += run[s].y;
    }
    const uint upTo = ccSumUpTo(w.sums, mine);
    if (lid == CC_GROUP - 1) w.marks.all = upTo;
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint total = w.marks.all;
    asked += total;
    for (uint begin = 0; begin < total; begin += CC_WINDOW) {
      barrier(CLK_LOCAL_MEM_FENCE);
      ccList(&w, run, upTo - mine, begin);
      if (lid == 0) w.rounds = 1;
      barrier(CLK_LOCAL_MEM_FENCE);
      ccAskWindow(&t, all, &w, min((uint)CC_WINDOW, total - begin), next, deep, divided);
      ccTakeWhole(&t, all, &w, out);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  ccCountFlags(&w.flags, 1);
  const uint whole = w.flags.before[0], below = w.below, over = w.over;
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  if (whole + below + over <= t.dir.room) ccTakeDeep(&t, all, below, deep, whole, out);
  if (lid == 0) {
    const CcFound f = {whole, below, over, w.near, asked};
    found[d * CC_LEVELS + (uint)level] = f;
  }
}
