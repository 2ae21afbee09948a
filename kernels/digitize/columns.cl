// Turns a mesh into voxels with the steps of plugin/voxels/columns.cpp and column_cutter.cpp, in
// the same order and with the same arithmetic.
//
// Each brick-wide column has a list of its triangles, in their order. One work-item cuts one row of
// a listed triangle, eight columns long, and stores a piece for each voxel. Later another work-item
// sums a column, triangle by triangle, so the sums equal those of the CPU to the bit.

#define CC_ROW_ITEMS 8  // work-items that list a triangle's rows

void ccCornersOf(__global const double* vertices, __global const int* triangles, uint t,
                 double* p) {
  for (int k = 0; k < 3; ++k) {
    __global const double* v = vertices + 3 * (size_t)triangles[3 * (size_t)t + k];
    p[3 * k] = v[0];
    p[3 * k + 1] = v[1];
    p[3 * k + 2] = v[2];
  }
}

// Counts the triangles over each brick-wide column and, if `first` is given, lists them.
void ccOverColumns(const CcColumns* g, __global const double* vertices,
                   __global const int* triangles, __global uint* counts,
                   __global const uint* first, __global uint* entries, __global uint* owners) {
  const uint i = get_global_id(0), t = i / CC_ROW_ITEMS;
  if (t >= g->triangles) return;
  double p[9];
  ccCornersOf(vertices, triangles, t, p);
  if (ccAbs64(ccTwiceArea(p, p + 3, p + 6, g->u, g->v)) < CC_SMALLEST_AREA) return;
  const CcCells rows = ccRowsOf(p, g->v, g->depth);
  for (int row = rows.first + (int)(i % CC_ROW_ITEMS); row <= rows.last; row += CC_ROW_ITEMS) {
    const CcCells columns = ccColumnsOf(p, g->u, g->v, row, g->width);
    for (int c = columns.first; c <= columns.last; ++c) {
      const uint bin = (uint)row * (uint)g->width + (uint)c;
      const uint place = atomic_inc(&counts[bin]);
      if (!first) continue;
      entries[first[bin] + place] = t;
      owners[first[bin] + place] = bin;
    }
  }
}

__kernel void ccCountColumns(CcColumns g, __global const double* vertices,
                             __global const int* triangles, __global uint* counts) {
  ccOverColumns(&g, vertices, triangles, counts, 0, 0, 0);
}

__kernel void ccListColumns(CcColumns g, __global const double* vertices,
                            __global const int* triangles, __global uint* counts,
                            __global const uint* first, __global const uint* counters,
                            __global uint* entries, __global uint* owners) {
  if (counters[CC_ENTRIES] > g.entryRoom) return;
  ccOverColumns(&g, vertices, triangles, counts, first, entries, owners);
}

// Bitonic sort of a column's triangles. Places beyond the end count as the largest key.
#define CC_SORT(keys)                                                            \
  for (uint size = 2; size / 2 < n; size *= 2) {                                 \
    for (uint half_ = size / 2; half_ > 0; half_ /= 2) {                         \
      for (uint i = lid; i - i % half_ < n; i += CC_GROUP) {                 \
        const uint a = i / half_ * 2 * half_ + i % half_;                        \
        const uint b = half_ == size / 2 ? a + size - 1 - 2 * (i % half_) : a + half_; \
        if (b < n && keys[a] > keys[b]) {                                        \
          const uint k = keys[a];                                                \
          keys[a] = keys[b];                                                     \
          keys[b] = k;                                                           \
        }                                                                        \
      }                                                                          \
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);                       \
    }                                                                            \
  }

#define CC_SORT_HERE 1024  // most triangles that are sorted in local memory
__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSortColumns(
    CcColumns g, __global const uint* first, __global const uint* counters,
    __global uint* entries) {
  __local uint here[CC_SORT_HERE];
  const uint lid = get_local_id(0), begin = first[get_group_id(0)],
             n = first[get_group_id(0) + 1] - begin;
  if (counters[CC_ENTRIES] > g.entryRoom || n < 2) return;
  __global uint* const there = entries + begin;
  if (n > CC_SORT_HERE) {
    CC_SORT(there)
    return;
  }
  for (uint k = lid; k < n; k += CC_GROUP) here[k] = there[k];
  barrier(CLK_LOCAL_MEM_FENCE);
  CC_SORT(here)
  for (uint k = lid; k < n; k += CC_GROUP) there[k] = here[k];
}

