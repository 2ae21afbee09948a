// Window sums of a body of one tissue, with the arithmetic of window_sums.h and the layout of
// plugin/field/brick_layout.cpp. Finds the bricks that need a block of their own, then fills
// these blocks with voxels and sums.

// Whether a brick needs a block of its own: it holds matter, and some brick that its windows reach
// is not full.
int ccOwnsBlock(const CcWindows* g, __global const int* table, uint e) {
  const int x = (int)(e % (uint)g->nx), y = (int)(e / (uint)g->nx % (uint)g->ny),
            z = (int)(e / (uint)g->nx / (uint)g->ny);
  const int x0 = (8 * x + min(g->low[0], 0)) >> 3, x1 = (8 * x + 7 + max(g->high[0], 0)) >> 3,
            y0 = (8 * y + min(g->low[1], 0)) >> 3, y1 = (8 * y + 7 + max(g->high[1], 0)) >> 3,
            z0 = (8 * z + min(g->low[2], 0)) >> 3, z1 = (8 * z + 7 + max(g->high[2], 0)) >> 3;
  int deep = table[e] == CC_SOLID_CODE && x0 >= 0 && y0 >= 0 && z0 >= 0 && x1 < g->nx &&
             y1 < g->ny && z1 < g->nz;
  for (int k = z0; deep && k <= z1; ++k)
    for (int j = y0; deep && j <= y1; ++j)
      for (int i = x0; deep && i <= x1; ++i)
        deep = table[i + g->nx * (j + g->ny * k)] == CC_SOLID_CODE;
  return table[e] != CC_EMPTY_CODE && !deep;
}

// Numbers the bricks that need a block, from 1 within each work-group (0: none), and counts them
// for each work-group.
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccOwnBlocks(
    CcWindows g, __global const int* table, uint count, __global uint* own,
    __global uint* groups) {
  __local uint room[2 * CC_GROUP];
  const uint e = get_global_id(0);
  const uint is = e < count && ccOwnsBlock(&g, table, e) ? 1u : 0u;
  const uint upTo = ccSumUpTo(room, is);
  if (e < count) own[e] = is ? upTo : 0u;
  if (get_local_id(0) == CC_GROUP - 1) groups[get_group_id(0)] = upTo;
}

// Writes the table of blocks. Block 0 is shared by all bricks whose windows are full. `first`: the
// number of blocks of the work-groups before. `list`: receives the bricks with a block, in order.
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccBlockTable(
    CcWindows g, __global const int* table, uint count, __global const uint* own,
    __global const uint* first, __global int* blockOf, __global uint* list) {
  const uint e = get_global_id(0);
  if (e >= count) return;
  const uint block = first[get_group_id(0)] + own[e];
  blockOf[e] = own[e] ? (int)block : table[e] == CC_EMPTY_CODE ? -1 : 0;
  if (own[e] && block < g.blockRoom) list[block - 1] = e;
}

int ccCoverageAt(const CcWindows* g, __global const int* table, __global const uchar* bricks,
                 int x, int y, int z) {
  if ((x < 0) | (y < 0) | (z < 0) | (x >= 8 * g->nx) | (y >= 8 * g->ny) | (z >= 8 * g->nz))
    return 0;
  const int brick = table[(x >> 3) + g->nx * ((y >> 3) + g->ny * (z >> 3))];
  if (brick < 0) return brick == CC_SOLID_CODE ? 255 : 0;
  return bricks[(size_t)brick * CC_BRICK_VOXELS + ((x & 7) | (y & 7) << 3 | (z & 7) << 6)];
}

// Fills the tile with the coverage of a brick and of all voxels that its windows reach. A half
// holds a coverage exactly. `about`: the 27 bricks. Each work-item copies the part of a row in one
// brick.
void ccLayOutTile(const CcWindows* g, __local const int* about, __global const uchar* bricks,
                  __local half* tile) {
  const int edgeY = 8 + g->high[1] - g->low[1], edgeZ = 8 + g->high[2] - g->low[2];
  const int rows = edgeY * edgeZ;
  for (int item = (int)get_local_id(0); item < 3 * rows; item += CC_COLUMNS) {
    const int part = item / rows, row = item - part * rows;
    const int y = row % edgeY + g->low[1] + 8, z = row / edgeY + g->low[2] + 8;
    const int brick = about[part + 3 * (y >> 3) + 9 * (z >> 3)];
    uchar8 coverage = brick == CC_SOLID_CODE ? (uchar8)(255) : (uchar8)(0);
    if (brick >= 0)
      coverage = vload8(0, bricks + (size_t)brick * CC_BRICK_VOXELS + ((y & 7) << 3 | (z & 7) << 6));
    uchar c[8];
    vstore8(coverage, 0, c);
    const int begin = part == 0 ? 8 + g->low[0] : 0, end = part == 2 ? g->high[0] : 8;
    __local half* const to = tile + CC_TILE_ROW * row + 8 * part - 8 - g->low[0];
    for (int x = 0; x < 8; ++x)
      if (x >= begin && x < end) vstore_half((float)c[x], x, to);
  }
}

