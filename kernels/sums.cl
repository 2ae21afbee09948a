// Sums of bins: four work-items share a bin, each its lane of the vectors (hit_sums.h). As many
// groups as the device likes take bins in turn.

#define CC_QUADS (CC_GROUP / 4)

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSums(
    __global const CcPair* pairs, __global const CcDirection* directions,
    __global const CcFound* found, __global const CcAnswer* answers, __global const float4* hits,
    __global const uint* order, __global const CcBin* bins, __global const uint* counters,
    uint binRoom, __global CcSums* sums) {
  __local CcAdded added[CC_QUADS];
  const int lane = (int)get_local_id(0) & 3;
  const uint quad = get_local_id(0) / 4;
  const uint all = min(counters[CC_BINS], binRoom);
  for (uint base = get_group_id(0) * CC_QUADS; base < all; base += get_num_groups(0) * CC_QUADS) {
    const uint b = base + quad;
    const int is = b < all;
    CcBin bin = {{0, 0, 0}, 0, 0, 0};
    CcHits h = {{0, 0}, {0, 0}, {{0, 0}, {0, 0}}};
    double cell = 1.0, origin[3] = {0.0, 0.0, 0.0}, deep = 0.0;
    __global CcSums* to = sums + b;
    if (is) {
      bin = bins[b];
      const CcAnswer answer = answers[bin.pair];
      h = ccHitsOf(answer.level, found, directions, bin.pair);
      cell = pairs[bin.pair].cell * (answer.level == CC_LEVELS - 1 ? 2.0 : 1.0);
      for (int i = 0; i < 3; ++i) origin[i] = (bin.cell[i] + 0.5) * cell;
      __global double* numbers = (__global double*)to;
      for (uint i = (uint)lane; i < sizeof(CcSums) / 8; i += 4) numbers[i] = 0.0;
    }
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (is && lane == 0) {
      for (int i = 0; i < 3; ++i) to->origin[i] = origin[i];
      to->deepest = -1e300;
    }
    uint i = bin.begin;
    // The next hit is on its way while one is added up.
    uint at = bin.begin < bin.end ? order[ccHitAt(&h, i)] : 0u;
    float4 p = hits[4 * (size_t)at], q = hits[4 * (size_t)at + 1], r = hits[4 * (size_t)at + 2],
           s = hits[4 * (size_t)at + 3];
    for (uint side = 0; side < 2; ++side) {
      CcAdding adding = ccNothingAdded();
      const uint begin = i;
      for (; i < bin.end; ++i) {
        const uint number = at - h.first[side];
        if (number >= h.count[side]) break;
        const uint next = i + 1 < bin.end ? order[ccHitAt(&h, i + 1)] : at;
        const float4 pNext = hits[4 * (size_t)next], qNext = hits[4 * (size_t)next + 1],
                     rNext = hits[4 * (size_t)next + 2], sNext = hits[4 * (size_t)next + 3];
        const float x[3] = {p.x, p.y, p.z}, own[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
        const CcWet wet = {s.x, 0.0f, s.y, s.z, s.w};
        ccAddHit(&adding, x, own, other, r.w, &wet, p.w, ccGate(q.w), origin, 1.0 / cell, 0, lane);
        if (number >= h.deep[side][0] && number < h.deep[side][1]) deep += (double)r.w * s.y;
        at = next;
        p = pNext;
        q = qNext;
        r = rNext;
        s = sNext;
      }
      const CcFour* fours = &adding.area;
      __local double* rows = &added[quad].area[0];
      for (int k = 0; k < CC_ADDED_FOURS; ++k) rows[4 * k + lane] = fours[k];
      if (lane == 0) {
        added[quad].middle = adding.middle;
        added[quad].deepest = adding.deepest;
      }
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      if (is && i > begin)
        ccGive(to, &added[quad], (int)(i - begin), 0, (int)side, cell, lane);
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (is && lane == 0) to->deep = deep;
  }
}
