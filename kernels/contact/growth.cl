// Region growing of patches. First a group for each pair finds what does not depend on patches: the
// order of the bins by weight, each bin's neighbors in the order of their visits, and which of them
// may be linked. Then a team for each pair grows its patches. It tests all neighbors of a bin at
// once against the patch as it is, and the first in order joins; those before it have been tested
// in time. So the patches equal those of a single thread.

#define CC_NEAR_BINS 128                // bins of a pair in local memory
#define CC_NEAR_HELD 32                 // neighbors of each of these in local memory
#define CC_NEAR_ROW (CC_NEAR_HELD + 2)  // row of their list; rows begin in different banks
#define CC_COMING 8                     // neighbors read at once
#define CC_SPROUTS_COMING 4             // bins read at once

// A neighbor in a list: its bin, and whether the two may be linked.
#define CC_NEAR_BIN (CC_MOST_BINS - 1)
#define CC_MAY_LINK 0x8000u

// Squares decide only if they differ by more than rounding can; otherwise roots do, as on the CPU.
#define CC_SURELY 1e-12

// The part of a bin that decides about links.
typedef struct {
  CcFaces faces;
  CcVec center;
} CcStem;

// Local memory of a group for a pair's bins.
typedef struct {
  // First keys and weights of all bins, then the stems of the first bins.
  double numbers[2 * CC_MOST_BINS];
  short4 sorted[CC_MOST_BINS];  // cells in the order of visits, with the bin's number in w
  uint crowded;                 // a bin has more than CC_NEIGHBORS neighbors
} CcSproutRoom;

// A bin's cell relative to that of the pair's first bin. No grid has more cells than fit
// (CC_KEY_BITS).
short4 ccCellFrom(__global const CcBin* first, __global const CcBin* bin) {
  return (short4)((short)(bin->cell[0] - first->cell[0]), (short)(bin->cell[1] - first->cell[1]),
                  (short)(bin->cell[2] - first->cell[2]), 0);
}

// Neighbors are visited cell by cell, the last bin of a cell first.
ulong ccOrderOf(short4 cell, uint bin) {
  return (ulong)(cell.z + 16384) << 40 | (ulong)(cell.y + 16384) << 25 |
         (ulong)(cell.x + 16384) << 10 | (CC_MOST_BINS - 1 - bin);
}

int ccBeside(short4 a, short4 b) {
  const int x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return (x >= -1) & (x <= 1) & (y >= -1) & (y <= 1) & (z >= -1) & (z <= 1);
}

// The offset in CcSums of the n-th number of CcSprout.
uint ccSproutFrom(uint n) {
  if (n < 6) return CC_NORMALS + n;
  if (n < 8) return CC_SIDES + CC_SIZE + (n - 6) * CC_SIDE_NUMBERS;
  if (n == 8) return CC_AREA;
  return n < 12 ? CC_FIRST + n - 9 : n - 12;
}

