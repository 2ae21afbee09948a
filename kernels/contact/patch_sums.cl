// Sums patches: the sums of their bins, moved to a common origin and added in the order in which
// region growing took the bins in (growth.cl).

// How a bin's k-th number moves to a patch's origin: as in ccJoinSums() (hit_sums.h), with the same
// instructions for all numbers. The shift between the origins is in the place of the bin's origin.
#define CC_STAYS 0
#define CC_MOVES 1    // by a
#define CC_TURNS 2    // by a - b
#define CC_SPREADS 3  // by a, b and c, one after the other
#define CC_OPENS 4    // by a + b + c

typedef struct {
  int kind;
  int a, i, b, j;  // offsets of factors: a = [a] * [i], b = [b] * [j]
  int c, k, l;     // c = [c] * [k] * [l], or without [l] for CC_OPENS
} CcMove;

CcMove ccMoveOf(int k) {
  CcMove m = {CC_STAYS, k, 0, k, 0, k, 0, 0};
  if (k >= CC_SIDES && k < CC_AREA) {
    const int side = (k - CC_SIDES) / CC_SIDE_NUMBERS;
    const int push = CC_SIDES + CC_SIDE_NUMBERS * side, i = k - push - 3;
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    const CcMove turns = {CC_TURNS, push + q, p, push + p, q, k, 0, 0};
    if (i >= 0 && i < 3) m = turns;
  } else if (k >= CC_FIRST && k < CC_SECOND) {
    m.kind = CC_MOVES, m.a = CC_AREA, m.i = k - CC_FIRST;
  } else if (k >= CC_SECOND && k < CC_NORMALS) {
    const int i = (k - CC_SECOND) / 3, j = (k - CC_SECOND) % 3;
    const CcMove spreads = {CC_SPREADS, CC_FIRST + j, i, CC_FIRST + i, j, CC_AREA, j, i};
    m = spreads;
  } else if (k >= CC_NORMALS_BY && k < CC_PLACES) {
    const int side = (k - CC_NORMALS_BY) / 9, at = (k - CC_NORMALS_BY) % 9;
    m.kind = CC_MOVES, m.a = CC_NORMALS + 3 * side + at % 3, m.i = at / 3;
  } else if (k >= CC_PLACES && k < CC_PLACES + 3) {
    m.kind = CC_MOVES, m.a = CC_PRESSED, m.i = k - CC_PLACES;
  } else if (k == CC_OPENING) {
    const CcMove opens = {CC_OPENS, CC_APART, 0, CC_APART + 1, 1, CC_APART + 2, 2, 0};
    m = opens;
  }
  return m;
}

// Adds a bin's k-th number to a patch's.
double ccJoined(double to, __local const double* from, const CcMove* m, int k) {
  const double own = from[k];
  const double a = from[m->a] * from[m->i], b = from[m->b] * from[m->j];
  const double open = from[m->c] * from[m->k], c = open * from[m->l];
  const double by = m->kind == CC_TURNS ? a - b : m->kind == CC_OPENS ? a + b + open : a;
  const double moved = own + by, spread = moved + b + c;
  const double more = m->kind == CC_STAYS ? own : m->kind == CC_SPREADS ? spread : moved;
  if (k == CC_DEEPEST) return to < more ? more : to;
  if (k == CC_HITS) return as_double(as_ulong(to) + as_ulong(more));
  return to + more;
}

#define CC_STAGE 4  // bins in local memory at a time
#define CC_STAGE_ROUNDS ((CC_STAGE * CC_SUMS_NUMBERS + CC_TEAM - 1) / CC_TEAM)

// Reads a work-item's share of the numbers of `some` bins.
void ccOnTheWay(__global const CcSums* sums, __local const uint* bins, int some, double* numbers) {
  for (int n = 0; n < CC_STAGE_ROUNDS; ++n) {
    const int at = (int)get_local_id(0) + n * CC_TEAM, r = at / CC_SUMS_NUMBERS;
    if (at < some * CC_SUMS_NUMBERS)
      numbers[n] = ((__global const double*)&sums[bins[r]])[at - r * CC_SUMS_NUMBERS];
  }
}

#define CC_TEAM_ROUNDS ((CC_SUMS_NUMBERS + CC_TEAM - 1) / CC_TEAM)

// Sums patches, bin by bin in the order in which they joined. A team shares a patch; each work-item
// has some of the numbers.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccPatches(
    __global const CcSums* sums, __global const uint* queues, __global const CcGrown* grown,
    __global const CcResults* results, uint patchRoom, __global CcSums* patches) {
  __local double held[CC_STAGE * CC_SUMS_NUMBERS], origin[3];
  __local uint bins[CC_TEAM];
  const int lane = (int)get_local_id(0);
  const uint all = min(results->counters[CC_PATCHES], patchRoom);
  CcMove moves[CC_TEAM_ROUNDS];
  for (int n = 0; n < CC_TEAM_ROUNDS; ++n) moves[n] = ccMoveOf(lane + n * CC_TEAM);
  for (uint k = get_group_id(0); k < all; k += get_num_groups(0)) {
    const CcGrown g = grown[k];
    if (g.begin == g.end) continue;
    __global const double* first = (__global const double*)&sums[queues[g.begin]];
    double joined[CC_TEAM_ROUNDS], coming[CC_STAGE_ROUNDS];
    for (int n = 0; n < CC_TEAM_ROUNDS; ++n)
      joined[n] = lane + n * CC_TEAM < CC_SUMS_NUMBERS ? first[lane + n * CC_TEAM] : 0.0;
    if (lane < 3) origin[lane] = joined[0];
    for (uint i = g.begin + 1; i < g.end; i += CC_TEAM) {
      const int count = (int)min((uint)CC_TEAM, g.end - i);
      if (lane < count) bins[lane] = queues[i + (uint)lane];
      barrier(CLK_LOCAL_MEM_FENCE);
      ccOnTheWay(sums, bins, min(CC_STAGE, count), coming);
      for (int done = 0; done < count; done += CC_STAGE) {
        const int some = min(CC_STAGE, count - done), next = done + CC_STAGE;
        for (int n = 0; n < CC_STAGE_ROUNDS; ++n) {
          const int at = lane + n * CC_TEAM, place = at % CC_SUMS_NUMBERS;
          if (at < some * CC_SUMS_NUMBERS)
            held[at] = place < CC_SIDES ? coming[n] - origin[place] : coming[n];
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        if (next < count) ccOnTheWay(sums, bins + next, min(CC_STAGE, count - next), coming);
        for (int r = 0; r < some; ++r) {
          __local const double* from = held + r * CC_SUMS_NUMBERS;
          for (int n = 0; n < CC_TEAM_ROUNDS; ++n) {
            const int at = lane + n * CC_TEAM;
            if (at >= CC_SIDES && at < CC_SUMS_NUMBERS)
              joined[n] = ccJoined(joined[n], from, &moves[n], at);
          }
        }
        barrier(CLK_LOCAL_MEM_FENCE);
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    __global double* to = (__global double*)&patches[k];
    for (int n = 0; n < CC_TEAM_ROUNDS; ++n)
      if (lane + n * CC_TEAM < CC_SUMS_NUMBERS) to[lane + n * CC_TEAM] = joined[n];
  }
}
