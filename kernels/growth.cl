// Bins grow together to patches: a team for each pair. In a round every work-item asks for its own
// neighbours whether they would join the patch as it is; the first in order does, and those before
// it were asked in time. So the patches are those of one worker who goes from bin to bin.

#define CC_NEIGHBOURS 192  // 27 cells of six bins, and some
#define CC_NEAR_BINS 128   // that a team has at hand
#define CC_NONE 0x7fffffff

// What growing asks of each bin.
__kernel void ccSprouts(__global const CcBin* bins, __global const CcSums* sums,
                        __global const uint* counters, uint binRoom, __global CcSprout* sprouts) {
  const uint all = min(counters[CC_BINS], binRoom);
  for (uint b = get_global_id(0); b < all; b += get_global_size(0)) {
    CcSprout s;
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < 3; ++i) s.faces.normal[side][i] = sums[b].normal[side][i];
      s.faces.length[side] = ccLength64(s.faces.normal[side]);
      s.size[side] = sums[b].side[side].size;
    }
    const double area = sums[b].area;
    for (int i = 0; i < 3; ++i) {
      s.center[i] = sums[b].origin[i];
      if (area > 0.0) s.center[i] += sums[b].first[i] / area;
      s.cell[i] = bins[b].cell[i];
    }
    s.unused = 0;
    sprouts[b] = s;
  }
}

typedef struct {
  CcFaces faces;
  double size[2];    // of its two sides
  double center[3];  // of a bin
} CcGrowing;

// What every work-item of a team asks for again and again, near at hand: a bin's cell, from that of
// the first bin, and whether it has a patch (w); and the first bins themselves.
typedef struct {
  short4 cells[CC_MOST_BINS];
  CcGrowing bins[CC_NEAR_BINS];
  CcGrowing patch;             // that grows
  ushort queue[CC_MOST_BINS];  // bins with a patch, as they came
  double best[CC_TEAM];
  int numbers[CC_TEAM], keys[CC_NEIGHBOURS];
  uint count[2], place;
  int first[2];
} CcTeam;

CcGrowing ccGrowingOf(__global const CcSprout* bins, __local const CcTeam* team, uint b) {
  CcGrowing g;
  if (b < CC_NEAR_BINS) return team->bins[b];
  g.faces = bins[b].faces;
  for (int i = 0; i < 2; ++i) g.size[i] = bins[b].size[i];
  for (int i = 0; i < 3; ++i) g.center[i] = bins[b].center[i];
  return g;
}

void ccTakeIn(__global const CcSprout* bins, uint all, __local CcTeam* team) {
  const int first[3] = {bins[0].cell[0], bins[0].cell[1], bins[0].cell[2]};
  for (uint b = get_local_id(0); b < all; b += CC_TEAM) {
    // No grid holds more cells than these numbers (CC_KEY_BITS).
    team->cells[b] =
        (short4)((short)(bins[b].cell[0] - first[0]), (short)(bins[b].cell[1] - first[1]),
                 (short)(bins[b].cell[2] - first[2]), 0);
    if (b >= CC_NEAR_BINS) continue;
    team->bins[b].faces = bins[b].faces;
    for (int i = 0; i < 2; ++i) team->bins[b].size[i] = bins[b].size[i];
    for (int i = 0; i < 3; ++i) team->bins[b].center[i] = bins[b].center[i];
  }
  if (get_local_id(0) == 0) team->count[0] = team->count[1] = 0u;
}

// The heaviest bin without a patch, of equals the first; CC_NONE where all have one.
int ccSeed(__global const CcSprout* bins, uint all, __local CcTeam* team) {
  const uint lid = get_local_id(0);
  double weight = -1.0;
  int number = CC_NONE;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint b = lid; b < all; b += CC_TEAM) {
    if (team->cells[b].w != 0) continue;
    const double own = b < CC_NEAR_BINS ? team->bins[b].size[0] + team->bins[b].size[1]
                                        : bins[b].size[0] + bins[b].size[1];
    if (number == CC_NONE || own > weight) {
      weight = own;
      number = (int)b;
    }
  }
  team->best[lid] = weight;
  team->numbers[lid] = number;
  for (uint step = CC_TEAM / 2; step > 0; step /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid >= step) continue;
    const int other = team->numbers[lid + step], own = team->numbers[lid];
    const double more = team->best[lid + step] - team->best[lid];
    if (other != CC_NONE && (own == CC_NONE || more > 0.0 || (more == 0.0 && other < own))) {
      team->best[lid] = team->best[lid + step];
      team->numbers[lid] = other;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return team->numbers[0];
}

