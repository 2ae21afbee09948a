// Groups hits into bins, one group for each pair. Bins are numbered in the order of their first
// hits, and each bin's hits are listed in order, so that sums over them equal those of the CPU.

#define CC_SLOTS (2 * CC_MOST_BINS)
#define CC_EMPTY 0x7fffffff
#define CC_TEAMS (CC_GROUP / CC_TEAM)  // as much room as 2 * CC_SLOTS

// The hits of a pair: those of the first direction, then those of the second.
typedef struct {
  uint first[2], room[2], count[2], deep[2][2];
} CcHits;

// The number of the pair's i-th hit among all pairs' hits.
uint ccHitAt(const CcHits* h, uint i) {
  return i < h->count[0] ? h->first[0] + i : h->first[1] + i - h->count[0];
}

CcHits ccHitsOf(int level, __global const CcFound* found, __global const CcPair* pairs,
                uint pair) {
  CcHits h;
  for (uint d = 0; d < 2; ++d) {
    const CcFound f = found[(2 * pair + d) * CC_LEVELS + (uint)level];
    h.first[d] = pairs[pair].ways[d].hits;
    h.room[d] = pairs[pair].ways[d].room;
    h.count[d] = f.whole + f.deep + f.parts;
    h.deep[d][0] = f.whole;
    h.deep[d][1] = f.whole + f.deep;
  }
  return h;
}

