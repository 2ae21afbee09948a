// A window summed in floats over a tile in local memory: a brick's voxels and those that its
// windows reach, x fastest, in rows of CC_TILE_ROW. Plain C for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_FLAT_WINDOW_H
#define CLOUDCONTACT_KERNELS_FLAT_WINDOW_H

#define CC_TILE_ROW 24      // halves: rows of eight voxels then lie in different banks
#define CC_RUN 8            // most voxels of the window above each other
#define CC_TILE_CELLS 6144  // of the tile

// Voxels of the window above each other along z.
typedef struct {
  int offset;        // of the lowest in the tile, from the window's middle
  int first, count;  // in the list of weights
  int above;         // layers of the lowest above the window's lowest
} CcFlatRun;

#if defined(__OPENCL_VERSION__)
// One rounding or two: the sums are integers that are exact in a float.
#if defined(FP_FAST_FMAF) || defined(__NV_CL_C_VERSION)
#define CC_ADD_PRODUCT(a, b, c) fma(a, b, c)
#else
#define CC_ADD_PRODUCT(a, b, c) ((a) * (b) + (c))
#endif
#endif

#endif
