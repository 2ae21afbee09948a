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
    s.patch = -1;
    sprouts[b] = s;
  }
}

// The heaviest bin without a patch, of equals the first; CC_NONE where all have one.
int ccSeed(__global const CcSprout* bins, uint all, __local double* weights, __local int* numbers) {
  const uint lid = get_local_id(0);
  double weight = -1.0;
  int number = CC_NONE;
  for (uint b = lid; b < all; b += CC_TEAM)
    if (bins[b].patch < 0 && (number == CC_NONE || bins[b].weight > weight)) {
      weight = bins[b].weight;
      number = (int)b;
    }
  barrier(CLK_LOCAL_MEM_FENCE);
  weights[lid] = weight;
  numbers[lid] = number;
  for (uint step = CC_TEAM / 2; step > 0; step /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid < step && numbers[lid + step] != CC_NONE &&
        (numbers[lid] == CC_NONE || weights[lid + step] > weights[lid] ||
         (weights[lid + step] == weights[lid] && numbers[lid + step] < numbers[lid]))) {
      weights[lid] = weights[lid + step];
      numbers[lid] = numbers[lid + step];
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return numbers[0];
}

// Neighbours of a bin without a patch, by the order in which they are asked: cell by cell, of a
// cell's bins the last first.
void ccNeighbours(__global const CcSprout* bins, uint all, uint from, __local int* keys,
                  __local uint* count) {
  const uint lid = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  if (lid == 0) *count = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  const int x = bins[from].cell[0], y = bins[from].cell[1], z = bins[from].cell[2];
  for (uint b = lid; b < all; b += CC_TEAM) {
    const int dx = bins[b].cell[0] - x, dy = bins[b].cell[1] - y, dz = bins[b].cell[2] - z;
    const int near = (dx >= -1) & (dx <= 1) & (dy >= -1) & (dy <= 1) & (dz >= -1) & (dz <= 1);
    if (near && bins[b].patch < 0) {
      const uint k = atomic_inc(count);
      if (k < CC_NEIGHBOURS)
        keys[k] = (dx + 1 + 3 * (dy + 1) + 9 * (dz + 1)) * CC_MOST_BINS + (CC_MOST_BINS - 1) - (int)b;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// A patch that grows.
typedef struct {
  CcFaces faces;
  double size[2];
} CcGrowing;

// The patch that begins with the bin `seed`; its bins go to `queue`. Returns how many there are.
uint ccGrowFrom(__global CcSprout* bins, __global const CcSums* sums, uint all, uint seed,
                int number, double close, __global uint* queue, __local CcGrowing* patch,
                __local int* keys, __local uint* count, __local int* first) {
  const uint lid = get_local_id(0);
  uint length = 1;
  if (lid == 0) {
    queue[0] = seed;
    bins[seed].patch = number;
    patch->faces = bins[seed].faces;
    for (int s = 0; s < 2; ++s) patch->size[s] = sums[seed].side[s].size;
  }
  for (uint next = 0; next < length; ++next) {
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    const uint from = queue[next];
    ccNeighbours(bins, all, from, keys, count);
    const CcFaces fromFaces = bins[from].faces;
    const double fromCenter[3] = {bins[from].center[0], bins[from].center[1], bins[from].center[2]};
    const uint some = *count;
    int asked = -1;
    while (true) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (lid == 0) *first = CC_NONE;
      barrier(CLK_LOCAL_MEM_FENCE);
      const CcFaces faces = patch->faces;
      const double weight = patch->size[0] + patch->size[1];
      for (uint k = lid; k < some; k += CC_TEAM) {
        const int key = keys[k];
        if (key <= asked || key > *first) continue;
        const uint b = (uint)((CC_MOST_BINS - 1) - key % CC_MOST_BINS);
        const CcFaces own = bins[b].faces;
        const double center[3] = {bins[b].center[0], bins[b].center[1], bins[b].center[2]};
        if (ccAlike(&own, &faces, CC_AGREE) ||
            ccLinked(&own, &fromFaces, bins[b].weight, weight, center, fromCenter, close))
          atomic_min(first, key);
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      asked = *first;
      if (asked == CC_NONE) break;
      const uint b = (uint)((CC_MOST_BINS - 1) - asked % CC_MOST_BINS);
      if (lid < 2) {
        double normal[3];
        for (int i = 0; i < 3; ++i) {
          normal[i] = patch->faces.normal[lid][i] + bins[b].faces.normal[lid][i];
          patch->faces.normal[lid][i] = normal[i];
        }
        patch->faces.length[lid] = ccLength64(normal);
        patch->size[lid] += sums[b].side[lid].size;
      }
      if (lid == 2) {
        bins[b].patch = number;
        queue[length] = b;
      }
      ++length;
    }
  }
  return length;
}

__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccGrow(
    __global const CcPair* pairs, __global CcAnswer* answers, __global const CcSums* sums,
    __global CcSprout* sprouts, __global uint* queues, __global CcGrown* scratch,
    __global CcGrown* grown, __global uint* counters, uint patchRoom) {
  __local CcGrowing patch;
  __local double weights[CC_TEAM];
  __local int numbers[CC_TEAM], keys[CC_NEIGHBOURS], first;
  __local uint count, place;
  const uint lid = get_local_id(0), p = get_group_id(0);
  const CcAnswer answer = answers[p];
  if (answer.failed || answer.bins == 0) return;
  const double cell = pairs[p].cell * (answer.level == CC_LEVELS - 1 ? 2.0 : 1.0);
  __global CcSprout* bins = sprouts + answer.firstBin;
  __global uint* queue = queues + answer.firstBin;
  __global CcGrown* own = scratch + answer.firstBin;
  uint done = 0, patches = 0;
  while (done < answer.bins) {
    const int seed = ccSeed(bins, answer.bins, weights, numbers);
    const uint length =
        ccGrowFrom(bins, sums + answer.firstBin, answer.bins, (uint)seed, (int)patches,
                   CC_CLOSE * cell, queue + done, &patch, keys, &count, &first);
    if (lid == 0) {
      const CcGrown g = {answer.firstBin + done, answer.firstBin + done + length};
      own[patches] = g;
    }
    done += length;
    ++patches;
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
  if (lid == 0) place = atomic_add(&counters[CC_PATCHES], patches);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  const int fits = place + patches <= patchRoom;
  for (uint k = lid; k < patches && fits; k += CC_TEAM) {
    CcGrown g = own[k];
    grown[place + k] = g;
  }
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
