// A level of the search, of all pairs that want it: a group for each direction of a pair. Samples
// are taken a group at a time in their order, and what is found keeps it: hits of whole samples,
// then of those below the band, then of parts of samples over an edge (plugin/contact/lane_search.h).

// All fields' numbers: one buffer, seen as each of its types.
typedef struct {
  __global const float4* floats;
  __global const CcVoxel* records;
  __global const int* ints;
  __global const uint* uints;
  __global const uint2* runs;
} CcFields;

typedef struct {
  float x[3], n[3], width, area;
} CcSample;

CcSample ccSampleOf(const CcField* f, CcFields all, int level, uint k) {
  const float4 p = all.floats[f->samples[level] + k],
               q = all.floats[f->samples[level] + f->counts[level] + k];
  CcSample s;
  s.x[0] = p.x;
  s.x[1] = p.y;
  s.x[2] = p.z;
  s.width = p.w;
  s.n[0] = q.x;
  s.n[1] = q.y;
  s.n[2] = q.z;
  s.area = q.w;
  return s;
}

CcPlace ccPlaceIn(const CcField* f, const CcMap* map, const float* x) {
  float at[3];
  ccApply(map, x, at);
  const CcBricks bricks = {f->nx, f->ny, f->nz};
  return ccPlaceOf(bricks, at);
}

CcVoxel ccRecordAt(const CcField* f, CcFields all, CcPlace place) {
  return all.records[f->records + (uint)(all.ints[f->firsts + place.brick] + place.cell)];
}

void ccPut(__global float4* hits, uint i, const CcHit* h, float area, float depth) {
  hits[4 * i] = (float4)(h->position[0], h->position[1], h->position[2], depth);
  hits[4 * i + 1] = (float4)(h->own[0], h->own[1], h->own[2], h->facing);
  hits[4 * i + 2] = (float4)(h->other[0], h->other[1], h->other[2], area);
  hits[4 * i + 3] = (float4)(h->wet.share, h->wet.depth1, h->wet.depth2, h->wet.depth3);
}

// A source of samples: of the coarsest level a brick that may touch, else a sample's cell.
uint2 ccRunFrom(int level, uint i, uint sources, const CcDirection* dir, const CcField* own,
                const CcField* other, CcFields all, __global const uint* nearby) {
  if (i >= sources) return (uint2)(0, 0);
  if (level == CC_LEVELS - 1) {
    const float4 b = all.floats[own->bricks + i];
    const float center[3] = {b.x, b.y, b.z};
    const CcBricks bricks = {other->nx, other->ny, other->nz};
    const int touches = ccBrickTouches(&dir->way.toOther, center, b.w, own->voxel / other->voxel,
                                       bricks, all.ints + other->between);
    return touches ? all.runs[own->runs + i] : (uint2)(0, 0);
  }
  // A cell's samples lie side by side: it is looked into once, for the first of them.
  __global const uint* cells = all.uints + own->cells[level + 1];
  const uint cell = cells[nearby[i]];
  if (i > 0 && cells[nearby[i - 1]] == cell) return (uint2)(0, 0);
  return all.runs[own->finer[level + 1] + cell];
}

typedef struct {
  CcSample sample;
  CcPlace place;
  CcVoxel record;
  CcDepth depth;  // [m]
  int kind, divided;
} CcLooked;

CcLooked ccLookUp(int level, uint k, const CcDirection* dir, const CcField* own,
                  const CcField* other, const CcLimits* limits, CcFields all) {
  CcLooked l;
  l.sample = ccSampleOf(own, all, level, k);
  l.place = ccPlaceIn(other, &dir->way.toOther, l.sample.x);
  l.record = ccRecordAt(other, all, l.place);
  const uint count = ccPlaneCount(l.record);
  __global const CcVoxel* planes = all.records + other->planes;
  l.divided = 0;
  l.depth.depth = 0.0f;
  l.depth.normal[0] = l.depth.normal[1] = l.depth.normal[2] = 0.0f;
  if (count > 0u) {
    l.depth = ccVoxelDepth(l.record, planes, l.place.r);
    l.depth.depth *= other->voxel;
  }
  float turned[3];
  ccTurn(dir->way.turnToOther, l.sample.n, turned);
  l.kind = ccKindOf(limits, l.record, l.depth.depth, turned, l.depth.normal, l.sample.width);
  if (count > 1u && level < CC_LEVELS - 1)
    l.divided = ccEdgeWithin(limits, l.record, planes, l.place.r, l.depth.depth, l.depth.normal,
                             l.sample.width, other->voxel, own->voxel);
  return l;
}