// Fills the bricks' own blocks, from block 1 on. Each work-item sums the windows of eight voxels
// above each other; from tap to tap it keeps seven of the coverages it has read. The host has made
// sure that sums of coverage times weight stay below 2^24, so a float holds them exactly. The
// common factor, the density, is applied last.
__kernel __attribute__((reqd_work_group_size(CC_COLUMNS, 1, 1))) void ccSumWindows(
    CcWindows g, __global const int* restrict table, __global const uchar* restrict bricks,
    __constant float4* by, __constant CcFlatRun* runs, uint runCount,
    __global const uint* restrict list, __global const uint* restrict counters,
    __global CcBlock* restrict blocks, __local half* tile) {
  __local int about[27];
  const uint lid = get_local_id(0), count = counters[CC_OWN_BLOCKS];
  if (1u + count > g.blockRoom) return;
  const int layer = CC_TILE_ROW * (8 + g.high[1] - g.low[1]);
  const int here = (int)(lid & 7u) - g.low[0] +
                   CC_TILE_ROW * ((int)(lid >> 3) - g.low[1]) - layer * g.low[2];
  const double density = g.density;
  for (uint n = get_group_id(0); n < count; n += get_num_groups(0)) {
    const uint e = list[n];
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid < 27u) {
      const int x = (int)(e % (uint)g.nx) + (int)(lid % 3u) - 1,
                y = (int)(e / (uint)g.nx % (uint)g.ny) + (int)(lid / 3u % 3u) - 1,
                z = (int)(e / (uint)g.nx / (uint)g.ny) + (int)(lid / 9u) - 1;
      const int inside = (x >= 0) & (y >= 0) & (z >= 0) & (x < g.nx) & (y < g.ny) & (z < g.nz);
      about[lid] = inside ? table[x + g.nx * (y + g.ny * z)] : CC_EMPTY_CODE;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    ccLayOutTile(&g, about, bricks, tile);
    barrier(CLK_LOCAL_MEM_FENCE);
    float mass[8], mx[8], my[8], mz[8], c[8];
    for (int m = 0; m < 8; ++m) mass[m] = mx[m] = my[m] = mz[m] = 0.0f;
    for (uint r = 0; r < runCount; ++r) {
      const int taps = runs[r].count;
      __constant const float4* const own = by + runs[r].first;
      __local const half* const seen = tile + here + runs[r].offset;
#pragma unroll
      for (int m = 0; m < 7; ++m) c[m] = vload_half(m * layer, seen);
#pragma unroll
      for (int t = 0; t < CC_RUN; ++t) {
        if (t < taps) {
          const float4 w = own[t];
          c[(t + 7) & 7] = vload_half((t + 7) * layer, seen);
#pragma unroll
          for (int m = 0; m < 8; ++m) {
            mass[m] = CC_ADD_PRODUCT(c[(m + t) & 7], w.x, mass[m]);
            mx[m] = CC_ADD_PRODUCT(c[(m + t) & 7], w.y, mx[m]);
            my[m] = CC_ADD_PRODUCT(c[(m + t) & 7], w.z, my[m]);
            mz[m] = CC_ADD_PRODUCT(c[(m + t) & 7], w.w, mz[m]);
          }
        }
      }
    }
    __global CcBlock* const block = blocks + 1u + n;
    for (int m = 0; m < 8; ++m) {
      const uint voxel = lid | (uint)m << 6;
      vstore4((double4)(density * mass[m], density * mx[m], density * my[m], density * mz[m]), 0,
              (__global double*)&block->moments[voxel]);
      block->volume[voxel] = mass[m];
      block->coverage[voxel] = (uchar)vload_half(here + m * layer, tile);
      block->tissue[voxel] = 0;
    }
  }
}

// For windows of any size: this kernel fills the blocks' voxels, ccSumAnyWindows() their sums.
__kernel void ccFillBlocks(CcWindows g, __global const int* table, __global const uchar* bricks,
                           __global const uint* list, __global const uint* counters,
                           __global CcBlock* blocks) {
  const uint count = counters[CC_OWN_BLOCKS];
  if (1u + count > g.blockRoom) return;
  for (size_t i = get_global_id(0); i < ((size_t)count + 1) * CC_BRICK_VOXELS;
       i += get_global_size(0)) {
    const size_t n = i / CC_BRICK_VOXELS;
    const int k = (int)(i % CC_BRICK_VOXELS);
    blocks[n].tissue[k] = 0;
    if (n == 0) {
      blocks[n].coverage[k] = 255;
      continue;
    }
    const uint e = list[n - 1];
    blocks[n].coverage[k] = (uchar)ccCoverageAt(
        &g, table, bricks, 8 * (int)(e % (uint)g.nx) + (k & 7),
        8 * (int)(e / (uint)g.nx % (uint)g.ny) + (k >> 3 & 7),
        8 * (int)(e / (uint)g.nx / (uint)g.ny) + (k >> 6));
  }
}

__kernel void ccSumAnyWindows(CcWindows g, __global const int* blockOf,
                              __global const CcWindowTap* taps, __global const int* density,
                              __global const uint* list, __global const uint* counters,
                              __global CcBlock* blocks) {
  const uint count = counters[CC_OWN_BLOCKS];
  if (1u + count > g.blockRoom) return;
  CcWorkpiece workpiece;
  workpiece.nx = g.nx;
  workpiece.ny = g.ny;
  workpiece.nz = g.nz;
  workpiece.table = blockOf;
  workpiece.blocks = blocks;
  workpiece.density = density;
  for (size_t i = get_global_id(0); i < (size_t)count * CC_BRICK_VOXELS;
       i += get_global_size(0)) {
    const uint e = list[i / CC_BRICK_VOXELS];
    const int k = (int)(i % CC_BRICK_VOXELS);
    CcMoments moments;
    CcSum volume;
    ccWindowSum(&workpiece, taps, g.taps, 8 * (int)(e % (uint)g.nx) + (k & 7),
                8 * (int)(e / (uint)g.nx % (uint)g.ny) + (k >> 3 & 7),
                8 * (int)(e / (uint)g.nx / (uint)g.ny) + (k >> 6), &moments, &volume);
    __global CcBlock* const block = blocks + 1 + i / CC_BRICK_VOXELS;
    block->moments[k] = moments;
    block->volume[k] = volume;
  }
}
