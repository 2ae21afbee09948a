// Bins grow together to patches: a team for each pair. In a round every work-item asks for its own
// neighbours whether they would join the patch as it is; the first in order does, and those before
// it were asked in time. So the patches are those of one worker who goes from bin to bin.

#define CC_NEIGHBOURS 192  // 27 cells of six bins, and some
#define CC_NONE 0x7fffffff

void ccFacesFrom(__global const CcSums* sums, CcFaces* faces) {
  for (int s = 0; s < 2; ++s) {
    for (int i = 0; i < 3; ++i) faces->normal[s][i] = sums->normal[s][i];
    faces->length[s] = ccLength64(faces->normal[s]);
  }
}

// What growing asks of each bin.
__kernel void ccSprouts(__global const CcBin* bins, __global const CcSums* sums,
                        __global const uint* counters, uint binRoom, __global CcSprout* sprouts) {
  const uint all = min(counters[CC_BINS], binRoom);
  for (uint b = get_global_id(0); b < all; b += get_global_size(0)) {
    CcSprout s;
    ccFacesFrom(&sums[b], &s.faces);
    s.weight = sums[b].side[0].size + sums[b].side[1].size;
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

// What every work-item of a team asks for again and again, near at hand: a bin's cell and whether it
// has a patch (w), and its weight.
typedef struct {
  int4 cells[CC_MOST_BINS];
  double weights[CC_MOST_BINS];
  double best[CC_TEAM];
  int numbers[CC_TEAM], keys[CC_NEIGHBOURS];
  uint count, place;
  int first;
  CcFaces faces;   // of the patch that grows
  double size[2];  // of its two sides
} CcTeam;

void ccTakeIn(__global const CcSprout* bins, uint all, __local CcTeam* team) {
  for (uint b = get_local_id(0); b < all; b += CC_TEAM) {
    team->cells[b] = (int4)(bins[b].cell[0], bins[b].cell[1], bins[b].cell[2], 0);
    team->weights[b] = bins[b].weight;
  }
}

// The heaviest bin without a patch, of equals the first; CC_NONE where all have one.
int ccSeed(uint all, __local CcTeam* team) {
  const uint lid = get_local_id(0);
  double weight = -1.0;
  int number = CC_NONE;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint b = lid; b < all; b += CC_TEAM)
    if (team->cells[b].w == 0 && (number == CC_NONE || team->weights[b] > weight)) {
      weight = team->weights[b];
      number = (int)b;
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
// cell's bins the last first.
void ccNeighbours(uint all, uint from, __local CcTeam* team) {
  if (get_local_id(0) == 0) team->count = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  const int4 middle = team->cells[from];
  for (uint b = get_local_id(0); b < all; b += CC_TEAM) {
    const int4 d = team->cells[b] - middle;
    const int near = (d.x >= -1) & (d.x <= 1) & (d.y >= -1) & (d.y <= 1) & (d.z >= -1) & (d.z <= 1);
    if (near && team->cells[b].w == 0) {
      const uint k = atomic_inc(&team->count);
      if (k < CC_NEIGHBOURS) team->keys[k] = ccKeyOf(d.x + 1 + 3 * (d.y + 1) + 9 * (d.z + 1), b);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

void ccJoin(__global const CcSprout* bins, __global const CcSums* sums, uint b,
            __local CcTeam* team) {
  const uint s = get_local_id(0);
  if (s < 2) {
    double normal[3];
    for (int i = 0; i < 3; ++i) {
      normal[i] = team->faces.normal[s][i] + bins[b].faces.normal[s][i];
      team->faces.normal[s][i] = normal[i];
    }
    team->faces.length[s] = ccLength64(normal);
    team->size[s] += sums[b].side[s].size;
  }
  if (s == 2) team->cells[b].w = 1;
}

// The patch that begins with the bin `seed`; its bins go to `queue`. Returns how many there are.
uint ccGrowFrom(__global const CcSprout* bins, __global const CcSums* sums, uint all, uint seed,
                double close, __global uint* queue, __local CcTeam* team) {
  const uint lid = get_local_id(0);
  uint length = 1;
  if (lid == 0) {
    queue[0] = seed;
    team->cells[seed].w = 1;
    team->faces = bins[seed].faces;
    for (int s = 0; s < 2; ++s) team->size[s] = sums[seed].side[s].size;
  }
  for (uint next = 0; next < length; ++next) {
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    const uint from = queue[next];
    ccNeighbours(all, from, team);
    const uint some = min(team->count, (uint)CC_NEIGHBOURS);
    // Nearly always a work-item has one neighbour at most, and keeps it.
    const CcSprout kept = bins[lid < some ? ccBinOfKey(team->keys[lid]) : from];
    int asked = -1;
    while (some > 0) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (lid == 0) team->first = CC_NONE;
      barrier(CLK_LOCAL_MEM_FENCE);
      const CcFaces faces = team->faces;
      const double weight = team->size[0] + team->size[1];
      for (uint k = lid; k < some; k += CC_TEAM) {
        const int key = team->keys[k];
        if (key <= asked) continue;
        CcSprout own = kept;
        if (k != lid) own = bins[ccBinOfKey(key)];
        int joins = ccAlike(&own.faces, &faces, CC_AGREE);
        if (!joins && own.weight >= CC_LEAST_LINK * weight) {
          const CcSprout there = bins[from];
          joins = ccLinked(&own.faces, &there.faces, own.weight, weight, own.center, there.center,
                           close);
        }
        if (joins) atomic_min(&team->first, key);
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      asked = team->first;
      if (asked == CC_NONE) break;
      if (lid == 3) queue[length] = ccBinOfKey(asked);
      ccJoin(bins, sums, ccBinOfKey(asked), team);
      ++length;
    }
  }
  return length;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccGrow(
    __global const CcPair* pairs, __global CcAnswer* answers, __global const CcSums* sums,
    __global const CcSprout* sprouts, __global uint* queues, __global CcGrown* scratch,
    __global CcGrown* grown, __global uint* counters, uint patchRoom) {
  __local CcTeam team;
  const uint lid = get_local_id(0), p = get_group_id(0);
  const CcAnswer answer = answers[p];
  if (answer.failed || answer.bins == 0) return;
  const double cell = pairs[p].cell * (answer.level == CC_LEVELS - 1 ? 2.0 : 1.0);
  __global const CcSprout* bins = sprouts + answer.firstBin;
  __global uint* queue = queues + answer.firstBin;
  __global CcGrown* own = scratch + answer.firstBin;
  ccTakeIn(bins, answer.bins, &team);
  uint done = 0, patches = 0;
  while (done < answer.bins) {
    const int seed = ccSeed(answer.bins, &team);
    const uint length = ccGrowFrom(bins, sums + answer.firstBin, answer.bins, (uint)seed,
                                   CC_CLOSE * cell, queue + done, &team);
    if (lid == 0) {
      const CcGrown g = {answer.firstBin + done, answer.firstBin + done + length};
      own[patches] = g;
    }
    done += length;
    ++patches;
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
  if (lid == 0) team.place = atomic_add(&counters[CC_PATCHES], patches);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  const uint place = team.place;
  const int fits = place + patches <= patchRoom;
  for (uint k = lid; k < patches && fits; k += CC_TEAM) grown[place + k] = own[k];
  for (uint k = lid; k < answer.bins; k += CC_TEAM) queue[k] += answer.firstBin;
  if (lid == 0) {
    answers[p].firstPatch = place;
    answers[p].patches = patches;
    if (!fits) answers[p].failed = CC_NO_BINS;
  }
}

// Sums of patches, bin by bin in the order in which they came.
__kernel void ccPatches(__global const CcSums* sums, __global const uint* queues,
                        __global const CcGrown* grown, __global const uint* counters,
                        uint patchRoom, __global CcSums* patches) {
  const uint all = min(counters[CC_PATCHES], patchRoom);
  for (uint k = get_global_id(0); k < all; k += get_global_size(0)) {
    const CcGrown g = grown[k];
    CcSums patch = sums[queues[g.begin]];
    for (uint i = g.begin + 1; i < g.end; ++i) ccJoinSums(&patch, &sums[queues[i]]);
    patches[k] = patch;
  }
}
