// Hits of one level of the search, in all directions that reached it: of the samples that the
// search lists, in their order.

// Where hits go.
typedef struct {
  __global float4* hits;
  __global ulong* keys;
} CcOut;

// Writes the i-th hit of the direction.
void ccPut(__local const CcTask* t, CcOut out, uint i, const CcHit* h, float area, float depth) {
  const uint room = t->dir.room;
  __global float4* hits = out.hits + 4 * (size_t)t->dir.hits + i;
  hits[0] = (float4)(h->position[0], h->position[1], h->position[2], depth);
  hits[room] = (float4)(h->own[0], h->own[1], h->own[2], h->facing);
  hits[2 * (size_t)room] = (float4)(h->other[0], h->other[1], h->other[2], area);
  hits[3 * (size_t)room] = (float4)(h->wet.share, h->wet.depth1, h->wet.depth2, h->wet.depth3);
  const CcBinOfHit b = ccBinOf(h->position, h->own, h->other, h->facing, depth, t->side, t->perCell);
  out.keys[t->dir.hits + i] = ccBinKey(b.x, b.y, b.z, b.direction);
}

CcHit ccHitFrom(__local const CcTask* t, const float* x, const float* n, const CcDepth* d,
                float width) {
  return ccHitIn(&t->dir.way.toFrame, t->dir.way.frameFromOwn, t->dir.way.frameFromOther, x, n,
                 d->normal, d->depth, t->limits.halfWidth * width);
}

// Limits a hit to what of its sample is in the other body (wet_part.h).
void ccLimitHit(__local const CcTask* t, CcFields all, const float* x, const float* n,
                const CcDepth* d, float width, CcHit* h) {
  CcWetEnd end;
  if (!(h->wet.depth1 > 0.0f) || h->wet.share >= 1.0f ||
      !ccWetEndOf(&t->limits, t->dir.way.turnToOther, x, n, width, d->normal, d->depth, &end))
    return;
  const CcPlace place = ccPlaceIn(t, end.at);
  const CcVoxel record = ccRecordAt(t, all, &place);
  float depth = ccEndBelow(&end, record);
  if (ccPlaneCount(record) > 0u)
    depth = ccVoxelDepth(record, all.records + t->other.planes, place.r).depth * t->other.voxel;
  const float out = ccLimitWet(&end, t->limits.perVoxel, depth, h->wet.share, &h->facing,
                               &h->wet.depth1, &h->wet.depth2, &h->wet.depth3);
  for (int i = 0; i < 3; ++i) h->position[i] += out * h->own[i];
}

// The depth [m] at a sample.
CcDepth ccDepthAt(__local const CcTask* t, CcFields all, const CcSample* s) {
  const CcPlace place = ccPlaceIn(t, s->x);
  const CcVoxel record = ccRecordAt(t, all, &place);
  CcDepth d = ccPlaneCount(record) == 1u
                  ? ccPlaneDepth(record, place.r)
                  : ccDepthAmong(record, all.records + t->other.planes, place.r);
  d.depth *= t->other.voxel;
  return d;
}

// Writes the hits among the `count` samples in `tried`; returns their number. `shape`: as in
// search.cl.
uint ccTakeWhole(__local const CcTask* t, CcFields all, __global const CcShape* shape,
                 __local CcFlags* flags, uint count, __global const uint* tried, CcOut out) {
  ccNoFlags(flags);
  for (uint base = 0; base < count; base += CC_GROUP) {
    const uint k = base + get_local_id(0);
    CcHit h;
    float area = 0.0f, depth = 0.0f;
    uint is = 0;
    if (k < count) {
      const CcSample s = ccSampleOf(t, all, tried[k]);
      const CcDepth d = shape ? ccShapeDepth(shape, s.x) : ccDepthAt(t, all, &s);
      h = ccHitFrom(t, s.x, s.n, &d, s.width);
      is = h.wet.depth1 > 0.0f;
      if (!shape) ccLimitHit(t, all, s.x, s.n, &d, s.width, &h);
      area = s.area * t->unit;
      depth = d.depth;
    }
    ccFlag(flags, 1, is);
    if (is) ccPut(t, out, ccFlagged(flags, 0), &h, area, depth);
  }
  ccCountFlags(flags, 1);
  return flags->before[0];
}

// Writes samples below the band as hits, from number `begin` on.
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

// The depth [m] at a part of a sample over an edge, by the record of the sample's middle.
CcDepth ccDepthOfPart(__local const CcTask* t, CcFields all, const CcSample* s,
                      const float* aside) {
  const CcPlace place = ccPlaceIn(t, s->x);
  float moved[3], r[3];
  ccTurn(t->dir.way.toOther.turn, aside, moved);
  for (int i = 0; i < 3; ++i) r[i] = place.r[i] + moved[i];
  CcDepth d = ccVoxelDepth(ccRecordAt(t, all, &place), all.records + t->other.planes, r);
  d.depth *= t->other.voxel;
  return d;
}

