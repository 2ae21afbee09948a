// Pairs of a cloud and a plain solid: a group for each, which looks the cloud's samples up as those
// of two clouds are (search.cl, hits.cl). The solid has no samples. The batch's pairs from `first`
// on are such pairs, and have a CcShape each.

// Sets the group's data; returns the number of the direction of the cloud's samples.
uint ccBeginShape(__local CcTask* t, int level, int last, uint first,
                  __global const CcField* fields, __global const CcPair* pairs) {
  const uint p = first + get_group_id(0), d = 2 * p + (uint)pairs[p].terms.sampled;
  ccBegin(t, level, last, d, fields, pairs);
  return d;
}

// Whether a coarser level of a pair is fine enough.
int ccIsFineEnough(__global const CcPair* pair, __global const CcFound* found, int level) {
  return level < CC_LEVELS - 1 && ccLastLevel(pair, found, level + 1) > level;
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSearchShapes(
    int level, int last, uint first, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs, __global const CcShape* shapes,
    __global CcFound* found, __global uint* nearby, __global uint* aside,
    __global CcResults* results) {
  __local CcTask t;
  __local CcWindow w;
  const uint lid = get_local_id(0), p = first + get_group_id(0);
  if (level == CC_LEVELS - 1 && p == 0 && lid < CC_COUNTERS) results->counters[lid] = 0u;
  if (ccIsFineEnough(&pairs[p], found + 2 * p * CC_LEVELS, level)) return;
  const CcFields all = {floats, records, ints, uints, runs};
  const uint d = ccBeginShape(&t, level, last, first, fields, pairs);
  if (lid == 0) {
    const CcFound none = {0u, 0u, 0u, 0u, 0u};
    found[(d ^ 1u) * CC_LEVELS + (uint)level] = none;
  }
  ccSearchLevel(&t, &w, all, &shapes[get_group_id(0)], d, found, nearby, aside, level, 0);
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccHitsInShapes(
    int level, uint first, __global const CcField* fields, __global const float4* floats,
    __global const CcVoxel* records, __global const int* ints, __global const uint* uints,
    __global const uint2* runs, __global const CcPair* pairs, __global const CcShape* shapes,
    __global CcFound* found, __global float4* hits, __global ulong* keys,
    __global const uint* aside) {
  __local CcTask t;
  __local CcFlags flags;
  __local uint ends[2 * CC_GROUP];
  const uint p = first + get_group_id(0), d = 2 * p + (uint)pairs[p].terms.sampled;
  if (ccIsFineEnough(&pairs[p], found + 2 * p * CC_LEVELS, level)) return;
  __global CcFound* own = &found[d * CC_LEVELS + (uint)level];
  const CcFound f = *own;
  const uint listed = f.whole + f.parts;
  if (listed == 0u || listed > pairs[p].ways[d % 2].room) return;
  ccBeginShape(&t, level, 0, first, fields, pairs);
  __global const CcShape* shape = &shapes[get_group_id(0)];
  const CcFields all = {floats, records, ints, uints, runs};
  const CcOut out = {hits, keys};
  __global const uint* tried = aside + 3 * (size_t)t.dir.hits;
  const uint whole = ccTakeWhole(&t, all, shape, &flags, f.whole, tried, out);
  uint parts = 0;
  if (f.parts > 0u)
    parts =
        ccTakeParts(&t, all, shape, ends, &flags, f.parts, tried + 2 * t.dir.room, whole, out);
  if (get_local_id(0) == 0) {
    own->whole = whole;
    own->parts = parts;
  }
}
