// One level of the search, for all pairs that need it: a group for each direction of a pair.
// Samples are looked up in windows. Results keep the samples' order: hits of whole samples, then
// samples below the band, then parts of samples over an edge, as in plugin/contact/lane_search.h.
// One sample in five is a hit, so this kernel lists those that may be and another computes hits
// (hits.cl). On an M16 thread a third of the samples lie where several planes meet; these wait
// until there are enough of them for all work-items.
//
// `shape`: the other body, if it is a plain solid instead of a field; a constant null in kernels of
// two clouds.

#define CC_SOURCES 4  // sources of samples of a work-item at a time
#define CC_AT_ONCE 4  // samples that a work-item reads at once

// The one buffer of all fields' numbers, as each of its types.
typedef struct {
  __global const float4* floats;
  __global const CcVoxel* records;
  __global const int* ints;
  __global const uint* uints;
  __global const uint2* runs;
} CcFields;

// The data that a group's work-items share.
typedef struct {
  CcDirection dir;
  CcField own, other;
  CcLimits limits;
  int level, side;
  int last;             // no finer level is searched
  float perCell, unit;  // [1/m] of a bin's cell; [m^2] of a sample's area
} CcTask;

// Local memory of a group for a window of samples.
typedef struct {
  uint samples[CC_WINDOW];
  uchar is[CC_WINDOW];         // result of ccLookUp() for each
  ushort many[CC_WINDOW];      // places in the window of samples whose records have several planes
  CcVoxel records[CC_WINDOW];  // of these
  uint sums[2 * CC_GROUP];
  CcMarks marks;
  uint manyCount;                 // in the window
  uint tried, near, below, over;  // so far
  uint rounds;                    // 2 if samples lie below the band or over an edge
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

// Whether finer samples that sample k stands for may touch; `d`: the deciding plane, depth in
// meters.
int ccNearBesideSample(__local const CcTask* t, CcFields all, __global const CcVoxel* planes,
                       uint k, CcVoxel record, const CcPlace* place, const CcDepth* d) {
  const uint at = t->own.clusters[t->level] + 2 * k;
  const float4 p = all.floats[at], q = all.floats[at + 1];
  const CcCluster cluster = {p.x, {p.y, p.z, p.w, q.x, q.y, q.z}};
  return ccNearByPlanes(&t->limits, t->dir.way.turnToOther, &cluster, record, planes, place->r,
                        d->depth, d->normal, t->other.voxel);
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

// A source of samples: on the coarsest level a brick that may touch, otherwise the cell of a sample
// of the coarser level.
uint2 ccRunFrom(__local const CcTask* t, uint i, uint sources, CcFields all,
                __global const CcShape* shape, __global const uint* nearby) {
  if (i >= sources) return (uint2)(0, 0);
  if (t->level == CC_LEVELS - 1) {
    const float4 b = all.floats[t->own.bricks + i];
    const float center[3] = {b.x, b.y, b.z};
    if (shape)
      return ccMayTouchShape(shape, center, b.w, t->own.voxel) ? all.runs[t->own.runs + i]
                                                               : (uint2)(0, 0);
    const CcBricks bricks = {t->other.nx, t->other.ny, t->other.nz};
    const int touches =
        ccBrickTouches(&t->dir.way.toOther, center, b.w, t->own.voxel / t->other.voxel, bricks,
                       all.ints + t->other.between);
    return touches ? all.runs[t->own.runs + i] : (uint2)(0, 0);
  }
  // The samples of a cell are consecutive. Only the first of them searches the cell.
  __global const uint* cells = all.uints + t->own.cells[t->level + 1];
  const uint cell = cells[nearby[i]];
  if (i > 0 && cells[nearby[i - 1]] == cell) return (uint2)(0, 0);
  return all.runs[t->own.finer[t->level + 1] + cell];
}

// Results of ccLookUp() for a sample.
#define CC_MAY_HIT 1u
#define CC_SEARCH_FINER 2u  // finer samples beside it may touch
#define CC_BELOW 4u         // below the band
#define CC_DIVIDED 8u       // over an edge
#define CC_MANY 16u         // not known yet: its record has several planes

// The result for a sample whose record has planes; `d` is that of the deciding plane [voxels].
// `alone`: constant, whether the coarsest level is the only one that is searched.
uint ccLookUpPlanes(__local const CcTask* t, CcFields all, __global const CcVoxel* planes, uint k,
                    const CcSample* s, CcVoxel record, const CcPlace* place, CcDepth d, int alone) {
  d.depth *= t->other.voxel;
  float other[3];
  ccTurnBack(t->dir.way.turnToOther, d.normal, other);
  const float facing = ccDot(s->n, other);
  const int kind = ccKindOf(&t->limits, record, d.depth, s->width);
  uint is = 0u;
  if (!alone && !t->last && ccNearBesideSample(t, all, planes, k, record, place, &d))
    is = CC_SEARCH_FINER;
  if (!alone && ccPlaneCount(record) > 1u && t->level < CC_LEVELS - 1 &&
      ccEdgeWithin(&t->limits, record, planes, place->r, d.depth, d.normal, facing, s->width,
                   t->other.voxel, t->own.voxel))
    return is | CC_DIVIDED;
  const int may = (kind & CC_WET) && ccMayHit(&t->limits, d.depth, facing, s->width);
  return is | (may ? CC_MAY_HIT : 0u);
}

// The result for a sample at `place`, where the other body has the given record.
uint ccLookUp(__local const CcTask* t, CcFields all, uint k, const CcSample* s,
              const CcPlace* place, CcVoxel record, int alone) {
  const uint count = ccPlaneCount(record);
  if (count > 1u) return CC_MANY;
  if (count == 1u)
    return ccLookUpPlanes(t, all, all.records, k, s, record, place,
                          ccPlaneDepth(record, place->r), alone);
  const int kind = ccKindOf(&t->limits, record, 0.0f, s->width);
  uint is = (kind & CC_NEARBY ? CC_SEARCH_FINER : 0u) | (kind & CC_DEEP ? CC_BELOW : 0u);
  if (!alone && !t->last && ccOutside(record)) {
    CcDepth d = ccPlaneDepth(record, place->r);
    d.depth *= t->other.voxel;
    if (ccNearBesideSample(t, all, all.records, k, record, place, &d)) is |= CC_SEARCH_FINER;
  }
  return is;
}

// ccVoxelDepth(), but it reads all planes at once.
CcDepth ccDepthAmong(CcVoxel v, __global const CcVoxel* planes, const float* x) {
  const uint count = ccPlaneCount(v);
  const int concave = ccConcave(v);
  CcVoxel all[CC_MAX_PLANES];
  for (uint i = 0; i < CC_MAX_PLANES; ++i)
    if (i < count) all[i] = planes[v.b + i];
  CcDepth best = ccPlaneDepth(all[0], x);
  for (uint i = 1; i < CC_MAX_PLANES; ++i) {
    if (i >= count) break;
    const CcDepth d = ccPlaneDepth(all[i], x);
    if (concave ? d.depth > best.depth : d.depth < best.depth) best = d;
  }
  return best;
}

uint ccLookUpMany(__local const CcTask* t, CcFields all, uint k, CcVoxel record, int alone) {
  const CcSample s = ccSampleOf(t, all, k);
  const CcPlace place = ccPlaceIn(t, s.x);
  __global const CcVoxel* planes = all.records + t->other.planes;
  return ccLookUpPlanes(t, all, planes, k, &s, record, &place,
                        ccDepthAmong(record, planes, place.r), alone);
}

// The result for a sample in a shape, whose surface counts as one plane.
uint ccLookUpInShape(__local const CcTask* t, CcFields all, __global const CcShape* shape, uint k,
                     const CcSample* s) {
  const CcDepth d = ccShapeDepth(shape, s->x);
  float other[3];
  ccTurnBack(t->dir.way.turnToOther, d.normal, other);
  uint is = 0u;
  // Of one plane neither the record's planes nor the place are read.
  const CcVoxel plane = ccShapeRecord(shape->solid.kind == CC_HALF_SPACE);
  const CcPlace nowhere = {0, 0, {0.0f, 0.0f, 0.0f}};
  if (!t->last && ccNearBesideSample(t, all, all.records, k, plane, &nowhere, &d))
    is = CC_SEARCH_FINER;
  if (t->level == 0 && ccShapeEdgeWithin(shape, s->x, s->n, s->width, t->own.voxel, &d))
    return is | CC_DIVIDED;
  const int may = (ccKindOf(&t->limits, plane, d.depth, s->width) & CC_WET) &&
                  ccMayHit(&t->limits, d.depth, ccDot(s->n, other), s->width);
  return is | (may ? CC_MAY_HIT : 0u);
}

void ccLookUpAllInShape(__local const CcTask* t, CcFields all, __global const CcShape* shape,
                        __local CcWindow* w, uint some) {
  for (uint k = get_local_id(0); k < some; k += CC_GROUP) {
    const CcSample s = ccSampleOf(t, all, w->samples[k]);
    w->is[k] = (uchar)ccLookUpInShape(t, all, shape, w->samples[k], &s);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Looks up the window's samples.
void ccLookUpAll(__local const CcTask* t, CcFields all, __local CcWindow* w, uint some,
                 int alone) {
  const uint lid = get_local_id(0);
  for (uint base = lid; base < some; base += CC_AT_ONCE * CC_GROUP) {
    CcSample s[CC_AT_ONCE];
    CcPlace place[CC_AT_ONCE];
    CcVoxel record[CC_AT_ONCE];
    for (uint i = 0; i < CC_AT_ONCE; ++i)
      s[i] = ccSampleOf(t, all, w->samples[min(base + i * CC_GROUP, some - 1u)]);
    for (uint i = 0; i < CC_AT_ONCE; ++i) place[i] = ccPlaceIn(t, s[i].x);
    int first[CC_AT_ONCE];
    for (uint i = 0; i < CC_AT_ONCE; ++i)
      first[i] = all.ints[t->other.firsts + (uint)place[i].brick];
    for (uint i = 0; i < CC_AT_ONCE; ++i)
      record[i] = all.records[t->other.records + (uint)(first[i] + place[i].cell)];
    for (uint i = 0; i < CC_AT_ONCE; ++i) {
      const uint k = base + i * CC_GROUP;
      if (k >= some) break;
      const uint is = ccLookUp(t, all, w->samples[k], &s[i], &place[i], record[i], alone);
      w->is[k] = (uchar)is;
      if (is == CC_MANY) {
        const uint at = atomic_inc(&w->manyCount);
        w->many[at] = (ushort)k;
        w->records[at] = record[i];
      }
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint count = w->manyCount;
  for (uint i = lid; i < count; i += CC_GROUP)
    w->is[w->many[i]] =
        (uchar)ccLookUpMany(t, all, w->samples[w->many[i]], w->records[i], alone);
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Where the numbers of samples go: those that may be hits, those below the band, those over an
// edge, and those beside which finer ones may touch.
typedef struct {
  __global uint *tried, *deep, *divided, *next;
} CcLists;

// Looks up the window's samples and lists their numbers.
void ccLookUpWindow(__local const CcTask* t, CcFields all, __global const CcShape* shape,
                    __local CcWindow* w, uint some, CcLists lists, int alone) {
  const uint lid = get_local_id(0), room = t->dir.room;
  if (shape)
    ccLookUpAllInShape(t, all, shape, w, some);
  else
    ccLookUpAll(t, all, w, some, alone);
  uint first = 0, second = 0;
  for (uint j = 0; j * CC_GROUP < some; ++j) {
    const uint k = j * CC_GROUP + lid;
    const uint is = k < some ? w->is[k] : 0u;
    first |= ((is & 1u) | (is & 2u) << 15) << j;
    second |= ((is >> 2 & 1u) | (is >> 2 & 2u) << 15) << j;
  }
  if (second) w->rounds = 2;
  for (uint n = 0; n < w->rounds; ++n) {
    const uint mine = n == 0 ? first : second;
    ccMark(&w->marks, w->sums, mine);
    const uint before = n == 0 ? w->tried : w->below, behind = n == 0 ? w->near : w->over;
    __global uint* one = n == 0 ? lists.tried : lists.deep;
    __global uint* two = n == 0 ? lists.next : lists.divided;
    const uint roomOfTwo = n == 0 ? 0xffffffffu : room;
    for (uint j = 0; j * CC_GROUP < some; ++j) {
      const uint sample = w->samples[j * CC_GROUP + lid];
      const uint at = before + ccMarked(&w->marks, 0, j), to = behind + ccMarked(&w->marks, 1, j);
      if (mine >> j & 1u && at < room) one[at] = sample;
      if (mine >> (16 + j) & 1u && to < roomOfTwo) two[to] = sample;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0) {
      if (n == 0) {
        w->tried += w->marks.all & 0xffffu;
        w->near += w->marks.all >> 16;
      } else {
        w->below += w->marks.all & 0xffffu;
        w->over += w->marks.all >> 16;
      }
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Lists the window's samples from this work-item's runs; `before` samples of others come first.
void ccList(__local CcWindow* w, const uint2* runs, uint before, uint begin) {
  for (uint s = 0; s < CC_SOURCES; ++s) {
    for (uint j = 0; j < runs[s].y; ++j) {
      const uint k = before + j - begin;
      if (k < CC_WINDOW) w->samples[k] = runs[s].x + j;
    }
    before += runs[s].y;
  }
}

// Sets the group's data for direction d. Where the other body is a shape, `other` is not used.
void ccBegin(__local CcTask* t, int level, int last, uint d, __global const CcField* fields,
             __global const CcPair* pairs) {
  if (get_local_id(0) == 0) {
    t->dir = pairs[d / 2].ways[d % 2];
    t->own = fields[t->dir.own];
    t->other = fields[t->dir.other];
    t->limits = ccLimitsOf(level, t->own.voxel);
    if (last) t->limits.nearby = t->limits.nearOutside = 0;
    t->level = level;
    t->last = last;
    t->side = (int)(d & 1u);
    t->perCell = (float)(1.0 / (pairs[d / 2].cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0)));
    t->unit = t->own.voxel * t->own.voxel;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// Searches the level of a direction. `alone` as for ccLookUpPlanes().
void ccSearchLevel(__local CcTask* t, __local CcWindow* w, CcFields all,
                   __global const CcShape* shape, uint d, __global CcFound* found,
                   __global uint* nearby, __global uint* aside, int level, int alone) {
  const uint lid = get_local_id(0);
  if (lid == 0) w->tried = w->near = w->below = w->over = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  __global const uint* from = nearby + t->dir.nearby[level == 0];
  __global uint* own = aside + 3 * (size_t)t->dir.hits;
  const CcLists lists = {own, own + t->dir.room, own + 2 * t->dir.room,
                         nearby + t->dir.nearby[level == 1]};
  const uint sources =
      level == CC_LEVELS - 1 ? t->own.brickCount : found[d * CC_LEVELS + (uint)level + 1u].nearby;
  uint lookups = 0;
  for (uint chunk = 0; chunk < sources; chunk += CC_SOURCES * CC_GROUP) {
    uint2 run[CC_SOURCES];
    uint mine = 0;
    for (uint s = 0; s < CC_SOURCES; ++s) {
      run[s] = ccRunFrom(t, chunk + CC_SOURCES * lid + s, sources, all, shape, from);
      mine += run[s].y;
    }
    const uint upTo = ccSumUpTo(w->sums, mine);
    if (lid == CC_GROUP - 1) w->marks.all = upTo;
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint total = w->marks.all;
    lookups += total;
    for (uint begin = 0; begin < total; begin += CC_WINDOW) {
      barrier(CLK_LOCAL_MEM_FENCE);
      ccList(w, run, upTo - mine, begin);
      if (lid == 0) {
        w->rounds = 1;
        w->manyCount = 0;
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      ccLookUpWindow(t, all, shape, w, min((uint)CC_WINDOW, total - begin), lists, alone);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (lid == 0) {
    const CcFound f = {w->tried, w->below, w->over, w->near, lookups};
    found[d * CC_LEVELS + (uint)level] = f;
  }
}

// `last`: no finer level is searched.
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSearch(
    int level, int last, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs,
    __global CcFound* found, __global uint* nearby, __global uint* aside,
    __global CcResults* results) {
  __local CcTask t;
  __local CcWindow w;
  const uint lid = get_local_id(0), d = get_group_id(0);
  if (level == CC_LEVELS - 1 && d == 0 && lid < CC_COUNTERS) results->counters[lid] = 0u;
  if (level < CC_LEVELS - 1 &&
      ccLastLevel(&pairs[d / 2], found + (d & ~1u) * CC_LEVELS, level + 1) > level)
    return;
  const CcFields all = {floats, records, ints, uints, runs};
  ccBegin(&t, level, last, d, fields, pairs);
  ccSearchLevel(&t, &w, all, 0, d, found, nearby, aside, level, 0);
}

// ccSearch() of the coarsest level alone, which divides no samples and looks for no finer ones.
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSearchCoarsest(
    __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs,
    __global CcFound* found, __global uint* nearby, __global uint* aside,
    __global CcResults* results) {
  __local CcTask t;
  __local CcWindow w;
  const uint lid = get_local_id(0), d = get_group_id(0);
  if (d == 0 && lid < CC_COUNTERS) results->counters[lid] = 0u;
  const CcFields all = {floats, records, ints, uints, runs};
  ccBegin(&t, CC_LEVELS - 1, 1, d, fields, pairs);
  ccSearchLevel(&t, &w, all, 0, d, found, nearby, aside, CC_LEVELS - 1, 1);
}