CcHit ccHitFrom(const CcDirection* dir, const CcLimits* limits, const float* x, const float* n,
                const CcDepth* d, float width) {
  return ccHitIn(&dir->way.toFrame, dir->way.frameFromOwn, dir->way.frameFromOther, x, n,
                 d->normal, d->depth, limits->halfWidth * width);
}

// Samples below the band, by their numbers.
void ccTakeDeep(int level, uint count, __global const uint* deep, const CcDirection* dir,
                const CcField* own, const CcField* other, const CcLimits* limits, CcFields all,
                __global float4* hits, uint room) {
  for (uint i = get_local_id(0); i < count && i < room; i += CC_GROUP) {
    const CcSample s = ccSampleOf(own, all, level, deep[i]);
    const CcPlace place = ccPlaceIn(other, &dir->way.toOther, s.x);
    const float depth =
        ccDepthBelow(all.ints[other->distance + (uint)place.brick], other->voxel);
    float at[3], normal[3], back[3];
    ccApply(&dir->way.toFrame, s.x, at);
    ccTurn(dir->way.frameFromOwn, s.n, normal);
    for (int k = 0; k < 3; ++k) back[k] = -normal[k];
    const CcHit h = ccHitOf(at, normal, back, depth, limits->halfWidth * s.width);
    ccPut(hits, i, &h, s.area * own->voxel * own->voxel, depth);
  }
}

