// The part of a voxel that a cut leaves, from the depth of the voxel's center in the cutting area.
// Lengths in voxels. Plain C for C++ and OpenCL C, in doubles.
#pragma once

#include "kernels/base/vector64.h"

#define CC_SPHERE 0
#define CC_BOX 1
#define CC_ELLIPSOID 2

// A cutting area, placed in a grid.
typedef struct {
  int kind;
  int low[3], high[3];  // range of voxels that it may cut; none if low > high
  int unused;
  double turn[9];    // rows: the area's axes
  double middle[3];  // its center
  double size[3];    // radius, half extents or semi-axes
} CcArea;

CC_FN double ccLength(double x, double y, double z) {
  return CC_SQRT64(x * x + y * y + z * z);
}

// Signed depth of a point that is given in the area's own frame.
CC_FN double ccAreaDepth(const CcArea* a, double x, double y, double z) {
  const double u = a->size[0], v = a->size[1], w = a->size[2];
  if (a->kind == CC_SPHERE) return u - ccLength(x, y, z);
  if (a->kind == CC_BOX) {
    const double i = ccAbs64(x) - u, j = ccAbs64(y) - v, k = ccAbs64(z) - w;
    const double outside = ccLength(ccMax64(i, 0.0), ccMax64(j, 0.0), ccMax64(k, 0.0));
    return outside > 0.0 ? -outside : -ccMax64(ccMax64(i, j), k);
  }
  const double least = ccMin64(ccMin64(u, v), w), r = ccLength(x / u, y / v, z / w);
  if (r < 1e-12) return least;
  const double slope = ccLength(x / (u * u), y / (v * v), z / (w * w)) / r;
  return ccMin64((1.0 - r) / slope, least);
}

// The part of the voxel (x, y, z) that the area leaves [1/255].
CC_FN int ccAreaLeaves(const CcArea* a, int x, int y, int z) {
  const double i = x + 0.5 - a->middle[0], j = y + 0.5 - a->middle[1], k = z + 0.5 - a->middle[2];
  const double depth = ccAreaDepth(a, a->turn[0] * i + a->turn[1] * j + a->turn[2] * k,
                                   a->turn[3] * i + a->turn[4] * j + a->turn[5] * k,
                                   a->turn[6] * i + a->turn[7] * j + a->turn[8] * k);
  const double share = ccMin64(ccMax64(depth + 0.5, 0.0), 1.0);
  return 255 - (int)(255.0 * share + 0.5);
}
