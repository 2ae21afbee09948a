// What the host hands to a device that takes matter from a workpiece, and what lies there. Plain C
// for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_MATTER_CUT_H
#define CLOUDCONTACT_KERNELS_MATTER_CUT_H

#include "kernels/digitize/flat_window.h"
#include "kernels/digitize/window_sums.h"

// A workpiece and its window.
typedef struct {
  int nx, ny, nz;       // bricks
  int low[3], high[3];  // the window's reach [voxels]
  int taps;             // of the window
  int kinds;            // of density
} CcCutting;

// A voxel that a step names: where it is, and what is to be left of it [1/255].
typedef struct {
  ushort x, y, z, left;
} CcVoxelLeft;
#define CC_WIDEST 65536  // voxels along an axis

// What a step sends: counters, all zero, and then its voxels.
#define CC_CHANGED 0   // voxels that lost matter, as BaseVectorField::cut() counts them
#define CC_AFFECTED 1  // bricks whose windows see that
#define CC_STEP_HEAD 4

#define CC_NO_CHANGE 0xffffffffu  // of a voxel named that keeps what it has
#define CC_STEP_GROUP 128
#define CC_FEW 64    // times that a voxel is named for which each is looked at by all
#define CC_LEFTS 16  // values told apart at a look through more
// Voxels above each other that a work-item renews, and the work-items of a brick. On an H100 the
// bricks of 100,000 voxels anywhere took 145 us with two, 175 with eight; a cut of 1,000 that lie
// together 16 us and 21.
#define CC_DEEP 2
#define CC_RENEW_GROUP (512 / CC_DEEP)

// What a voxel lost in a step, and of which tissue; zero where nothing.
#define CC_LOSS_OF(lost, tissue) ((ushort)((lost) | (tissue) << 8))

// What a brick holds of one tissue: sums of coverage times powers of the places in the brick, below
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
#define CC_ROWS 64  // of a brick's voxels along x

#endif