int ccKeyOf(int cell, uint bin) {
  return cell * CC_MOST_BINS + (CC_MOST_BINS - 1) - (int)bin;
}
uint ccBinOfKey(int key) {
  return (uint)((CC_MOST_BINS - 1) - key % CC_MOST_BINS);
}

// Neighbours of a bin without a patch, by the order in which they are asked: cell by cell, of a
// cell's bins the last first. Counters are used in turn. Returns how many.
uint ccNeighbours(uint all, uint from, __local CcTeam* team, uint turn) {
  barrier(CLK_LOCAL_MEM_FENCE);
  const short4 middle = team->cells[from];
  if (get_local_id(0) == 0) team->count[1 - turn] = 0u;
  for (uint b = get_local_id(0); b < all; b += CC_TEAM) {
    const short4 c = team->cells[b];
    const int x = c.x - middle.x, y = c.y - middle.y, z = c.z - middle.z;
    const int near = (x >= -1) & (x <= 1) & (y >= -1) & (y <= 1) & (z >= -1) & (z <= 1);
    if (near && c.w == 0) {
      const uint k = atomic_inc(&team->count[turn]);
      if (k < CC_NEIGHBOURS) team->keys[k] = ccKeyOf(x + 1 + 3 * (y + 1) + 9 * (z + 1), b);
    }
  }
  if (get_local_id(0) == 0) team->first[0] = CC_NONE;
  barrier(CLK_LOCAL_MEM_FENCE);
  return min(team->count[turn], (uint)CC_NEIGHBOURS);
}

// Whether a bin may be linked to the one beside it, whatever the patch.
int ccMayLink(const CcGrowing* bin, const CcGrowing* from, double close) {
  return ccLinked(&bin->faces, &from->faces, 1.0, 1.0, bin->center, from->center, close);
}

int ccJoins(const CcGrowing* bin, int mayLink, const CcGrowing* patch) {
  if (ccAlike(&bin->faces, &patch->faces, CC_AGREE)) return 1;
  const double weight = bin->size[0] + bin->size[1], all = patch->size[0] + patch->size[1];
  return mayLink && !(weight < CC_LEAST_LINK * all);
}

// The patch that takes a bin in.
void ccJoin(const CcGrowing* bin, __local CcGrowing* patch) {
  for (int s = 0; s < 2; ++s) {
    double normal[3];
    for (int i = 0; i < 3; ++i) {
      normal[i] = patch->faces.normal[s][i] + bin->faces.normal[s][i];
      patch->faces.normal[s][i] = normal[i];
    }
    patch->faces.length[s] = ccLength64(normal);
    patch->size[s] += bin->size[s];
  }
}