CcBinOfHit ccBinAt(const CcHits* h, __global const float4* hits, uint i, float perCell) {
  const int side = i < h->count[0] ? 0 : 1;
  const size_t room = h->room[side];
  __global const float4* at =
      hits + 4 * (size_t)h->first[side] + (i - (side == 0 ? 0u : h->count[0]));
  const float4 p = at[0], q = at[room], r = at[2 * room];
  const float x[3] = {p.x, p.y, p.z}, own[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
  return ccBinOf(x, own, other, q.w, p.w, side, perCell);
}

// The result of a pair's search, with `failed` set if its hits found no room.
CcAnswer ccAnswerOf(__global const CcPair* pair, __global const CcFound* found, uint p,
                    int finest) {
  CcAnswer a;
  a.level = ccLastLevel(pair, found + 2 * p * CC_LEVELS, finest);
  a.failed = a.level < finest ? CC_FINER : 0;
  a.hits = a.lookups = a.needed = a.firstBin = a.bins = a.firstPatch = a.patches = 0;
  for (int level = CC_LEVELS - 1; level >= max(a.level, finest); --level)
    for (uint d = 0; d < 2; ++d) {
      const CcFound f = found[(2 * p + d) * CC_LEVELS + (uint)level];
      const uint all = f.whole + f.deep + f.parts;
      a.needed = max(a.needed, all);
      if (all > pair->ways[d].room) a.failed |= CC_NO_ROOM;
      a.lookups += f.lookups;
      if (level == a.level) a.hits += all;
    }
  if (a.hits == 0 && pair->margin > 0.0f) a.failed |= CC_NO_TOUCH;
  return a;
}

// Finds the bin of each hit as a slot of the table; least[k] becomes the first hit of slot k.
// Returns the number of bins, or more than CC_MOST_BINS.
uint ccFindBins(const CcHits* h, uint count, __global const ulong* keys, __global uint* slots,
                __local int* holder, __local int* least, __local uint* used) {
  const uint lid = get_local_id(0);
  for (uint k = lid; k < CC_SLOTS; k += CC_GROUP) holder[k] = least[k] = CC_EMPTY;
  if (lid == 0) *used = 0u;
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  for (uint i = lid; i < count; i += CC_GROUP) {
    const ulong key = keys[ccHitAt(h, i)];
    uint slot = (uint)(key * 0x9E3779B97F4A7C15ul >> 40) & (CC_SLOTS - 1);
    for (uint tries = 0; tries < CC_SLOTS; ++tries, slot = (slot + 1) & (CC_SLOTS - 1)) {
      const int held = atomic_cmpxchg(&holder[slot], CC_EMPTY, (int)i);
      if (held == CC_EMPTY && atomic_inc(used) >= CC_MOST_BINS) break;
      if (held == CC_EMPTY || keys[ccHitAt(h, (uint)held)] == key) {
        atomic_min(&least[slot], (int)i);
        slots[ccHitAt(h, i)] = slot;
        break;
      }
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  return *used;
}

// Lists each bin's hits in order, by their numbers in their direction. Each team takes one run of
// hits. `next`: for each team and bin, where its next hit goes. `bins`: one number per work-item.
void ccListHits(const CcHits* h, uint count, __global const uint* binOf, __local uint* next,
                __local uint* bins, __global uint* order) {
  const uint lid = get_local_id(0), lane = lid % CC_TEAM, team = lid / CC_TEAM;
  const uint each = (count + CC_GROUP - 1) / CC_GROUP * CC_TEAM;
  const uint end = min((team + 1) * each, count);
  for (uint step = 0; step < each; step += CC_TEAM) {
    const uint i = team * each + step + lane;
    const int is = i < end;
    const uint bin = binOf[ccHitAt(h, min(i, count - 1))], at = team * CC_MOST_BINS + bin;
    bins[lid] = is ? bin : CC_MOST_BINS;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint before = 0, all = 0;
    for (uint k = 0; k < CC_TEAM; ++k) {
      const uint same = bins[team * CC_TEAM + k] == bin;
      all += same;
      before += k < lane ? same : 0u;
    }
    const uint place = next[at] + before;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (is) order[h->first[0] + place] = i < h->count[0] ? i : i - h->count[0];
    if (is && before + 1 == all) next[at] = place + 1;
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccBins(
    __global const CcPair* pairs, __global const CcFound* found, __global const float4* hits,
    __global const ulong* keys, __global uint* slots, __global uint* order,
    __global CcResults* results, __global CcBin* bins, uint binRoom, int finest) {
  __global CcAnswer* answers = results->answers;
  // First a table of keys, then for four teams where the next hits go.
  __local uint table[CC_TEAMS * CC_MOST_BINS];
  __local int *holder = (__local int*)table, *least = holder + CC_SLOTS;
  __local uint counts[CC_MOST_BINS], firsts[CC_MOST_BINS], sums[2 * CC_GROUP], used, firstBin;
  __local CcFlags flags;
  const uint lid = get_local_id(0), p = get_group_id(0);
  CcAnswer answer = ccAnswerOf(&pairs[p], found, p, finest);
  if (answer.failed || answer.hits == 0) {
    if (lid == 0) answers[p] = answer;
    return;
  }
  const CcHits h = ccHitsOf(answer.level, found, pairs, p);
  const uint count = answer.hits;
  const double cell = pairs[p].cell * (answer.level == CC_LEVELS - 1 ? 2.0 : 1.0);
  const float perCell = (float)(1.0 / cell);
  const uint all = ccFindBins(&h, count, keys, slots, holder, least, &used);
  if (lid == 0) firstBin = all <= CC_MOST_BINS ? atomic_add(&results->counters[CC_BINS], all) : binRoom;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (firstBin + all > binRoom) {
    if (lid == 0) {
      answer.failed = CC_NO_BINS;
      answer.bins = all;
      answers[p] = answer;
    }
    return;
  }
  // Number the bins in the order of their first hits; `holder` then has each slot's number.
  ccNoFlags(&flags);
  for (uint base = 0; base < count; base += CC_GROUP) {
    const uint i = base + lid;
    const uint at = i < count ? ccHitAt(&h, i) : 0u;
    const int is = i < count && least[slots[at]] == (int)i;
    ccFlag(&flags, 1, (uint)is);
    if (is) {
      const uint number = ccFlagged(&flags, 0);
      const CcBinOfHit b = ccBinAt(&h, hits, i, perCell);
      const CcBin bin = {{b.x, b.y, b.z}, p, 0, 0, 0, 0};
      bins[firstBin + number] = bin;
      holder[slots[at]] = (int)number;
    }
  }
  for (uint b = lid; b < all; b += CC_GROUP) counts[b] = firsts[b] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  for (uint i = lid; i < count; i += CC_GROUP) {
    const uint at = ccHitAt(&h, i);
    const uint bin = (uint)holder[slots[at]];
    slots[at] = bin;
    atomic_inc(&counts[bin]);
    if (i < h.count[0]) atomic_inc(&firsts[bin]);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  for (uint k = lid; k < CC_TEAMS * CC_MOST_BINS; k += CC_GROUP) table[k] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint each = (count + CC_GROUP - 1) / CC_GROUP * CC_TEAM;
  for (uint i = lid; i < count; i += CC_GROUP) {
    atomic_inc(&table[i / each * CC_MOST_BINS + slots[ccHitAt(&h, i)]]);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  uint before = 0;
  for (uint base = 0; base < all; base += CC_GROUP) {
    const uint b = base + lid;
    const uint own = b < all ? counts[b] : 0u;
    const uint upTo = before + ccSumUpTo(sums, own);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (b < all) {
      bins[firstBin + b].begin = upTo - own;
      bins[firstBin + b].middle = upTo - own + firsts[b];
      bins[firstBin + b].end = upTo;
      counts[b] = upTo - own;
    }
    if (lid == CC_GROUP - 1) sums[0] = upTo;
    barrier(CLK_LOCAL_MEM_FENCE);
    before = sums[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  for (uint b = lid; b < all; b += CC_GROUP) {
    const uint one = counts[b] + table[b], two = one + table[CC_MOST_BINS + b];
    table[3 * CC_MOST_BINS + b] = two + table[2 * CC_MOST_BINS + b];
    table[2 * CC_MOST_BINS + b] = two;
    table[CC_MOST_BINS + b] = one;
    table[b] = counts[b];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  ccListHits(&h, count, slots, table, sums, order);
  if (lid == 0) {
    answer.firstBin = firstBin;
    answer.bins = all;
    answers[p] = answer;
  }
}