// Makes a hit of one part of a sample over an edge; returns whether it is one.
uint ccTakePart(__local const CcTask* t, CcFields all, __global const CcShape* shape, uint sample,
                int part, CcHit* h, float* area, float* depth) {
  const CcSample s = ccSampleOf(t, all, sample);
  const int along = ccPartsAlong(s.width);
  const float width = s.width / (float)along;
  float t1[3], t2[3], aside[3], x[3];
  ccTangents(s.n, t1, t2);
  ccPartAside(width, along, part, t1, t2, aside);
  for (int i = 0; i < 3; ++i) x[i] = s.x[i] + aside[i];
  const CcDepth d = shape ? ccShapeDepth(shape, x) : ccDepthOfPart(t, all, &s, aside);
  *h = ccHitFrom(t, x, s.n, &d, width);
  *area = s.area / (float)(along * along) * t->unit;
  *depth = d.depth;
  const uint is = h->wet.depth1 > 0.0f;
  if (!shape) ccLimitHit(t, all, x, s.n, &d, width, h);
  return is;
}

// Writes the parts of samples over an edge as hits, from number `begin` on. Returns their number.
uint ccTakeParts(__local const CcTask* t, CcFields all, __global const CcShape* shape,
                 __local uint* ends, __local CcFlags* flags, uint count,
                 __global const uint* divided, uint begin, CcOut out) {
  const uint lid = get_local_id(0);
  ccNoFlags(flags);
  for (uint chunk = 0; chunk < count; chunk += CC_GROUP) {
    uint parts = 0;
    if (chunk + lid < count) {
      const int along = ccPartsAlong(ccSampleOf(t, all, divided[chunk + lid]).width);
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
      uint is = 0;
      if (k < total) {
        const uint run = ccRunOf(ends, CC_GROUP, k);
        const uint part = k - (run > 0 ? ends[run - 1] : 0u);
        is = ccTakePart(t, all, shape, divided[chunk + run], (int)part, &h, &area, &depth);
      }
      ccFlag(flags, 1, is);
      const uint at = is ? begin + ccFlagged(flags, 0) : t->dir.room;
      if (at < t->dir.room) ccPut(t, out, at, &h, area, depth);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  ccCountFlags(flags, 1);
  return flags->before[0];
}

// Replaces the numbers of listed samples in `found` by those of hits. If there are more listed
// samples than room, `found` stays.
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccHits(
    int level, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs,
    __global CcFound* found, __global float4* hits,
    __global ulong* keys, __global const uint* aside) {
  __local CcTask t;
  __local CcFlags flags;
  __local uint ends[2 * CC_GROUP];
  const uint d = get_group_id(0);
  if (level < CC_LEVELS - 1 &&
      ccLastLevel(&pairs[d / 2], found + (d & ~1u) * CC_LEVELS, level + 1) > level)
    return;
  const CcFound f = found[d * CC_LEVELS + (uint)level];
  const uint listed = f.whole + f.deep + f.parts;
  if (listed == 0u || listed > pairs[d / 2].ways[d % 2].room) return;
  ccBegin(&t, level, 0, d, fields, pairs);
  const CcFields all = {floats, records, ints, uints, runs};
  const CcOut out = {hits, keys};
  __global const uint* tried = aside + 3 * (size_t)t.dir.hits;
  const uint whole = ccTakeWhole(&t, all, 0, &flags, f.whole, tried, out);
  ccTakeDeep(&t, all, f.deep, tried + t.dir.room, whole, out);
  uint parts = 0;
  if (f.parts > 0u)
    parts = ccTakeParts(&t, all, 0, ends, &flags, f.parts, tried + 2 * t.dir.room, whole + f.deep,
                        out);
  if (get_local_id(0) == 0) {
    found[d * CC_LEVELS + (uint)level].whole = whole;
    found[d * CC_LEVELS + (uint)level].parts = parts;
  }
}

// ccHits() of the coarsest level, which divides no samples.
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccHitsCoarsest(
    __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs, __global CcFound* found,
    __global float4* hits, __global ulong* keys, __global const uint* aside) {
  __local CcTask t;
  __local CcFlags flags;
  const uint d = get_group_id(0);
  __global CcFound* own = &found[d * CC_LEVELS + CC_LEVELS - 1u];
  const CcFound f = *own;
  if (f.whole + f.deep == 0u || f.whole + f.deep > pairs[d / 2].ways[d % 2].room) return;
  ccBegin(&t, CC_LEVELS - 1, 0, d, fields, pairs);
  const CcFields all = {floats, records, ints, uints, runs};
  const CcOut out = {hits, keys};
  __global const uint* tried = aside + 3 * (size_t)t.dir.hits;
  const uint whole = ccTakeWhole(&t, all, 0, &flags, f.whole, tried, out);
  ccTakeDeep(&t, all, f.deep, tried + t.dir.room, whole, out);
  if (get_local_id(0) == 0) own->whole = whole;
}
