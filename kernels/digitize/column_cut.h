// Cutting a triangle into voxels: which brick-wide columns it crosses, its part in a voxel, and
// what that adds to the sums along a column (the method is in plugin/voxels/columns.cpp). Plain C
// for C++ and OpenCL C, in doubles.
#pragma once

#include "kernels/base/vector64.h"

#if defined(__OPENCL_VERSION__)
#define CC_FLOOR floor
#define CC_CEIL ceil
#else
#define CC_FLOOR __builtin_floor
#define CC_CEIL __builtin_ceil
#endif

#define CC_EDGE 8           // voxels along a brick's edge
#define CC_COLUMNS 64       // of voxels, in a brick-wide column
#define CC_EMPTY_CODE (-1)  // bricks that store no numbers: all coverage 0,
#define CC_SOLID_CODE (-2)  // all 255

// Smallest projected area of a triangle that is cut [voxel^2]. Smaller areas are rounding of faces
// parallel to the columns; a million of them change no voxel.
#define CC_SMALLEST_AREA 1e-12
// Largest sum at the end of a column that counts as closed [voxel^2]. Rounding leaves 1e-12. A
// crack may leave more; it is carried along the column and must round to no coverage (1/510), or
// the crack would draw a streak through the empty voxels above it.
#define CC_CLOSED_SUM 1e-3
// [voxels] One brick-wide column too many costs time, one too few leaves a hole.
#define CC_COLUMN_SLACK 1e-6

// A convex polygon. A triangle cut by six planes has at most nine corners. The rest is for slivers
// that cross a plane more than twice by rounding; corners beyond it have no area to lose.
#define CC_CORNERS 16
typedef struct {
  int corners;
  double p[CC_CORNERS][3];
} CcPolygon;

CC_FN void ccAddCorner(CcPolygon* polygon, const double* x) {
  if (polygon->corners >= CC_CORNERS) return;
  double* const p = polygon->p[polygon->corners++];
  p[0] = x[0];
  p[1] = x[1];
  p[2] = x[2];
}

// Splits `polygon` at the plane x[axis] = value. Corners on the plane go to both parts, which may
// give an area of zero but never a gap.
CC_FN void ccSplit(const CcPolygon* polygon, const int axis, double value, CcPolygon* below,
                   CcPolygon* above) {
  below->corners = above->corners = 0;
  const double first = polygon->p[0][axis] - value;
  double da = first;
  for (int i = 0; i < polygon->corners; ++i) {
    const int last = i + 1 == polygon->corners;
    const double *a = polygon->p[i], *b = polygon->p[last ? 0 : i + 1];
    const double db = last ? first : b[axis] - value;
    if (da <= 0) ccAddCorner(below, a);
    if (da >= 0) ccAddCorner(above, a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      const double part = da / (da - db);
      double x[3];
      for (int k = 0; k < 3; ++k) x[k] = a[k] + part * (b[k] - a[k]);
      x[axis] = value;
      ccAddCorner(below, x);
      ccAddCorner(above, x);
    }
    da = db;
  }
}

typedef struct {
  double low, high;
} CcSpan;

CC_FN CcSpan ccSpan(const CcPolygon* polygon, const int axis) {
  CcSpan s;
  s.low = s.high = polygon->p[0][axis];
  for (int i = 1; i < polygon->corners; ++i) {
    const double x = polygon->p[i][axis];
    s.low = x < s.low ? x : s.low;
    s.high = s.high < x ? x : s.high;
  }
  return s;
}

// The cells that a polygon crosses along an axis: first to last.
typedef struct {
  int first, last;
} CcCells;

CC_FN CcCells ccCells(const CcPolygon* polygon, const int axis) {
  const CcSpan s = ccSpan(polygon, axis);
  CcCells cells;
  cells.first = (int)CC_FLOOR(s.low);
  cells.last = (int)CC_CEIL(s.high) - 1;
  if (cells.last < cells.first) cells.last = cells.first;
  return cells;
}

// Clips the polygon to 0..CC_EDGE along an axis. Returns `polygon` or `spare`. All three polygons
// are workspace.
CC_FN CcPolygon* ccClip(CcPolygon* polygon, const int axis, CcPolygon* spare, CcPolygon* rest) {
  if (polygon->corners < 3) return polygon;
  const CcSpan s = ccSpan(polygon, axis);
  if (s.low < 0) {
    ccSplit(polygon, axis, 0, rest, spare);
    CcPolygon* const used = polygon;
    polygon = spare;
    spare = used;
  }
  if (s.high > CC_EDGE && polygon->corners > 2) {
    ccSplit(polygon, axis, CC_EDGE, spare, rest);
    polygon = spare;
  }
  return polygon;
}

// Twice the projected area of a triangle. It is positive if the triangle faces up.
CC_FN double ccTwiceArea(const double* a, const double* b, const double* c, const int u,
                         const int v) {
  return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
}

// A piece of a surface in one voxel: its projected area, and the volume under it in that voxel.
typedef struct {
  double area, under;
} CcPiece;

// Accumulates ccPieceOf() corner by corner, without storing the corners.
typedef struct {
  int corners;
  double first[3], last[3];
  double twiceArea, sixMoments;
} CcFan;

