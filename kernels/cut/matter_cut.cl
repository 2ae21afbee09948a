// Removes material from a workpiece, step by step, with the arithmetic of window_sums.h (on the
// CPU: plugin/field/brick_changes.cpp). First the loss of each voxel is recorded, and the
// bricks whose windows contain such a voxel are listed. Then each listed brick gathers the losses
// within its windows. One work-item computes each sum alone, so no sum depends on the order of the
// work-items.
//
// Every brick with matter has a block reserved from the start, its home. Until a cut comes near,
// `table` may still refer to a shared block instead.

CcVoxelLeft ccNamed(__global const uint* step, uint i) {
  return ((__global const CcVoxelLeft*)(step + CC_STEP_HEAD))[i];
}

uint ccBrickOf(const CcCutting* g, CcVoxelLeft v) {
  return (v.x >> 3) + (uint)g->nx * ((v.y >> 3) + (uint)g->ny * (v.z >> 3));
}

// The index of a voxel among the voxels of all homes.
size_t ccPlace(int home, CcVoxelLeft v) {
  return (size_t)home * CC_BRICK_VOXELS + ((v.x & 7) | (v.y & 7) << 3 | (v.z & 7) << 6);
}

// Chains the entries of a step that cut the same voxel. `last` holds the head of a voxel's chain
// and `next` the rest, as index plus one; 0 ends it. Also clears the losses of the step before.
__kernel void ccStringCuts(CcCutting g, __global const int* home, __global const int* table,
                           __global const CcBlock* blocks, __global const uint* step, uint count,
                           __global const uint* before, uint countBefore, __global uint* next,
                           __global uint* last, __global ushort* lost) {
  const uint i = get_global_id(0);
  if (i < countBefore) {
    const CcVoxelLeft v = ccNamed(before, i);
    const int h = home[ccBrickOf(&g, v)];
    if (h >= 0) lost[ccPlace(h, v)] = 0;
  }
  if (i >= count) return;
  const CcVoxelLeft v = ccNamed(step, i);
  const uint brick = ccBrickOf(&g, v);
  const int h = home[brick];
  next[i] = CC_NO_CHANGE;
  if (h < 0) return;
  const size_t place = ccPlace(h, v);
  if (blocks[table[brick]].coverage[place % CC_BRICK_VOXELS] > v.left)
    next[i] = atomic_xchg(&last[place], i + 1u);
}

// Lists the voxel's brick and all bricks with a window that may contain the voxel.
void ccListBricks(const CcCutting* g, __global const int* home, CcVoxelLeft v, __global uint* step,
                  __global uint* listed, __global uint* list) {
  const int x0 = max((v.x - max(g->high[0], 0)) >> 3, 0),
            y0 = max((v.y - max(g->high[1], 0)) >> 3, 0),
            z0 = max((v.z - max(g->high[2], 0)) >> 3, 0),
            x1 = min((v.x - min(g->low[0], 0)) >> 3, g->nx - 1),
            y1 = min((v.y - min(g->low[1], 0)) >> 3, g->ny - 1),
            z1 = min((v.z - min(g->low[2], 0)) >> 3, g->nz - 1);
  for (int z = z0; z <= z1; ++z)
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const uint e = (uint)x + (uint)g->nx * ((uint)y + (uint)g->ny * (uint)z);
        if (listed[e] != 0u || home[e] < 0) continue;
        if (atomic_xchg(&listed[e], 1u) == 0u) list[atomic_inc(&step[CC_AFFECTED])] = e;
      }
}