// The piece of `polygon` in one cell along an axis, or null, as from slice() in
// plugin/voxels/polygon.h. A polygon on the brick's far face belongs to the last cell. Returns one
// of the three polygons; all are workspace.
CcPolygon* ccSliceAt(CcPolygon* polygon, const int axis, int cell, CcPolygon* spare,
                     CcPolygon* piece) {
  const CcCells cells = ccCells(polygon, axis);
  if (cells.first == cells.last) return min(cells.first, CC_EDGE - 1) == cell ? polygon : 0;
  if (cell < cells.first || cell > cells.last) return 0;
  CcPolygon *rest = polygon, *above = spare;
  for (int k = cells.first; k < cells.last && k <= cell; ++k) {
    ccSplit(rest, axis, k + 1, piece, above);
    if (k == cell) return piece->corners > 2 ? piece : 0;
    CcPolygon* const used = rest;
    rest = above;
    above = used;
  }
  return rest->corners > 2 ? rest : 0;
}

// The part of a triangle in one row of voxels, in the frame of its brick-wide column, or null.
// Returns one of the three polygons in `room`.
CcPolygon* ccRowOf(const CcColumns* g, __global const double* vertices,
                   __global const int* triangles, uint triangle, uint bin, int row,
                   CcPolygon* room) {
  double p[9];
  ccCornersOf(vertices, triangles, triangle, p);
  const int bu = (int)(bin % (uint)g->width), bv = (int)(bin / (uint)g->width);
  room->corners = 3;
  for (int k = 0; k < 3; ++k) {
    room->p[k][0] = p[3 * k + g->u] - bu * CC_EDGE;
    room->p[k][1] = p[3 * k + g->v] - bv * CC_EDGE;
    room->p[k][2] = p[3 * k + g->w];
  }
  CcPolygon* const inU = ccClip(room, 0, room + 1, room + 2);
  CcPolygon* const spare = inU == room ? room + 1 : room;
  CcPolygon* const polygon = ccClip(inU, 1, spare, room + 2);
  if (polygon->corners < 3) return 0;
  return ccSliceAt(polygon, 1, row, polygon == inU ? spare : inU, room + 2);
}

// Rows of a brick-wide column in which the triangle may have a part.
CcCells ccRowsInColumn(const CcColumns* g, __global const double* vertices,
                       __global const int* triangles, uint triangle, uint bin) {
  double v[3];
  for (int k = 0; k < 3; ++k)
    v[k] = vertices[3 * (size_t)triangles[3 * (size_t)triangle + k] + g->v] -
           (int)(bin / (uint)g->width) * CC_EDGE;
  CcCells rows;
  rows.first = max((int)floor(ccMin64(v[0], ccMin64(v[1], v[2])) - CC_COLUMN_SLACK), 0);
  rows.last =
      min((int)floor(ccMax64(v[0], ccMax64(v[1], v[2])) + CC_COLUMN_SLACK), CC_EDGE - 1);
  return rows;
}

// Where a work-item writes the pieces of its row.
typedef struct {
  __global double2* pieces;
  __global int* touched;  // a flag for each layer of the brick-wide column
  __global uint* counters;
  uint begin;
  int low, cells;  // each column has places for the cells low ... low + cells - 1
} CcPieceRoom;

// Cuts one column's polygon at whole numbers, destroying it. Returns the number of pieces, counted
// from the first of `cells`, or 0 if none has an area.
uint ccCutColumn(CcPolygon* column, CcCells cells, const CcPieceRoom* to, uint begin,
                 CcPolygon* spare) {
  if (cells.first < to->low || cells.last >= to->low + to->cells) {
    atomic_inc(&to->counters[CC_LOST]);
    return 0;
  }
  CcPolygon *rest = column, *above = spare;
  uint some = 0;
  for (int cell = cells.first; cell <= cells.last; ++cell) {
    CcPiece part;
    int corners;
    if (cell < cells.last) {
      CcFan below;
      ccCutCell(rest, cell, &below, above);
      CcPolygon* const used = rest;
      rest = above;
      above = used;
      part = ccPieceOfFan(&below);
      corners = below.corners;
    } else {
      part = ccPieceOf(rest, cell);
      corners = rest->corners;
    }
    double2 out = (double2)(0.0, 0.0);
    if (corners > 2) {
      out = (double2)(part.area - part.under, part.under);
      to->touched[cell / CC_EDGE] = 1;
      to->touched[(cell + 1) / CC_EDGE] = 1;
      some = 1;
    }
    to->pieces[begin + (uint)(cell - to->low)] = out;
  }
  return some ? (uint)(cells.last - cells.first + 1) : 0u;
}