// Takes in of `some` neighbours of the bin `from` those that join; they follow in the team's queue,
// which is `length` long. Returns how long it is then.
uint ccTakeNeighbours(__global const CcSprout* bins, uint some, uint from, double close,
                      uint length, __local CcTeam* team) {
  const uint lid = get_local_id(0);
  // Nearly always a work-item has one neighbour at most, and keeps it.
  const CcGrowing there = ccGrowingOf(bins, team, from);
  const CcGrowing kept = ccGrowingOf(bins, team, lid < some ? ccBinOfKey(team->keys[lid]) : from);
  const int mayLink = lid < some ? ccMayLink(&kept, &there, close) : 0;
  int asked = -1;
  for (uint turn = 0; some > 0; turn = 1 - turn) {
    const CcGrowing patch = team->patch;
    int own = CC_NONE;
    for (uint k = lid; k < some; k += CC_TEAM) {
      const int key = team->keys[k];
      if (key <= asked || key >= own) continue;
      if (k == lid) {
        if (ccJoins(&kept, mayLink, &patch)) own = key;
      } else {
        const CcGrowing bin = ccGrowingOf(bins, team, ccBinOfKey(key));
        if (ccJoins(&bin, ccMayLink(&bin, &there, close), &patch)) own = key;
      }
    }
    if (own != CC_NONE) atomic_min(&team->first[turn], own);
    if (lid == 0) team->first[1 - turn] = CC_NONE;
    barrier(CLK_LOCAL_MEM_FENCE);
    asked = team->first[turn];
    if (asked == CC_NONE) break;
    if (own == asked) {
      const uint b = ccBinOfKey(own);
      const CcGrowing bin =
          lid < some && team->keys[lid] == own ? kept : ccGrowingOf(bins, team, b);
      ccJoin(&bin, &team->patch);
      team->cells[b].w = 1;
      team->queue[length] = (ushort)b;
    }
    ++length;
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  return length;
}

// The patch that begins with the bin `seed`; its bins go to the team's queue from `begin` on.
// Returns where they end.
uint ccGrowFrom(__global const CcSprout* bins, uint all, uint seed, double close, uint begin,
                __local CcTeam* team) {
  uint length = begin + 1;
  if (get_local_id(0) == 0) {
    team->queue[begin] = (ushort)seed;
    team->cells[seed].w = 1;
    team->patch = ccGrowingOf(bins, team, seed);
  }
  for (uint next = begin, turn = 0; next < length; ++next, turn = 1 - turn) {
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint from = team->queue[next];
    const uint some = ccNeighbours(all, from, team, turn);
    length = ccTakeNeighbours(bins, some, from, close, length, team);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) team->count[0] = team->count[1] = 0u;
  return length;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccGrow(
    __global const CcPair* pairs, __global CcAnswer* answers, __global const CcSprout* sprouts,
    __global uint* queues, __global CcGrown* scratch, __global CcGrown* grown,
    __global uint* counters, uint patchRoom) {
  __local CcTeam team;
  const uint lid = get_local_id(0), p = get_group_id(0);
  const CcAnswer answer = answers[p];
  if (answer.failed || answer.bins == 0) return;
  const double cell = pairs[p].cell * (answer.level == CC_LEVELS - 1 ? 2.0 : 1.0);
  __global const CcSprout* bins = sprouts + answer.firstBin;
  __global CcGrown* own = scratch + answer.firstBin;
  ccTakeIn(bins, answer.bins, &team);
  uint done = 0, patches = 0;
  while (done < answer.bins) {
    const int seed = ccSeed(bins, answer.bins, &team);
    const uint end = ccGrowFrom(bins, answer.bins, (uint)seed, CC_CLOSE * cell, done, &team);
    if (lid == 0) {
      const CcGrown g = {answer.firstBin + done, answer.firstBin + end};
      own[patches] = g;
    }
    done = end;
    ++patches;
  }
  if (lid == 0) team.place = atomic_add(&counters[CC_PATCHES], patches);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  const uint place = team.place;
  const int fits = place + patches <= patchRoom;
  for (uint k = lid; k < patches && fits; k += CC_TEAM) grown[place + k] = own[k];
  for (uint k = lid; k < answer.bins; k += CC_TEAM)
    queues[answer.firstBin + k] = answer.firstBin + team.queue[k];
  if (lid == 0) {
    answers[p].firstPatch = place;
    answers[p].patches = patches;
    if (!fits) answers[p].failed = CC_NO_BINS;
  }
}

// Places in CcSums, counted in doubles.
#define CC_SUMS_NUMBERS 79
#define CC_TEAM_ROUNDS ((CC_SUMS_NUMBERS + CC_TEAM - 1) / CC_TEAM)
#define CC_SIDE_NUMBERS 13
#define CC_SIDES 3
#define CC_AREA 29
#define CC_PRESSED 31
#define CC_FIRST 32
#define CC_SECOND 35
#define CC_NORMALS 44
#define CC_NORMALS_BY 50
#define CC_PLACES 68
#define CC_APART 72
#define CC_OPENING 75
#define CC_DEEPEST 76
#define CC_HITS 78

// A bin's k-th number as it is about a patch's origin, `shift` away: as ccJoinSums() of hit_sums.h
// has it.
double ccAxis(const double* v, int i) {
  return i == 0 ? v[0] : i == 1 ? v[1] : v[2];  // an index would put them in memory
}
double ccMoved(__local const double* from, const double* shift, int k) {
  const double own = from[k];
  if (k < CC_AREA) {
    const int side = (k - CC_SIDES) / CC_SIDE_NUMBERS,
              i = k - CC_SIDES - CC_SIDE_NUMBERS * side - 3;
    if (i < 0 || i > 2) return own;
    __local const double* push = from + CC_SIDES + CC_SIDE_NUMBERS * side;
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    return own + (ccAxis(shift, p) * push[q] - ccAxis(shift, q) * push[p]);
  }
  if (k >= CC_FIRST && k < CC_SECOND) return own + from[CC_AREA] * ccAxis(shift, k - CC_FIRST);
  if (k >= CC_SECOND && k < CC_NORMALS) {
    const int i = (k - CC_SECOND) / 3, j = (k - CC_SECOND) % 3;
    const double si = ccAxis(shift, i), sj = ccAxis(shift, j);
    return own + from[CC_FIRST + j] * si + sj * from[CC_FIRST + i] + from[CC_AREA] * sj * si;
  }
  if (k >= CC_NORMALS_BY && k < CC_PLACES) {
    const int side = (k - CC_NORMALS_BY) / 9, at = (k - CC_NORMALS_BY) % 9;
    return own + from[CC_NORMALS + 3 * side + at % 3] * ccAxis(shift, at / 3);
  }
  if (k >= CC_PLACES && k < CC_PLACES + 3)
    return own + from[CC_PRESSED] * ccAxis(shift, k - CC_PLACES);
  if (k == CC_OPENING)
    return own + (shift[0] * from[CC_APART] + shift[1] * from[CC_APART + 1] +
                  shift[2] * from[CC_APART + 2]);
  return own;
}

double ccJoined(double to, double more, int k) {
  if (k == CC_DEEPEST) return to < more ? more : to;
  if (k == CC_HITS) return as_double(as_ulong(to) + as_ulong(more));
  return to + more;
}

#define CC_STAGE 8  // bins at hand

// Sums of patches, bin by bin in the order in which they came: a team shares a patch, each of its
// work-items some of the numbers.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccPatches(
    __global const CcSums* sums, __global const uint* queues, __global const CcGrown* grown,
    __global const uint* counters, uint patchRoom, __global CcSums* patches) {
  __local double near[CC_STAGE * CC_SUMS_NUMBERS];
  const int lane = (int)get_local_id(0);
  const uint all = min(counters[CC_PATCHES], patchRoom);
  for (uint k = get_group_id(0); k < all; k += get_num_groups(0)) {
    const CcGrown g = grown[k];
    __global const double* first = (__global const double*)&sums[queues[g.begin]];
    const double origin[3] = {first[0], first[1], first[2]};
    double joined[CC_TEAM_ROUNDS];
    for (int n = 0; n < CC_TEAM_ROUNDS; ++n)
      joined[n] = lane + n * CC_TEAM < CC_SUMS_NUMBERS ? first[lane + n * CC_TEAM] : 0.0;
    for (uint i = g.begin + 1; i < g.end; i += CC_STAGE) {
      const int some = (int)min((uint)CC_STAGE, g.end - i);
      barrier(CLK_LOCAL_MEM_FENCE);
      for (int r = 0; r < some; ++r) {
        __global const double* from = (__global const double*)&sums[queues[i + (uint)r]];
        for (int at = lane; at < CC_SUMS_NUMBERS; at += CC_TEAM)
          near[r * CC_SUMS_NUMBERS + at] = from[at];
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      for (int r = 0; r < some; ++r) {
        __local const double* from = near + r * CC_SUMS_NUMBERS;
        const double shift[3] = {from[0] - origin[0], from[1] - origin[1], from[2] - origin[2]};
        for (int n = 0; n < CC_TEAM_ROUNDS; ++n) {
          const int at = lane + n * CC_TEAM;
          if (at >= CC_SIDES && at < CC_SUMS_NUMBERS)
            joined[n] = ccJoined(joined[n], ccMoved(from, shift, at), at);
        }
      }
    }
    __global double* to = (__global double*)&patches[k];
    for (int n = 0; n < CC_TEAM_ROUNDS; ++n)
      if (lane + n * CC_TEAM < CC_SUMS_NUMBERS) to[lane + n * CC_TEAM] = joined[n];
  }
}
