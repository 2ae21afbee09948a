// Parts of samples over an edge: behind a level of the search that takes samples in parts, for
// directions that have some. A kernel of its own, so that the search stays small.

// The part-th part of a sample over an edge.
uint ccTakePart(__local const CcTask* t, CcFields all, uint sample, int part, CcHit* h, float* area,
                float* depth) {
  const CcSample s = ccSampleOf(t, all, sample);
  const int along = ccPartsAlong(s.width);
  const float width = s.width / (float)along;
  float t1[3], t2[3], aside[3], moved[3], x[3], r[3];
  ccTangents(s.n, t1, t2);
  ccPartAside(width, along, part, t1, t2, aside);
  ccTurn(t->dir.way.toOther.turn, aside, moved);
  const CcPlace place = ccPlaceIn(t, s.x);
  for (int i = 0; i < 3; ++i) {
    x[i] = s.x[i] + aside[i];
    r[i] = place.r[i] + moved[i];
  }
  CcDepth d = ccVoxelDepth(ccRecordAt(t, all, &place), all.records + t->other.planes, r);
  d.depth *= t->other.voxel;
  *h = ccHitFrom(t, x, s.n, &d, width);
  *area = s.area / (float)(along * along) * t->unit;
  *depth = d.depth;
  return h->wet.depth1 > 0.0f;
}

// Parts of samples over an edge, by the samples' numbers; hits from the one numbered `begin`.
// Returns how many there are.
uint ccTakeParts(__local const CcTask* t, CcFields all, __local uint* ends, __local CcFlags* flags,
                 uint count, __global const uint* divided, uint begin, CcOut out) {
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
        is = ccTakePart(t, all, divided[chunk + run], (int)part, &h, &area, &depth);
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

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccParts(
    int level, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs,
    __global const CcDirection* directions, __global CcFound* found, __global float4* hits,
    __global ulong* keys, __global const uint* aside) {
  __local CcTask t;
  __local CcFlags flags;
  __local uint ends[2 * CC_GROUP];
  const uint d = get_group_id(0);
  if (ccLastLevel(&pairs[d / 2], found + (d & ~1u) * CC_LEVELS, level + 1) > level) return;
  const CcFound f = found[d * CC_LEVELS + (uint)level];
  if (f.parts == 0 || f.whole + f.deep + f.parts > directions[d].room) return;
  ccBegin(&t, level, d, fields, pairs, directions);
  const CcFields all = {floats, records, ints, uints, runs};
  const CcOut out = {hits, keys};
  const uint parts =
      ccTakeParts(&t, all, ends, &flags, f.parts, aside + 2 * (size_t)t.dir.hits + t.dir.room,
                  f.whole + f.deep, out);
  if (get_local_id(0) == 0) found[d * CC_LEVELS + (uint)level].parts = parts;
}
