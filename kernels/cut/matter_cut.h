// The data that host and device exchange when material is removed from a workpiece. Plain C for C++
// and OpenCL C.
#pragma once

#include "kernels/digitize/flat_window.h"
#include "kernels/digitize/window_sums.h"

// A workpiece and its window.
typedef struct {
  int nx, ny, nz;       // bricks
  int low[3], high[3];  // the window's reach [voxels]
  int taps;             // voxels of the window
  int kinds;            // distinct densities
} CcCutting;

// A voxel to cut in a step, and what is left of it [1/255].
typedef struct {
  ushort x, y, z, left;
} CcVoxelLeft;
#define CC_WIDEST 65536  // voxels along an axis

// A step sends counters, all zero, and then its voxels.
#define CC_CHANGED 0   // voxels that lost material, as BaseVectorField::cut() counts them
#define CC_AFFECTED 1  // bricks whose windows contain such voxels
#define CC_STEP_HEAD 4

#define CC_NO_CHANGE 0xffffffffu  // `next` of an entry whose voxel keeps its material
#define CC_STEP_GROUP 128
#define CC_FEW 64    // up to this many repeats of a voxel, each is compared with all others
#define CC_LEFTS 16  // values distinguished in one pass over more repeats
// Voxels above each other that a work-item updates, and the work-items of a brick.
#define CC_DEEP 2
#define CC_RENEW_GROUP (512 / CC_DEEP)

// The loss of a voxel in a step and its tissue; zero for no loss.
#define CC_LOSS_OF(lost, tissue) ((ushort)((lost) | (tissue) << 8))

// Sums over one tissue in a brick: coverage times powers of the coordinates in the brick, below
// 2^23.
#define CC_SUM_1 0
#define CC_SUM_X 1
#define CC_SUM_Y 2
#define CC_SUM_Z 3
#define CC_SUM_XX 4
#define CC_SUM_YY 5
#define CC_SUM_ZZ 6
#define CC_SUM_XY 7
#define CC_SUM_YZ 8
#define CC_SUM_ZX 9
#define CC_TISSUE_SUMS 10
typedef struct {
  int sum[CC_TISSUE_SUMS];
} CcTissueSums;
#define CC_ROWS 64  // rows of voxels along x in a brick
