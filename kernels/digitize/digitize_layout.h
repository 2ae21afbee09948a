// The data that host and device exchange when digitizing. Plain C for C++ and OpenCL C.
#pragma once

#include "kernels/digitize/column_cut.h"
#include "kernels/digitize/window_sums.h"

// A grid cut into columns along the axis w; the others are u and v.
typedef struct {
  int u, v, w;
  int width, depth, layers;  // bricks along u, v, w
  int nx, ny;                // bricks along x, y
  uint triangles;
  int shells;  // whether the mesh has several shells
  // Room for the counted items below.
  uint entryRoom, pieceRoom, sumRoom, brickRoom;
} CcColumns;

// Counters of needed room. Beyond the given room nothing is written, and the host tries again.
#define CC_ENTRIES 0      // triangles over brick-wide columns
#define CC_PIECES 1       // places for pieces of triangles in voxels, in units of CC_PIECE_UNIT
#define CC_SUM_BRICKS 2   // bricks that a piece lies in
#define CC_STORED 3       // bricks that store numbers
#define CC_BAD_COLUMNS 4  // columns whose sum does not return to zero
#define CC_OVERLAPPING 5  // columns in which shells may overlap
#define CC_LOST 6         // pieces outside the grid
#define CC_OWN_BLOCKS 7   // bricks with windows of their own
#define CC_CUT_COUNTERS 8
#define CC_PIECE_UNIT 256  // so that memory runs out before a 32-bit count overflows

// The pieces of a triangle in one column, cell by cell.
typedef struct {
  uint begin;       // first piece
  uint firstCount;  // first cell << 16 | how many
} CcColumnPieces;
#define CC_TALLEST 65535  // most cells of a column

#define CC_GROUP 128  // as in batch_layout.h
#define CC_CUT_GROUP 128
#define CC_SCAN_GROUP 256

// A body of one tissue and the window that its base-vector field sums over.
typedef struct {
  int nx, ny, nz;       // bricks
  int low[3], high[3];  // the window's reach [voxels]
  int taps;
  int density;  // [1/CC_DENSEST]
  uint blockRoom;
} CcWindows;

#define CC_WINDOW_GROUP 128