CC_FN void ccOpenFan(CcFan* fan) {
  fan->corners = 0;
  for (int k = 0; k < 3; ++k) fan->first[k] = fan->last[k] = 0;
  fan->twiceArea = fan->sixMoments = 0;
}

CC_FN void ccAddToFan(CcFan* fan, const double* x, int cell) {
  if (fan->corners >= CC_CORNERS) return;
  double* const a = fan->first;
  double* const b = fan->last;
  if (fan->corners == 0) {
    for (int k = 0; k < 3; ++k) a[k] = x[k];
  } else if (fan->corners > 1) {
    const double cross = ccTwiceArea(a, b, x, 0, 1);
    fan->twiceArea += cross;
    fan->sixMoments += cross * ((a[2] - cell) + (b[2] - cell) + (x[2] - cell));
  }
  for (int k = 0; k < 3; ++k) b[k] = x[k];
  ++fan->corners;
}

CC_FN CcPiece ccPieceOfFan(const CcFan* fan) {
  CcPiece piece;
  piece.area = fan->twiceArea / 2;
  piece.under = fan->sixMoments / 6;
  return piece;
}

CC_FN CcPiece ccPieceOf(const CcPolygon* polygon, int cell) {
  double twiceArea = 0, sixMoments = 0;
  const double* a = polygon->p[0];
  for (int i = 2; i < polygon->corners; ++i) {
    const double *b = polygon->p[i - 1], *c = polygon->p[i];
    const double cross = ccTwiceArea(a, b, c, 0, 1);
    twiceArea += cross;
    sixMoments += cross * ((a[2] - cell) + (b[2] - cell) + (c[2] - cell));
  }
  CcPiece piece;
  piece.area = twiceArea / 2;
  piece.under = sixMoments / 6;
  return piece;
}

// ccSplit() at the top of a cell, for when only the sums of the part below are needed.
CC_FN void ccCutCell(const CcPolygon* polygon, int cell, CcFan* below, CcPolygon* above) {
  ccOpenFan(below);
  above->corners = 0;
  const double value = cell + 1;
  const double first = polygon->p[0][2] - value;
  double da = first;
  for (int i = 0; i < polygon->corners; ++i) {
    const int last = i + 1 == polygon->corners;
    const double *a = polygon->p[i], *b = polygon->p[last ? 0 : i + 1];
    const double db = last ? first : b[2] - value;
    if (da <= 0) ccAddToFan(below, a, cell);
    if (da >= 0) ccAddCorner(above, a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      const double part = da / (da - db);
      const double x[3] = {a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), value};
      ccAddToFan(below, x, cell);
      ccAddCorner(above, x);
    }
    da = db;
  }
}

// The brick along an axis that contains x [voxels], clamped to the `count` bricks.
CC_FN int ccBrickOf(double x, int count) {
  const int b = (int)CC_FLOOR(x / CC_EDGE);
  return b < 0 ? 0 : count - 1 < b ? count - 1 : b;
}

// Rows of bricks along v that a triangle's projection may touch. `p`: the three corners.
CC_FN CcCells ccRowsOf(const double* p, const int v, int depth) {
  double low = p[v], high = p[v];
  for (int k = 1; k < 3; ++k) {
    low = p[3 * k + v] < low ? p[3 * k + v] : low;
    high = high < p[3 * k + v] ? p[3 * k + v] : high;
  }
  CcCells rows;
  rows.first = ccBrickOf(low - CC_COLUMN_SLACK, depth);
  rows.last = ccBrickOf(high + CC_COLUMN_SLACK, depth);
  return rows;
}

// The brick-wide columns of a row that the triangle may touch; none if last < first. Searching row
// by row lists a long oblique triangle along its length only, not all over its bounding box.
CC_FN CcCells ccColumnsOf(const double* p, const int u, const int v, int row, int width) {
  const double below = row * CC_EDGE - CC_COLUMN_SLACK;
  const double above = (row + 1) * CC_EDGE + CC_COLUMN_SLACK;
  double low = 1e300, high = -1e300;
  for (int k = 0; k < 3; ++k) {
    const double *a = p + 3 * k, *b = p + (k < 2 ? 3 * k + 3 : 0);
    if (a[v] >= below && a[v] <= above) {
      low = a[u] < low ? a[u] : low;
      high = high < a[u] ? a[u] : high;
    }
    for (int side = 0; side < 2; ++side) {
      const double line = side ? above : below;
      if ((a[v] < line) == (b[v] < line)) continue;
      const double x = a[u] + (line - a[v]) / (b[v] - a[v]) * (b[u] - a[u]);
      low = x < low ? x : low;
      high = high < x ? x : high;
    }
  }
  CcCells columns;
  columns.first = columns.last = -1;
  if (low > high) {
    columns.first = 0;
    return columns;
  }
  columns.first = ccBrickOf(low - CC_COLUMN_SLACK, width);
  columns.last = ccBrickOf(high + CC_COLUMN_SLACK, width);
  return columns;
}

// The coverage of a voxel [1/255] from its column's running sum.
CC_FN unsigned char ccCoverage(double sum) {
  const double all = sum < 0.0 ? 0.0 : 1.0 < sum ? 1.0 : sum;
  return (unsigned char)(int)(all * 255 + 0.5);
}