// Copies the sprouts of a pair's bins out of their sums. 16 work-items share a bin, so that they
// read whole lines of memory.
void ccTakeSprouts(__global const CcSums* sums, uint all, __global CcSprout* sprouts) {
  const uint n = get_local_id(0) % 16, from = ccSproutFrom(min(n, CC_SPROUT_NUMBERS - 1u));
  for (uint b = get_local_id(0) / 16; b < all; b += CC_SPROUTS_COMING * CC_GROUP / 16) {
    double coming[CC_SPROUTS_COMING];
    for (uint k = 0; k < CC_SPROUTS_COMING; ++k)
      coming[k] = ((__global const double*)&sums[min(b + k * CC_GROUP / 16, all - 1u)])[from];
    for (uint k = 0; k < CC_SPROUTS_COMING; ++k)
      if (n < CC_SPROUT_NUMBERS && b + k * CC_GROUP / 16 < all)
        ((__global double*)&sprouts[b + k * CC_GROUP / 16])[n] = coming[k];
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

CcStem ccStemOf(__global const CcSprout* sprout) {
  CcStem s;
  for (int side = 0; side < 2; ++side) {
    s.faces.normal[side] = ccVecAt(sprout->normal[side]);
    s.faces.length[side] = ccLength64(s.faces.normal[side]);
  }
  const double area = sprout->area;
  s.center = ccVecAt(sprout->origin);
  if (area > 0.0) {
    const CcVec first = ccVecAt(sprout->first);
    s.center = ccPlus(s.center, ccVec(first.x / area, first.y / area, first.z / area));
  }
  return s;
}

// Whether two bins may be linked, whatever the patch. The distance of their centers decides nearly
// all cases without a root.
int ccMayLink(const CcStem* from, const CcStem* to, double close) {
  const CcVec apart = ccMinus(to->center, from->center);
  if (ccDot64(apart, apart) > close * close * (1.0 + CC_SURELY)) return 0;
  return ccLinked(&to->faces, &from->faces, 1.0, 1.0, to->center, from->center, close);
}

// Lists a bin's neighbors in the order of visits, with whether they may be linked. The j-th is at
// near[j * all], so that consecutive bins write consecutive numbers. Returns their number.
uint ccListNeighbors(uint bin, short4 cell, uint all, __global const CcSprout* sprouts,
                      double close, __global ushort* near, __local const CcSproutRoom* r) {
  __local const CcStem* stems = (__local const CcStem*)r->numbers;
  const CcStem own = bin < CC_NEAR_BINS ? stems[bin] : ccStemOf(&sprouts[bin]);
  uint count = 0;
  for (uint base = 0; base < all; base += 32) {
    uint beside = 0;
    for (uint k = base; k < min(base + 32u, all); ++k)
      beside |= (uint)ccBeside(r->sorted[k], cell) << (k - base);
    for (; beside; beside &= beside - 1u) {
      const uint other = (uint)r->sorted[base + ccLowest(beside)].w;
      if (other == bin) continue;
      if (count < CC_NEIGHBORS) {
        const CcStem stem = other < CC_NEAR_BINS ? stems[other] : ccStemOf(&sprouts[other]);
        near[count * all] = (ushort)(other | (ccMayLink(&own, &stem, close) ? CC_MAY_LINK : 0u));
      }
      ++count;
    }
  }
  return count;
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSprouts(
    __global const CcPair* pairs, __global CcResults* results, __global const CcBin* allBins,
    __global const CcSums* allSums, __global CcSprout* allSprouts, __global ushort* allHeaviest,
    __global ushort* allNear, __global uchar* allNeighbors) {
  __local CcSproutRoom r;
  const uint lid = get_local_id(0), p = get_group_id(0);
  __global CcAnswer* answers = results->answers;
  const uint all = answers[p].failed ? 0u : answers[p].bins, first = answers[p].firstBin;
  const double cell = pairs[p].cell * (answers[p].level == CC_LEVELS - 1 ? 2.0 : 1.0);
  if (all == 0u) return;
  __global const CcBin* bins = allBins + first;
  __global CcSprout* sprouts = allSprouts + first;
  __global ushort* near = allNear + (size_t)first * CC_NEIGHBORS;
  __local ulong* keys = (__local ulong*)r.numbers;
  __local double* weights = r.numbers + CC_MOST_BINS;
  __local CcStem* stems = (__local CcStem*)r.numbers;
  ccTakeSprouts(allSums + first, all, sprouts);
  for (uint b = lid; b < all; b += CC_GROUP) {
    weights[b] = sprouts[b].size[0] + sprouts[b].size[1];
    keys[b] = ccOrderOf(ccCellFrom(bins, &bins[b]), b);
  }
  if (lid == 0) r.crowded = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint b = lid; b < all; b += CC_GROUP) {
    const ulong key = keys[b];
    const double weight = weights[b];
    uint place = 0, heavier = 0;
    for (uint k = 0; k < all; ++k) {
      const double other = weights[k];
      place += (uint)(keys[k] < key);
      heavier += (uint)((other > weight) | ((other == weight) & (k < b)));
    }
    short4 sorted = ccCellFrom(bins, &bins[b]);
    sorted.w = (short)b;
    r.sorted[place] = sorted;
    allHeaviest[first + heavier] = (ushort)b;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint b = lid; b < min(all, (uint)CC_NEAR_BINS); b += CC_GROUP)
    stems[b] = ccStemOf(&sprouts[b]);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint b = lid; b < all; b += CC_GROUP) {
    const uint count = ccListNeighbors(b, ccCellFrom(bins, &bins[b]), all, sprouts,
                                        CC_CLOSE * cell, near + b, &r);
    if (count > CC_NEIGHBORS) r.crowded = 1u;
    allNeighbors[first + b] = (uchar)min(count, (uint)CC_NEIGHBORS);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid == 0 && r.crowded) answers[p].failed = CC_NO_BINS;
}

// A bin or a patch as region growing sees it.
typedef struct {
  CcVec normal[2];   // sums of A's and of B's normals
  double square[2];  // of their lengths
  double size[2];    // of its two sides
} CcGrowing;

CcGrowing ccGrowingFrom(__global const CcSprout* sprout) {
  CcGrowing g;
  for (int s = 0; s < 2; ++s) {
    g.normal[s] = ccVecAt(sprout->normal[s]);
    g.square[s] = ccDot64(g.normal[s], g.normal[s]);
    g.size[s] = sprout->size[s];
  }
  return g;
}

// Local memory of a team: the first bins and neighbors, which bins have a patch, and the bins in
// the order in which they joined.
typedef struct {
  CcGrowing bins[CC_NEAR_BINS];
  ushort near[CC_NEAR_BINS * CC_NEAR_ROW], queue[CC_MOST_BINS];
  uchar neighbors[CC_MOST_BINS], taken[CC_MOST_BINS];
  uint votes, place;
} CcTeam;

// The pair's bins and neighbors in global memory.
typedef struct {
  __global const CcSprout* bins;
  __global const uchar* neighbors;  // number of each bin's
  __global const ushort *near, *heaviest;
  uint all;
} CcGarden;

CcGrowing ccGrowingOf(const CcGarden* g, __local const CcTeam* team, uint b) {
  return b < CC_NEAR_BINS ? team->bins[b] : ccGrowingFrom(&g->bins[b]);
}

void ccTakeIn(const CcGarden* g, __local CcTeam* team) {
  const uint lid = get_local_id(0);
  for (uint b = lid; b < g->all; b += CC_TEAM) {
    team->taken[b] = 0;
    team->neighbors[b] = g->neighbors[b];
    if (b < CC_NEAR_BINS) team->bins[b] = ccGrowingFrom(&g->bins[b]);
  }
  // Reads whole batches, beyond the last neighbor too, so that all reads run together.
  for (uint b = lid; b < min(g->all, (uint)CC_NEAR_BINS); b += CC_TEAM)
    for (uint j = 0; j < min((uint)team->neighbors[b], (uint)CC_NEAR_HELD); j += CC_COMING) {
      ushort coming[CC_COMING];
      for (uint k = 0; k < CC_COMING; ++k) coming[k] = g->near[(j + k) * g->all + b];
      for (uint k = 0; k < CC_COMING; ++k) team->near[b * CC_NEAR_ROW + j + k] = coming[k];
    }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// The j-th neighbor of a bin.
uint ccNeighbor(const CcGarden* g, __local const CcTeam* team, uint bin, uint j) {
  return bin < CC_NEAR_BINS && j < CC_NEAR_HELD ? team->near[bin * CC_NEAR_ROW + j]
                                                : g->near[j * g->all + bin];
}

// The heaviest bin without a patch, from the `done`-th in weight on.
uint ccSeed(const CcGarden* g, uint* done, __local CcTeam* team) {
  const uint lid = get_local_id(0);
  for (;; *done += CC_TEAM) {
    const uint bin = g->heaviest[min(*done + lid, g->all - 1)];
    const uint free = ccVotes(&team->votes, team->taken[bin] == 0);
    if (free) return g->heaviest[min(*done + ccLowest(free), g->all - 1)];
  }
}

CcFaces ccFacesOf(const CcGrowing* g) {
  CcFaces f;
  for (int s = 0; s < 2; ++s) {
    f.normal[s] = g->normal[s];
    f.length[s] = ccLength64(f.normal[s]);
  }
  return f;
}

#define CC_LEAST_SQUARES 1e-250  // of lengths: below it products of four lose their bits

// ccAlike(a, b, CC_AGREE) by squares, since roots are slow. A sum without length, as of walls,
// agrees with any.
int ccAlikeBySquares(const CcGrowing* a, const CcGrowing* b) {
  int oneAgrees = 0, noneAgrees = 1, oneOpposes = 0, noneOpposes = 1;
  for (int s = 0; s < 2; ++s) {
    const double dot = ccDot64(a->normal[s], b->normal[s]), dots = dot * dot;
    const double lengths = a->square[s] * b->square[s];
    const double agree = CC_AGREE * CC_AGREE * lengths;
    const double oppose = CC_DISAGREE * CC_DISAGREE * lengths;
    const int nothing = (a->square[s] == 0.0) | (b->square[s] == 0.0);
    const int known = lengths > CC_LEAST_SQUARES;
    oneAgrees |= nothing | (known & (dot > 0.0) & (dots > agree * (1.0 + CC_SURELY)));
    noneAgrees &= known & ((dot < 0.0) | (dots < agree * (1.0 - CC_SURELY)));
    oneOpposes |= known & (dot < 0.0) & (dots > oppose * (1.0 + CC_SURELY));
    noneOpposes &= nothing | (known & ((dot > 0.0) | (dots < oppose * (1.0 - CC_SURELY))));
  }
  if (oneOpposes | noneAgrees) return 0;
  if (oneAgrees & noneOpposes) return 1;
  const CcFaces one = ccFacesOf(a), other = ccFacesOf(b);
  return ccAlike(&one, &other, CC_AGREE);
}

int ccJoins(const CcGrowing* bin, uint entry, const CcGrowing* patch) {
  if (ccAlikeBySquares(bin, patch)) return 1;
  const double weight = bin->size[0] + bin->size[1], all = patch->size[0] + patch->size[1];
  return (entry & CC_MAY_LINK) && !(weight < CC_LEAST_LINK * all);
}

// Adds a bin to a patch.
void ccJoin(const CcGrowing* bin, CcGrowing* patch) {
  for (int s = 0; s < 2; ++s) {
    patch->normal[s] = ccPlus(patch->normal[s], bin->normal[s]);
    patch->square[s] = ccDot64(patch->normal[s], patch->normal[s]);
    patch->size[s] += bin->size[s];
  }
}

// Tests as many neighbors of the bin `from` as a team has work-items, beginning with the `first`,
// and appends those that join to the team's queue of `length` bins. Returns the new length.
uint ccTakeNeighbors(const CcGarden* g, uint from, uint first, uint length, CcGrowing* patch,
                      __local CcTeam* team) {
  const uint lid = get_local_id(0), j = first + lid;
  uint entry = 0, waiting = 0;
  if (j < team->neighbors[from]) {
    entry = ccNeighbor(g, team, from, j);
    waiting = team->taken[entry & CC_NEAR_BIN] == 0;
  }
  const CcGrowing own = ccGrowingOf(g, team, entry & CC_NEAR_BIN);
  uint joining = ccVotes(&team->votes, waiting && ccJoins(&own, entry, patch));
  while (joining) {
    const uint joins = ccLowest(joining);
    const uint bin = ccNeighbor(g, team, from, first + joins) & CC_NEAR_BIN;
    const CcGrowing more = ccGrowingOf(g, team, bin);
    ccJoin(&more, patch);
    if (lid == joins) {
      team->taken[bin] = 1;
      team->queue[length] = (ushort)bin;
    }
    ++length;
    if (lid <= joins) waiting = 0;
    joining = ccVotes(&team->votes, waiting && ccJoins(&own, entry, patch));
  }
  return length;
}

// Grows the patch of the bin `seed`. Its bins go to the team's queue from `begin` on. Returns their
// end.
uint ccGrowFrom(const CcGarden* g, uint seed, uint begin, __local CcTeam* team) {
  uint length = begin + 1;
  CcGrowing patch = ccGrowingOf(g, team, seed);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) {
    team->queue[begin] = (ushort)seed;
    team->taken[seed] = 1;
  }
  for (uint next = begin; next < length; ++next) {
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint from = team->queue[next], all = team->neighbors[from];
    for (uint first = 0; first < all; first += CC_TEAM)
      length = ccTakeNeighbors(g, from, first, length, &patch, team);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return length;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccGrow(
    __global CcResults* results, __global const CcSprout* sprouts, __global const uchar* neighbors,
    __global const ushort* heaviest, __global const ushort* near, __global uint* queues,
    __global CcGrown* scratch, __global CcGrown* grown, uint patchRoom) {
  __local CcTeam team;
  const uint lid = get_local_id(0), p = get_group_id(0);
  __global CcAnswer* answers = results->answers;
  const uint all = answers[p].failed ? 0u : answers[p].bins, first = answers[p].firstBin;
  if (all == 0u) return;
  const CcGarden g = {sprouts + first, neighbors + first, near + (size_t)first * CC_NEIGHBORS,
                      heaviest + first, all};
  __global CcGrown* own = scratch + first;
  ccTakeIn(&g, &team);
  uint done = 0, patches = 0, heavier = 0;
  while (done < all) {
    const uint end = ccGrowFrom(&g, ccSeed(&g, &heavier, &team), done, &team);
    if (lid == 0) {
      const CcGrown one = {first + done, first + end};
      own[patches] = one;
    }
    done = end;
    ++patches;
  }
  if (lid == 0) team.place = atomic_add(&results->counters[CC_PATCHES], patches);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  const uint place = team.place;
  const int fits = place + patches <= patchRoom;
  // Patches without room are written as empty ones, since later kernels read all places.
  const CcGrown nothing = {0u, 0u};
  for (uint k = lid; k < patches && place + k < patchRoom; k += CC_TEAM)
    grown[place + k] = fits ? own[k] : nothing;
  for (uint k = lid; k < all; k += CC_TEAM) queues[first + k] = first + team.queue[k];
  if (lid == 0) {
    answers[p].firstPatch = place;
    answers[p].patches = patches;
    if (!fits) answers[p].failed = CC_NO_BINS;
  }
}
