// Window sums in floats over a tile in local memory. The tile holds a brick's voxels and all others
// that its windows reach, x fastest, in rows of CC_TILE_ROW. Plain C for C++ and OpenCL C.
#pragma once

#define CC_TILE_ROW 24      // halves; puts rows of eight voxels in different banks
#define CC_RUN 8            // most voxels in a run
#define CC_TILE_CELLS 6144  // most cells of a tile

// A run: voxels of the window above each other along z.
typedef struct {
  int offset;        // of the lowest in the tile, from the window's middle
  int first, count;  // in the list of weights
  int above;         // layers from the window's lowest voxel to the run's lowest
} CcFlatRun;

#if defined(__OPENCL_VERSION__)
// Fused or not gives the same result: the sums are integers that a float holds exactly.
#if defined(FP_FAST_FMAF) || defined(__NV_CL_C_VERSION)
#define CC_ADD_PRODUCT(a, b, c) fma(a, b, c)
#else
#define CC_ADD_PRODUCT(a, b, c) ((a) * (b) + (c))
#endif
#endif