// Cuts a row, destroying it. `room`: the polygons of ccRowOf(), one of which is `row`, and one
// more.
void ccCutRow(CcPolygon* row, const CcPieceRoom* to, CcPolygon* room,
              __global CcColumnPieces* found) {
  CcPolygon* const spare = row == room ? room + 1 : room;
  CcPolygon* const piece = row == room + 2 ? room + 1 : room + 2;
  const CcCells columns = ccCells(row, 0);
  CcPolygon *rest = row, *above = spare;
  for (int u = columns.first; u <= columns.last; ++u) {
    CcPolygon* column = rest;
    if (u < columns.last) {
      ccSplit(rest, 0, u + 1, piece, above);
      column = piece;
      CcPolygon* const used = rest;
      rest = above;
      above = used;
    }
    if (column->corners < 3) continue;
    const CcCells cells = ccCells(column, 2);
    const uint begin = to->begin + (uint)((u - columns.first) * to->cells);
    const uint count = ccCutColumn(column, cells, to, begin, room + 3);
    if (count == 0u) continue;
    found[min(u, CC_EDGE - 1)].begin = begin + (uint)(cells.first - to->low);
    found[min(u, CC_EDGE - 1)].firstCount = (uint)cells.first << 16 | count;
  }
}

// A group takes as many entries (a triangle over a brick-wide column) as it has work-items,
// collects the rows that may have a part of their triangle, and divides these among its work-items.
// Fewer than half of all rows have a part.
__kernel __attribute__((reqd_work_group_size(CC_CUT_GROUP, 1, 1))) void ccCutColumns(
    CcColumns g, __global const double* vertices, __global const int* triangles,
    __global const uint* entries, __global const uint* owners, __global uint* counters,
    __global CcColumnPieces* found, __global double2* pieces, __global int* touched) {
  __local uint needed, groupBegin, sums[2 * CC_CUT_GROUP];
  __local ushort items[CC_CUT_GROUP * CC_EDGE];  // entry * 8 + row
  const uint lid = get_local_id(0), base = get_group_id(0) * CC_CUT_GROUP;
  const uint all = counters[CC_ENTRIES];
  if (all > g.entryRoom || base >= all) return;
  const uint some = min(all - base, (uint)CC_CUT_GROUP);
  CcCells rows;
  rows.first = 0;
  rows.last = -1;
  if (lid < some)
    rows = ccRowsInColumn(&g, vertices, triangles, entries[base + lid], owners[base + lid]);
  const uint own = (uint)max(rows.last - rows.first + 1, 0);
  const uint upTo = ccSumUpTo(sums, own);
  for (uint k = 0; k < own; ++k)
    items[upTo - own + k] = (ushort)(lid * CC_EDGE + (uint)rows.first + k);
  for (uint k = lid; k < some * CC_COLUMNS; k += CC_CUT_GROUP)
    found[(size_t)base * CC_COLUMNS + k].firstCount = 0u;
  if (lid == CC_CUT_GROUP - 1) groupBegin = upTo;
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  const uint count = groupBegin;
  for (uint turn = 0; turn < count; turn += CC_CUT_GROUP) {
    CcPolygon room[4];
    CcPolygon* row = 0;
    CcPieceRoom to;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0) needed = 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint before = 0, item = 0;
    if (turn + lid < count) {
      item = items[turn + lid];
      const uint entry = base + item / CC_EDGE, bin = owners[entry];
      row = ccRowOf(&g, vertices, triangles, entries[entry], bin, (int)(item % CC_EDGE), room);
      to.pieces = pieces;
      to.counters = counters;
      to.touched = touched + (size_t)bin * (size_t)(g.layers + 1);
    }
    if (row) {
      // One cell more at either end: rounding may put the corner of a cut just beyond the polygon.
      const CcCells cells = ccCells(row, 2), columns = ccCells(row, 0);
      to.low = cells.first - 1;
      to.cells = cells.last - cells.first + 3;
      before = atomic_add(&needed, (uint)((columns.last - columns.first + 1) * to.cells));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint units = (needed + CC_PIECE_UNIT - 1) / CC_PIECE_UNIT;
    if (lid == 0) groupBegin = atomic_add(&counters[CC_PIECES], units);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (row && groupBegin + units <= g.pieceRoom) {
      to.begin = groupBegin * CC_PIECE_UNIT + before;
      ccCutRow(row, &to, room, found + ((size_t)base * CC_EDGE + item) * CC_EDGE);
    }
  }
}

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