// For a voxel with many entries, one work-item goes through the chain from `last` for all of them.
// Returns how many entries lower the voxel when applied in order, and sets *least to what remains.
// An entry lowers the voxel if it comes before every entry with the same or a smaller value. Each
// pass over the chain finds the first entries of CC_LEFTS values, smallest values first; the search
// ends when it has counted the voxel's earliest entry.
uint ccTimesThatLower(__global const uint* step, __global const uint* next, uint last,
                      ushort* least) {
  uint lower = 0u, first = 0xffffffffu, earliest = 0u;
  for (uint from = 0u; from < 256u && first != earliest; from += CC_LEFTS) {
    uint named[CC_LEFTS];
    for (int m = 0; m < CC_LEFTS; ++m) named[m] = 0xffffffffu;
    earliest = last;
    for (uint k = last; k > 0u; k = next[k - 1u]) {
      const uint left = ccNamed(step, k - 1u).left - from;
      if (left < CC_LEFTS) named[left] = min(named[left], k);
      earliest = min(earliest, k);
    }
    for (int m = 0; m < CC_LEFTS; ++m) {
      if (named[m] >= first) continue;
      if (lower == 0u) *least = (ushort)(from + m);
      first = named[m];
      ++lower;
    }
  }
  return lower;
}

// Counts the entries that lower their voxel when applied in order. The first entry with the voxel's
// smallest value records the voxel's loss. Each entry is compared with all others of its voxel.
// With more than CC_FEW of them, one work-item does it for all, since m entries would take m * m
// steps.
__kernel __attribute__((reqd_work_group_size(CC_STEP_GROUP, 1, 1))) void ccNoteLosses(
    CcCutting g, __global const int* home, __global const int* table,
    __global const CcBlock* blocks, __global uint* step, uint count, __global const uint* next,
    __global const uint* last, __global ushort* lost, __global uint* listed, __global uint* list) {
  __local uint changed;
  const uint i = get_global_id(0);
  if (get_local_id(0) == 0) changed = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (i < count && next[i] != CC_NO_CHANGE) {
    CcVoxelLeft v = ccNamed(step, i);
    const uint brick = ccBrickOf(&g, v);
    const size_t place = ccPlace(home[brick], v);
    uint lowers = 1u, k = last[place];
    int least = 1;
    for (int n = 0; k > 0u && n < CC_FEW; ++n) {
      const int left = ccNamed(step, k - 1u).left;
      lowers &= !(k <= i && left <= v.left);
      least &= left >= v.left;
      k = next[k - 1u];
    }
    if (k > 0u) {
      least = last[place] == i + 1u;
      lowers = least ? ccTimesThatLower(step, next, i + 1u, &v.left) : 0u;
    }
    if (lowers) atomic_add(&changed, lowers);
    if (lowers && least) {
      __global const CcBlock* const block = blocks + table[brick];
      const int cell = (int)(place % CC_BRICK_VOXELS);
      lost[place] = CC_LOSS_OF(block->coverage[cell] - v.left, block->tissue[cell]);
      ccListBricks(&g, home, v, step, listed, list);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0 && changed > 0u) atomic_add(&step[CC_CHANGED], changed);
}

// The first of the CC_DEEP voxels, above each other, that a work-item updates.
int ccFirstVoxel(void) {
  const uint lid = get_local_id(0);
  return (int)((lid & 63u) | (lid >> 6) * CC_DEEP << 6);
}

// Records the losses of all voxels in an area, one group for each brick. `bricksX`, `bricksY`:
// number of bricks along x and y, from the brick of the area's lowest voxel.
__kernel __attribute__((reqd_work_group_size(CC_RENEW_GROUP, 1, 1))) void ccNoteArea(
    CcCutting g, CcArea area, int bricksX, int bricksY, __global const int* home,
    __global const int* table, __global const CcBlock* blocks, __global uint* step,
    __global ushort* lost, __global uint* listed, __global uint* list) {
  __local uint changed;
  const int n = (int)get_group_id(0);
  const int bx = (area.low[0] >> 3) + n % bricksX, by = (area.low[1] >> 3) + n / bricksX % bricksY,
            bz = (area.low[2] >> 3) + n / bricksX / bricksY;
  const int e = bx + g.nx * (by + g.ny * bz), h = home[e];
  if (h < 0) return;
  if (get_local_id(0) == 0) changed = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  __global const CcBlock* const block = blocks + table[e];
  for (int m = 0; m < CC_DEEP; ++m) {
    const int voxel = ccFirstVoxel() | m << 6;
    const int x = 8 * bx + (voxel & 7), y = 8 * by + (voxel >> 3 & 7), z = 8 * bz + (voxel >> 6);
    if (x < area.low[0] || y < area.low[1] || z < area.low[2] || x > area.high[0] ||
        y > area.high[1] || z > area.high[2])
      continue;
    const int left = ccAreaLeaves(&area, x, y, z), coverage = block->coverage[voxel];
    if (coverage <= left) continue;
    CcVoxelLeft v;
    v.x = (ushort)x;
    v.y = (ushort)y;
    v.z = (ushort)z;
    v.left = (ushort)left;
    lost[ccPlace(h, v)] = CC_LOSS_OF(coverage - left, block->tissue[voxel]);
    atomic_inc(&changed);
    ccListBricks(&g, home, v, step, listed, list);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0 && changed > 0u) atomic_add(&step[CC_CHANGED], changed);
}

// Clears the losses that an area's step recorded.
__kernel __attribute__((reqd_work_group_size(CC_RENEW_GROUP, 1, 1))) void ccForgetArea(
    __global const int* home, __global const uint* list, __global const uint* step,
    __global ushort* lost) {
  const uint count = step[CC_AFFECTED];
  for (uint n = get_group_id(0); n < count; n += get_num_groups(0))
    for (int m = 0; m < CC_DEEP; ++m)
      lost[(size_t)home[list[n]] * CC_BRICK_VOXELS + (ccFirstVoxel() | m << 6)] = 0;
}

// Subtracts the recorded losses from the brick's voxels. A brick that used a shared block is first
// copied to its home. Also clears the chains of ccStringCuts().
void ccTakeMatter(int from, int home, __global CcBlock* blocks, __global const ushort* lost,
                  __global uint* last) {
  __global const CcBlock* const old = blocks + from;
  __global CcBlock* const block = blocks + home;
  const int first = ccFirstVoxel();
  const size_t places = (size_t)home * CC_BRICK_VOXELS;
  int loss[CC_DEEP];
  for (int m = 0; m < CC_DEEP; ++m) loss[m] = lost[places + (first | m << 6)] & 255;
  for (int m = 0; m < CC_DEEP; ++m) {
    const int voxel = first | m << 6;
    if (from != home) {
      block->moments[voxel] = old->moments[voxel];
      block->volume[voxel] = old->volume[voxel];
      block->coverage[voxel] = old->coverage[voxel];
      block->tissue[voxel] = old->tissue[voxel];
    }
    if (loss[m] == 0) continue;
    const int left = block->coverage[voxel] - loss[m];
    block->coverage[voxel] = (uchar)left;
    if (left == 0) block->tissue[voxel] = 0;
    last[places + voxel] = 0u;
  }
}

// The home of the k-th of the 27 bricks around brick `e`; -1 if there is none.
int ccHomeBeside(const CcCutting* g, __global const int* home, uint e, uint k) {
  const int x = (int)(e % (uint)g->nx) + (int)(k % 3u) - 1,
            y = (int)(e / (uint)g->nx % (uint)g->ny) + (int)(k / 3u % 3u) - 1,
            z = (int)(e / (uint)g->nx / (uint)g->ny) + (int)(k / 9u) - 1;
  const int inside = (x >= 0) & (y >= 0) & (z >= 0) & (x < g->nx) & (y < g->ny) & (z < g->nz);
  return inside ? home[x + g->nx * (y + g->ny * z)] : -1;
}

// Fills the tile with the losses of one density, for the voxels of a brick and around it. A half
// holds a loss exactly. `columns` gets a bit for each voxel with a loss, one word for each column
// of the tile along z. Each work-item copies the part of a row in one brick.
void ccLayOutLosses(const CcCutting* g, __local const int* about, __global const ushort* lost,
                    __global const uchar* kindOf, int kind, __local half* tile,
                    __local uint* columns) {
  const int edgeY = 8 + g->high[1] - g->low[1], edgeZ = 8 + g->high[2] - g->low[2];
  const int rows = edgeY * edgeZ, perY = ((1 << 16) + edgeY - 1) / edgeY;
  for (int item = (int)get_local_id(0); item < 3 * rows; item += CC_RENEW_GROUP) {
    const int part = (item >= rows) + (item >= 2 * rows), row = item - part * rows;
    const int rowZ = row * perY >> 16, rowY = row - edgeY * rowZ;
    const int y = rowY + g->low[1] + 8, z = rowZ + g->low[2] + 8;
    const int begin = part == 0 ? 8 + g->low[0] : 0, end = part == 2 ? g->high[0] : 8;
    const int home = about[part + 3 * (y >> 3) + 9 * (z >> 3)];
    ushort l[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    if (home >= 0)
      vstore8(vload8(0, lost + (size_t)home * CC_BRICK_VOXELS + ((y & 7) << 3 | (z & 7) << 6)), 0,
              l);
    const int to = 8 * part - 8 - g->low[0];
    for (int x = 0; x < 8; ++x) {
      if (x < begin || x >= end) continue;
      const int loss = kindOf[l[x] >> 8] == kind ? l[x] & 255 : 0;
      vstore_half((float)loss, CC_TILE_ROW * row + to + x, tile);
      if (loss) atomic_or(&columns[CC_TILE_ROW * rowY + to + x], 1u << rowZ);
    }
  }
}

// Losses in the windows of a work-item's voxels: sums of loss times weight, and times place.
typedef struct {
  float mass[CC_DEEP], x[CC_DEEP], y[CC_DEEP], z[CC_DEEP];
} CcLosses;

// Sums over the window's taps. From tap to tap a work-item keeps all but one of the losses it has
// read. Columns of the tile without a loss, most of them in a sparse cut, are skipped. `column`:
// the work-item's column in the tile; `up`: the layer of its first voxel.
void ccSumLosses(const CcCutting* g, __local const float4* by, __local const CcFlatRun* runs,
                 uint runCount, __local const half* tile, __local const uint* columns, int column,
                 int up, CcLosses* sums) {
  const int layer = CC_TILE_ROW * (8 + g->high[1] - g->low[1]);
  for (int m = 0; m < CC_DEEP; ++m) sums->mass[m] = sums->x[m] = sums->y[m] = sums->z[m] = 0.0f;
  for (uint r = 0; r < runCount; ++r) {
    const CcFlatRun run = runs[r];
    const int there = column + run.offset - layer * (run.above + g->low[2]);
    const int low = up + run.above;
    if (!(columns[there] >> low & ((1u << (run.count + CC_DEEP - 1)) - 1u))) continue;
    __local const float4* const weights = by + run.first;
    __local const half* const seen = tile + there + layer * low;
    float c[CC_DEEP];
#pragma unroll
    for (int m = 0; m < CC_DEEP - 1; ++m) c[m] = vload_half(m * layer, seen);
#pragma unroll
    for (int t = 0; t < CC_RUN; ++t) {
      if (t < run.count) {
        const float4 w = weights[t];
        c[(t + CC_DEEP - 1) % CC_DEEP] = vload_half((t + CC_DEEP - 1) * layer, seen);
#pragma unroll
        for (int m = 0; m < CC_DEEP; ++m) {
          const float loss = c[(m + t) % CC_DEEP];
          sums->mass[m] = CC_ADD_PRODUCT(loss, w.x, sums->mass[m]);
          sums->x[m] = CC_ADD_PRODUCT(loss, w.y, sums->x[m]);
          sums->y[m] = CC_ADD_PRODUCT(loss, w.z, sums->y[m]);
          sums->z[m] = CC_ADD_PRODUCT(loss, w.w, sums->z[m]);
        }
      }
    }
  }
}

// Subtracts the losses from the window sums. The host has made sure that sums of loss times weight
// stay below 2^24, so a float holds them exactly. The common factor, the density, is applied here.
// All voxels are read before the first is written.
void ccTakeLosses(const CcLosses* sums, double density, __global CcBlock* block) {
  const int first = ccFirstVoxel();
  double4 moments[CC_DEEP];
  double volume[CC_DEEP];
  for (int m = 0; m < CC_DEEP; ++m) {
    if (sums->mass[m] == 0.0f) continue;  // weights are positive
    moments[m] = vload4(0, (__global double*)&block->moments[first | m << 6]);
    volume[m] = block->volume[first | m << 6];
  }
  for (int m = 0; m < CC_DEEP; ++m) {
    if (sums->mass[m] == 0.0f) continue;
    const double4 less = (double4)(density * sums->mass[m], density * sums->x[m],
                                   density * sums->y[m], density * sums->z[m]);
    vstore4(moments[m] - less, 0, (__global double*)&block->moments[first | m << 6]);
    block->volume[first | m << 6] = volume[m] - sums->mass[m];
  }
}

// Updates the listed bricks. The window's weights are copied to local memory, where reads of them
// take less time than from constant memory (a cut of 1,000 voxels: 16 us instead of 22).
__kernel __attribute__((reqd_work_group_size(CC_RENEW_GROUP, 1, 1))) void ccRenewWindows(
    CcCutting g, __global const int* restrict home, __global int* restrict table,
    __global CcBlock* restrict blocks, __global const ushort* restrict lost,
    __global uint* restrict last, __global uint* restrict listed,
    __global const uint* restrict list, __global const uint* restrict step,
    __global const uchar* restrict kindOf, __global const int* restrict densities,
    __global const float4* restrict by, __global const CcFlatRun* restrict runs, uint runCount,
    __local float4* ownBy, __local CcFlatRun* ownRuns, __local half* tile) {
  __local int about[27];
  __local uint columns[CC_TILE_ROW * CC_TILE_ROW];
  const int lid = (int)get_local_id(0), first = ccFirstVoxel();
  const uint count = step[CC_AFFECTED];
  const int layer = CC_TILE_ROW * (8 + g.high[1] - g.low[1]);
  const int column = (first & 7) - g.low[0] + CC_TILE_ROW * ((first >> 3 & 7) - g.low[1]);
  if (get_group_id(0) >= count) return;
  for (int k = lid; k < g.taps; k += CC_RENEW_GROUP) ownBy[k] = by[k];
  for (int k = lid; k < (int)runCount; k += CC_RENEW_GROUP) ownRuns[k] = runs[k];
  for (uint n = get_group_id(0); n < count; n += get_num_groups(0)) {
    const uint e = list[n];
    const int own = home[e];
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid < 27) about[lid] = ccHomeBeside(&g, home, e, (uint)lid);
    ccTakeMatter(table[e], own, blocks, lost, last);
    for (int kind = 0; kind < g.kinds; ++kind) {
      for (int k = lid; k < layer; k += CC_RENEW_GROUP) columns[k] = 0u;
      barrier(CLK_LOCAL_MEM_FENCE);
      ccLayOutLosses(&g, about, lost, kindOf, kind, tile, columns);
      barrier(CLK_LOCAL_MEM_FENCE);
      CcLosses sums;
      ccSumLosses(&g, ownBy, ownRuns, runCount, tile, columns, column, first >> 6, &sums);
      ccTakeLosses(&sums, densities[kind], blocks + own);
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (lid == 0) {
      table[e] = own;
      listed[e] = 0u;
    }
  }
}

// Like ccRenewWindows(), for windows of any size. Reads each tap's voxel from global memory.
__kernel __attribute__((reqd_work_group_size(CC_RENEW_GROUP, 1, 1))) void ccRenewAnyWindows(
    CcCutting g, __global const int* home, __global int* table, __global CcBlock* blocks,
    __global const ushort* lost, __global uint* last, __global uint* listed,
    __global const uint* list, __global const uint* step, __global const uchar* kindOf,
    __global const int* densities, __global const CcWindowTap* taps) {
  const uint count = step[CC_AFFECTED];
  for (uint n = get_group_id(0); n < count; n += get_num_groups(0)) {
    const uint e = list[n];
    const int own = home[e];
    const int x = 8 * (int)(e % (uint)g.nx), y = 8 * (int)(e / (uint)g.nx % (uint)g.ny),
              z = 8 * (int)(e / (uint)g.nx / (uint)g.ny);
    ccTakeMatter(table[e], own, blocks, lost, last);
    for (int m = 0; m < CC_DEEP; ++m) {
      const int k = ccFirstVoxel() | m << 6;
      CcMoments moments = blocks[own].moments[k];
      CcSum volume = blocks[own].volume[k];
      for (int t = 0; t < g.taps; ++t) {
        const CcWindowTap tap = taps[t];
        const int i = x + (k & 7) + tap.x, j = y + (k >> 3 & 7) + tap.y, l = z + (k >> 6) + tap.z;
        if ((i < 0) | (j < 0) | (l < 0) | (i >= 8 * g.nx) | (j >= 8 * g.ny) | (l >= 8 * g.nz))
          continue;
        const int there = home[(i >> 3) + g.nx * ((j >> 3) + g.ny * (l >> 3))];
        if (there < 0) continue;
        const ushort loss =
            lost[(size_t)there * CC_BRICK_VOXELS + ((i & 7) | (j & 7) << 3 | (l & 7) << 6)];
        if (loss == 0) continue;
        ccWeigh(&moments, tap.tap, -(loss & 255) * densities[kindOf[loss >> 8]]);
        volume -= (CcSum)((loss & 255) * tap.tap.weight);
      }
      blocks[own].moments[k] = moments;
      blocks[own].volume[k] = volume;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0) {
      table[e] = own;
      listed[e] = 0u;
    }
  }
}

// Sums each tissue in a brick: coverage times powers of the coordinates in the brick. Each
// work-item first sums one row along x. `bricks`: the brick of each home; the homes follow the
// shared blocks.
__kernel __attribute__((reqd_work_group_size(CC_ROWS, 1, 1))) void ccSumTissues(
    __global const int* table, __global const CcBlock* blocks, __global const uint* bricks,
    uint count, uint tissues, __global CcTissueSums* sums) {
  __local int zeroth[CC_ROWS], first[CC_ROWS], second[CC_ROWS];
  const int row = (int)get_local_id(0);
  for (uint n = get_group_id(0); n < count; n += get_num_groups(0)) {
    __global const CcBlock* const block = blocks + table[bricks[n]];
    uchar coverage[8], tissue[8];
    vstore8(vload8(row, block->coverage), 0, coverage);
    vstore8(vload8(row, block->tissue), 0, tissue);
    for (uint t = 0; t < tissues; ++t) {
      int s0 = 0, s1 = 0, s2 = 0;
      for (int x = 0; x < 8; ++x) {
        const int c = tissue[x] == t ? coverage[x] : 0;
        s0 += c;
        s1 += c * x;
        s2 += c * x * x;
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      zeroth[row] = s0;
      first[row] = s1;
      second[row] = s2;
      barrier(CLK_LOCAL_MEM_FENCE);
      if (row < CC_TISSUE_SUMS) {
        int sum = 0;
        for (int k = 0; k < CC_ROWS; ++k) {
          const int y = k & 7, z = k >> 3;
          sum += row == CC_SUM_X    ? first[k]
                 : row == CC_SUM_XX ? second[k]
                 : row == CC_SUM_XY ? first[k] * y
                 : row == CC_SUM_ZX ? first[k] * z
                 : row == CC_SUM_Y  ? zeroth[k] * y
                 : row == CC_SUM_Z  ? zeroth[k] * z
                 : row == CC_SUM_YY ? zeroth[k] * y * y
                 : row == CC_SUM_ZZ ? zeroth[k] * z * z
                 : row == CC_SUM_YZ ? zeroth[k] * y * z
                                    : zeroth[k];
        }
        sums[(size_t)n * tissues + t].sum[row] = sum;
      }
    }
  }
}