// Parts of samples over an edge, by the samples' numbers; returns how many are hits.
uint ccTakeParts(int level, uint count, __global const uint* divided, const CcDirection* dir,
                 const CcField* own, const CcField* other, const CcLimits* limits, CcFields all,
                 __global float4* hits, uint room, __local uint* ends, __local uint* flags) {
  const uint lid = get_local_id(0);
  const float unit = own->voxel * own->voxel;
  uint found = 0;
  for (uint chunk = 0; chunk < count; chunk += CC_GROUP) {
    uint parts = 0;
    if (chunk + lid < count) {
      const float width = ccSampleOf(own, all, level, divided[chunk + lid]).width;
      const int along = ccPartsAlong(width);
      parts = (uint)(along * along);
    }
    const uint upTo = ccSumUpTo(ends, parts);
    barrier(CLK_LOCAL_MEM_FENCE);
    ends[lid] = upTo;
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint total = ends[CC_GROUP - 1];
    for (uint base = 0; base < total; base += CC_GROUP) {
      const uint k = base + lid;
      CcHit h;
      float area = 0.0f, depth = 0.0f;
      int is = 0;
      if (k < total) {
        const uint run = ccRunOf(ends, CC_GROUP, k);
        const uint part = k - (run > 0 ? ends[run - 1] : 0u);
        const CcSample s = ccSampleOf(own, all, level, divided[chunk + run]);
        const int along = ccPartsAlong(s.width);
        const float width = s.width / (float)along;
        float t1[3], t2[3], aside[3], moved[3], x[3], r[3];
        ccTangents(s.n, t1, t2);
        ccPartAside(width, along, (int)part, t1, t2, aside);
        ccTurn(dir->way.toOther.turn, aside, moved);
        const CcPlace place = ccPlaceIn(other, &dir->way.toOther, s.x);
        for (int i = 0; i < 3; ++i) {
          x[i] = s.x[i] + aside[i];
          r[i] = place.r[i] + moved[i];
        }
        CcDepth d = ccVoxelDepth(ccRecordAt(other, all, place), all.records + other->planes, r);
        d.depth *= other->voxel;
        h = ccHitFrom(dir, limits, x, s.n, &d, width);
        is = h.wet.depth1 > 0.0f;
        area = s.area / (float)(along * along) * unit;
        depth = d.depth;
      }
      ccFlag(flags, 1, is);
      const uint at = found + ccFlagged(flags, 0, lid);
      if (is && at < room) ccPut(hits, at, &h, area, depth);
      found += ccFlagged(flags, 0, CC_GROUP);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  return found;
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSearch(
    int level, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs,
    __global const CcDirection* directions, __global CcFound* found, __global uint* nearby,
    __global float4* hits, __global uint* aside) {
  __local uint ends[2 * CC_GROUP], firsts[CC_GROUP], flags[4 * CC_WORDS];
  const uint lid = get_local_id(0), d = get_group_id(0);
  const CcPair pair = pairs[d / 2];
  if (level < CC_LEVELS - 1 && ccLastLevel(&pair, found + (d & ~1u) * CC_LEVELS) > level) return;
  const CcFields all = {floats, records, ints, uints, runs};
  // At hand for all: a copy of its own would take half of each work-item's registers.
  __local CcDirection shared;
  __local CcField sharedOwn, sharedOther;
  if (lid == 0) {
    shared = directions[d];
    sharedOwn = fields[shared.own];
    sharedOther = fields[shared.other];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  const CcDirection dir = shared;
  const CcField own = sharedOwn, other = sharedOther;
  const CcLimits limits = ccLimitsOf(level, own.voxel, pair.margin);
  __global const uint* from = nearby + dir.nearby[level == 0];
  __global uint* next = nearby + dir.nearby[level == 1];
  __global float4* out = hits + 4 * (size_t)dir.hits;
  __global uint *deep = aside + 2 * (size_t)dir.hits, *divided = deep + dir.room;
  const uint sources = level == CC_LEVELS - 1 ? own.brickCount
                                              : found[d * CC_LEVELS + (uint)level + 1u].nearby;
  const float unit = own.voxel * own.voxel;
  uint whole = 0, below = 0, over = 0, near = 0, asked = 0;
  for (uint chunk = 0; chunk < sources; chunk += CC_GROUP) {
    const CcDirection dirHere = shared;
    const CcField ownHere = sharedOwn, otherHere = sharedOther;
    const uint2 run =
        ccRunFrom(level, chunk + lid, sources, &dirHere, &ownHere, &otherHere, all, from);
    const uint upTo = ccSumUpTo(ends, run.y);
    barrier(CLK_LOCAL_MEM_FENCE);
    ends[lid] = upTo;
    firsts[lid] = run.x + run.y - upTo;
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint total = ends[CC_GROUP - 1];
    asked += total;
    for (uint base = 0; base < total; base += CC_GROUP) {
      const uint k = base + lid;
      uint sample = 0;
      CcHit h;
      float area = 0.0f, depth = 0.0f;
      int is = 0;
      if (k < total) {
        const CcDirection dirHere = shared;
        const CcField ownHere = sharedOwn, otherHere = sharedOther;
        sample = firsts[ccRunOf(ends, CC_GROUP, k)] + k;
        const CcLooked l = ccLookUp(level, sample, &dirHere, &ownHere, &otherHere, &limits, all);
        int wet = 0;
        if ((l.kind & CC_WET) && !l.divided) {
          h = ccHitFrom(&dirHere, &limits, l.sample.x, l.sample.n, &l.depth, l.sample.width);
          wet = h.wet.depth1 > 0.0f;
        }
        area = l.sample.area * unit;
        depth = l.depth.depth;
        is = wet | ((l.kind & CC_DEEP) ? 2 : 0) | (l.divided ? 4 : 0) |
             ((l.kind & CC_NEARBY) ? 8 : 0);
      }
      ccFlag(flags, 4, is);
      const uint w = whole + ccFlagged(flags, 0, lid), b = below + ccFlagged(flags, 1, lid),
                 o = over + ccFlagged(flags, 2, lid), n = near + ccFlagged(flags, 3, lid);
      if ((is & 1) && w < dir.room) ccPut(out, w, &h, area, depth);
      if ((is & 2) && b < dir.room) deep[b] = sample;
      if ((is & 4) && o < dir.room) divided[o] = sample;
      if (is & 8) next[n] = sample;
      whole += ccFlagged(flags, 0, CC_GROUP);
      below += ccFlagged(flags, 1, CC_GROUP);
      over += ccFlagged(flags, 2, CC_GROUP);
      near += ccFlagged(flags, 3, CC_GROUP);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  uint parts = over;  // where there is no room, at least as many
  if (whole + below + over <= dir.room) {
    ccTakeDeep(level, below, deep, &dir, &own, &other, &limits, all, out + 4 * (size_t)whole,
               dir.room - whole);
    const uint taken = whole + below;
    parts = ccTakeParts(level, over, divided, &dir, &own, &other, &limits, all,
                        out + 4 * (size_t)taken, dir.room - taken, ends, flags);
  }
  if (lid == 0) {
    const CcFound f = {whole, below, parts, near, asked};
    found[d * CC_LEVELS + (uint)level] = f;
  }
}
