// What a voxel of a workpiece knows of its cuttable area C: sums over C's voxels, of integers, so
// that matter taken away leaves what a new sum would give. Paper (4) with densities.
// Plain C for C++ and OpenCL C; offsets are pinned by a test.
#ifndef CLOUDCONTACT_KERNELS_WINDOW_SUMS_H
#define CLOUDCONTACT_KERNELS_WINDOW_SUMS_H

#include "plane_cell.h"

// Whole numbers below 2^53, which a double holds exactly: any order of sums gives the same. (64-bit
// integers do the same; their product has no instruction of its own on most machines.)
typedef double CcSum;

// Weights are in 1/255 of a voxel, matter is coverage [1/255] times density in 1/CC_DENSEST of the
// densest. CC_MOST_MOMENT bounds a window's sum of weight times place.
#define CC_DENSEST 2520        // whole halves, thirds ... tenths
#define CC_MOST_MOMENT 1.4e10  // times 255 * 2520: 2^51

typedef struct {
  CcSum mass;     // sum of weight * matter
  CcSum x, y, z;  // of weight * matter * place, from the voxel, in voxels
} CcMoments;

// One voxel of C: its weight and its weight times its place.
typedef struct {
  int weight, x, y, z;
} CcTap;

// Matter at the tap grows by `matter` (shrinks where negative).
CC_FN void ccWeigh(CcMoments* sums, CcTap tap, int matter) {
  sums->mass += (CcSum)matter * (CcSum)tap.weight;
  sums->x += (CcSum)matter * (CcSum)tap.x;
  sums->y += (CcSum)matter * (CcSum)tap.y;
  sums->z += (CcSum)matter * (CcSum)tap.z;
}

// Gr - Gc in voxels; zero where there is no matter.
CC_FN void ccToRepresentative(CcMoments sums, const float* representative, float* out) {
  const float scale = sums.mass > 0 ? 1.0f / (float)sums.mass : 0.0f;
  out[0] = sums.mass > 0 ? representative[0] - (float)sums.x * scale : 0.0f;
  out[1] = sums.mass > 0 ? representative[1] - (float)sums.y * scale : 0.0f;
  out[2] = sums.mass > 0 ? representative[2] - (float)sums.z * scale : 0.0f;
}

#endif
