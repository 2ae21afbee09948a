// Turns a mesh into voxels with the steps of plugin/voxels/columns.cpp and column_cutter.cpp, in
// the same order and with the same arithmetic.
//
// Each brick-wide column has a list of its triangles, in their order. One work-item cuts one row of
// a listed triangle, eight columns long, and stores a piece for each voxel. Later another work-item
// (column_sums.cl) sums a column, triangle by triangle, so the sums equal those of the CPU to the
// bit.

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
// plugin/voxels/column_cutter.h. A polygon on the brick's far face belongs to the last cell. Returns
// one of the three polygons; all are workspace.
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
