// The sums that each voxel of a workpiece keeps over the window of its cuttable area C: the paper's
// (4) with densities. They are sums of integers, so removing material gives exactly the result of
// summing again. Plain C for C++ and OpenCL C; a test checks the offsets.
#pragma once

#include "kernels/base/language.h"

// Integers below 2^53, exact in a double, so any order of summation gives the same. (64-bit
// integers would do too, but most machines have no vector instruction for their product.)
typedef double CcSum;

// A weight counts 1/255 of a voxel. Matter is coverage [1/255] times density [1/CC_DENSEST of the
// densest tissue]. CC_MOST_MOMENT bounds a window's sum of weight times place.
#define CC_DENSEST 2520        // divisible by 1 to 10
#define CC_MOST_MOMENT 1.4e10  // times 255 * 2520: 2^51

typedef struct {
  CcSum mass;     // sum of weight * matter
  CcSum x, y, z;  // sum of weight * matter * place; place from the voxel's center [voxels]
} CcMoments;

// One voxel of C: its weight and its weight times its place.
typedef struct {
  int weight, x, y, z;
} CcTap;

// Adds `matter` at the tap; a negative value removes it.
CC_FN void ccWeigh(CcMoments* sums, CcTap tap, int matter) {
  sums->mass += (CcSum)matter * (CcSum)tap.weight;
  sums->x += (CcSum)matter * (CcSum)tap.x;
  sums->y += (CcSum)matter * (CcSum)tap.y;
  sums->z += (CcSum)matter * (CcSum)tap.z;
}

#ifndef CC_MAY_ALIAS
#if defined(__OPENCL_VERSION__)
#define CC_MAY_ALIAS
#else
#define CC_MAY_ALIAS __attribute__((may_alias))  // C++ reads the same memory as other types
#endif
#endif

#define CC_BRICK_VOXELS 512  // 8x8x8, x fastest

// A brick of a workpiece: its voxels and their window sums.
typedef struct CC_MAY_ALIAS {
  CcMoments moments[CC_BRICK_VOXELS];
  CcSum volume[CC_BRICK_VOXELS];  // sum of weight * coverage
  unsigned char coverage[CC_BRICK_VOXELS], tissue[CC_BRICK_VOXELS];
} CcBlock;

// One voxel of C, relative to its middle voxel.
typedef struct {
  int x, y, z;
  CcTap tap;
} CcWindowTap;

// A workpiece. `table`: the block of each brick, x fastest, negative for an empty brick. `density`:
// of each tissue [1/CC_DENSEST].
typedef struct {
  int nx, ny, nz;
  CC_GLOBAL const int* table;
  CC_GLOBAL const CcBlock* blocks;
  CC_GLOBAL const int* density;
} CcWorkpiece;

// Sums over the window of the voxel (x, y, z).
CC_FN void ccWindowSum(const CcWorkpiece* w, CC_GLOBAL const CcWindowTap* taps, int count, int x,
                       int y, int z, CcMoments* moments, CcSum* volume) {
  moments->mass = moments->x = moments->y = moments->z = 0;
  *volume = 0;
  for (int k = 0; k < count; ++k) {
    const CcWindowTap t = taps[k];
    const int i = x + t.x, j = y + t.y, l = z + t.z;
    if ((i < 0) | (j < 0) | (l < 0) | (i >= 8 * w->nx) | (j >= 8 * w->ny) | (l >= 8 * w->nz))
      continue;
    const int block = w->table[(i >> 3) + w->nx * ((j >> 3) + w->ny * (l >> 3))];
    if (block < 0) continue;
    const int cell = (i & 7) | (j & 7) << 3 | (l & 7) << 6;
    const int coverage = w->blocks[block].coverage[cell];
    if (coverage == 0) continue;
    ccWeigh(moments, t.tap, coverage * w->density[w->blocks[block].tissue[cell]]);
    *volume += (CcSum)(coverage * t.tap.weight);
  }
}

// The base vector Gr - Gc [voxels]; zero without matter.
CC_FN void ccToRepresentative(CcMoments sums, const float* representative, float* out) {
  const float scale = sums.mass > 0 ? 1.0f / (float)sums.mass : 0.0f;
  out[0] = sums.mass > 0 ? representative[0] - (float)sums.x * scale : 0.0f;
  out[1] = sums.mass > 0 ? representative[1] - (float)sums.y * scale : 0.0f;
  out[2] = sums.mass > 0 ? representative[2] - (float)sums.z * scale : 0.0f;
}
