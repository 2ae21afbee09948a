// Sums the pieces that columns.cl cut to bricks of differences, and these to coverages.

size_t ccTableAt(const CcColumns* g, uint bin, int layer) {
  int b[3];
  b[g->u] = (int)(bin % (uint)g->width);
  b[g->v] = (int)(bin / (uint)g->width);
  b[g->w] = layer;
  return (size_t)b[0] + (size_t)g->nx * ((size_t)b[1] + (size_t)g->ny * (size_t)b[2]);
}

// One group for each brick-wide column. Each layer with a piece gets a brick of differences. Its
// index plus one replaces the layer's flag in `touched`, and `placed` lists the layer under that
// index. The bricks need no order.
__kernel __attribute__((reqd_work_group_size(CC_COLUMNS, 1, 1))) void ccPlaceLayers(
    CcColumns g, __global int* touched, __global uint* counters, __global uint* placed) {
  __local uint room[2 * CC_COLUMNS], base;
  const uint c = get_local_id(0), layers = (uint)g.layers + 1;
  if (counters[CC_ENTRIES] > g.entryRoom || counters[CC_PIECES] > g.pieceRoom) return;
  const uint from = get_group_id(0) * layers;
  uint all = 0;
  for (uint chunk = 0; chunk < layers; chunk += CC_COLUMNS) {
    const uint layer = chunk + c, is = layer < layers && touched[from + layer] != 0 ? 1u : 0u;
    const uint upTo = ccSumUpTo(room, is);
    if (is) touched[from + layer] = (int)(all + upTo);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (c == CC_COLUMNS - 1) room[0] = upTo;
    barrier(CLK_LOCAL_MEM_FENCE);
    all += room[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (c == 0) base = atomic_add(&counters[CC_SUM_BRICKS], all);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint layer = c; layer < layers; layer += CC_COLUMNS) {
    if (touched[from + layer] == 0) continue;
    const uint place = base + (uint)touched[from + layer];
    touched[from + layer] = place <= g.sumRoom ? (int)place : 0;
    if (place <= g.sumRoom) placed[place - 1] = from + layer;
  }
}

#define CC_AHEAD 8  // triangles read together, so that their reads overlap

// Sums the differences of each brick that has some. One work-item for each of a brick's columns
// adds the pieces, triangle by triangle.
__kernel __attribute__((reqd_work_group_size(CC_COLUMNS, 1, 1))) void ccAddPieces(
    CcColumns g, __global const uint* restrict first, __global const uint* restrict placed,
    __global const uint2* restrict found, __global const double2* restrict pieces,
    __global const uint* restrict counters, __global double* restrict sums) {
  __local double d[(CC_EDGE + 1) * CC_COLUMNS];
  const uint c = get_local_id(0), bricks = counters[CC_SUM_BRICKS], layers = (uint)g.layers + 1;
  if (bricks > g.sumRoom) return;
  for (uint n = get_group_id(0); n < bricks; n += get_num_groups(0)) {
    const uint bin = placed[n] / layers, low = placed[n] % layers * CC_EDGE, high = low + CC_EDGE;
    const uint end = first[bin + 1];
    // A piece also adds to the cell above its own, so the cell below the brick counts. The last
    // place belongs to the next brick and is not used.
    __local double* const mine = d + c;
    for (int w = 0; w < CC_EDGE + 1; ++w) mine[w * CC_COLUMNS] = 0.0;
    for (uint e = first[bin]; e < end; e += CC_AHEAD) {
      uint2 f[CC_AHEAD];
      for (uint k = 0; k < CC_AHEAD; ++k)
        f[k] = e + k < end ? found[(size_t)(e + k) * CC_COLUMNS + c] : (uint2)(0u, 0u);
      for (uint k = 0; k < CC_AHEAD; ++k) {
        const uint count = f[k].y & 0xffffu, from = f[k].y >> 16;
        if (count == 0u || from >= high || from + count < low) continue;
        for (uint w = max(from + 1u, low) - 1u; w < min(from + count, high); ++w) {
          const double2 p = pieces[f[k].x + w - from];
          if (w >= low) mine[(w - low) * CC_COLUMNS] -= p.x;
          mine[(w + 1u - low) * CC_COLUMNS] -= p.y;
        }
      }
    }
    for (int w = 0; w < CC_EDGE; ++w)
      sums[((size_t)n * CC_EDGE + (size_t)w) * CC_COLUMNS + c] = mine[w * CC_COLUMNS];
  }
}

// Whether triangles of several shells have pieces in a column. Triangles that close an open surface
// belong to no shell.
int ccSeveralShells(uint begin, uint end, uint c, __global const uint2* found,
                    __global const uint* entries, __global const int* shells) {
  int shell = -1, several = 0;
  for (uint e = begin; e < end; ++e) {
    if ((found[(size_t)e * CC_COLUMNS + c].y & 0xffffu) == 0u) continue;
    const int own = shells[entries[e]];
    if (own < 0) continue;
    several |= shell >= 0 && shell != own;
    shell = own;
  }
  return several;
}

// The running sum of one column, with its extremes.
typedef struct {
  double sum, least, most;
} CcRun;

// Computes the coverage of a brick's eight cells in one column from their differences (null: all
// zero). Returns bit 0 if any cell is not empty, bit 1 if any is not full.
uint ccAddCells(CcRun* run, __global const double* differences, uchar* coverage) {
  uint seen = 0;
  double d[CC_EDGE];
  for (int w = 0; w < CC_EDGE; ++w) d[w] = differences ? differences[w * CC_COLUMNS] : 0.0;
  for (int w = 0; w < CC_EDGE; ++w) {
    const double sum = run->sum + d[w];
    run->sum = sum;
    run->least = sum < run->least ? sum : run->least;
    run->most = run->most < sum ? sum : run->most;
    coverage[w] = ccCoverage(sum);
    seen |= (coverage[w] > 0 ? 1u : 0u) | (coverage[w] < 255 ? 2u : 0u);
  }
  return seen;
}

// One group for each brick-wide column, one work-item for each of its columns. Finds from the
// running sums which bricks are empty, solid or stored, and how many are stored.
__kernel __attribute__((reqd_work_group_size(CC_COLUMNS, 1, 1))) void ccSumColumns(
    CcColumns g, __global const uint* first, __global const uint* entries,
    __global const int* shells, __global const uint2* found, __global const int* touched,
    __global const double* restrict sums, __global uint* counters, __global int* table,
    __global uint* stored) {
  __local uint seen[3];
  const uint c = get_local_id(0), bin = get_group_id(0);
  __global const int* const places = touched + (size_t)bin * (size_t)(g.layers + 1);
  if (c < 3) seen[c] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  const int sound = counters[CC_ENTRIES] <= g.entryRoom && counters[CC_PIECES] <= g.pieceRoom &&
                    counters[CC_SUM_BRICKS] <= g.sumRoom;
  int end = 0;  // layers from here on have no piece and are empty, even if the sum does not close
  for (int layer = 0; sound && layer < g.layers; ++layer) end = places[layer] > 0 ? layer + 1 : end;
  CcRun run = {0.0, 0.0, 0.0};
  uchar coverage[CC_EDGE];
  int changed = 0, code = CC_EMPTY_CODE;
  uint count = 0, turn = 0;
  for (int layer = (int)c; layer < g.layers; layer += CC_COLUMNS)
    if (layer >= end) table[ccTableAt(&g, bin, layer)] = CC_EMPTY_CODE;
  for (int layer = 0; layer < end; ++layer) {
    const int place = places[layer];
    if (place > 0 || changed) {
      __global const double* const d =
          place > 0 ? sums + (size_t)(place - 1) * CC_BRICK_VOXELS + c : 0;
      __local uint* const both = seen + turn % 3;
      const uint mine = ccAddCells(&run, d, coverage);
      if (mine) atomic_or(both, mine);
      barrier(CLK_LOCAL_MEM_FENCE);
      code = !(*both & 1u) ? CC_EMPTY_CODE : !(*both & 2u) ? CC_SOLID_CODE : 0;
      if (c == 0) seen[(turn + 2) % 3] = 0u;
      ++turn;
    }
    changed = place > 0;
    count += code == 0;
    if (c == 0) table[ccTableAt(&g, bin, layer)] = code;
  }
  if (c == 0) stored[bin] = count;
  if (ccAbs64(run.sum) > CC_CLOSED_SUM) atomic_inc(&counters[CC_BAD_COLUMNS]);
  int several = run.most > 1 + CC_CLOSED_SUM || run.least < -CC_CLOSED_SUM;
  if (g.shells && sound)
    several |= ccSeveralShells(first[bin], first[bin + 1], c, found, entries, shells);
  if (several) atomic_inc(&counters[CC_OVERLAPPING]);
}

// Repeats the sums and writes the stored bricks, those of each brick-wide column in layer order.
__kernel __attribute__((reqd_work_group_size(CC_COLUMNS, 1, 1))) void ccStoreBricks(
    CcColumns g, __global const int* touched, __global const double* sums,
    __global const uint* counters, __global const uint* firstStored, __global int* table,
    __global uchar* bricks) {
  const uint c = get_local_id(0), bin = get_group_id(0);
  __global const int* const places = touched + (size_t)bin * (size_t)(g.layers + 1);
  uint next = firstStored[bin];
  if (counters[CC_STORED] > g.brickRoom || next == firstStored[bin + 1]) return;
  const int strides[3] = {1, CC_EDGE, CC_EDGE * CC_EDGE};
  const uint corner = (c % CC_EDGE) * (uint)strides[g.u] + c / CC_EDGE * (uint)strides[g.v];
  CcRun run = {0.0, 0.0, 0.0};
  uchar coverage[CC_EDGE];
  int changed = 0;
  for (int layer = 0; layer < g.layers && next < firstStored[bin + 1]; ++layer) {
    const int place = places[layer];
    if (place > 0 || changed) {
      __global const double* const d =
          place > 0 ? sums + (size_t)(place - 1) * CC_BRICK_VOXELS + c : 0;
      ccAddCells(&run, d, coverage);
    }
    changed = place > 0;
    __global int* const entry = table + ccTableAt(&g, bin, layer);
    if (*entry < 0) continue;
    __global uchar* const brick = bricks + (size_t)next * CC_BRICK_VOXELS + corner;
    for (int w = 0; w < CC_EDGE; ++w) brick[w * strides[g.w]] = coverage[w];
    if (c == 0) *entry = (int)next;
    ++next;
  }
}
