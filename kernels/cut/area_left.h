// The part of a voxel that a cut leaves, from the depth of the voxel's center in the cutting area.
// Lengths in voxels. Plain C for C++ and OpenCL C, in doubles.
#pragma once

#include "kernels/base/plain_solid.h"

// A cutting area, placed in a grid.
typedef struct {
  int kind;             // CC_SPHERE, CC_BOX or CC_ELLIPSOID
  int low[3], high[3];  // range of voxels that it may cut; none if low > high
  int unused;
  double turn[9];    // rows: the area's axes
  double middle[3];  // its center
  double size[3];    // radius, half extents or semi-axes
} CcArea;

// Signed depth of a point that is given in the area's own frame.
CC_FN double ccAreaDepth(const CcArea* a, CcVec x) {
  const CcVec size = ccVec(a->size[0], a->size[1], a->size[2]);
  return a->kind == CC_SPHERE ? ccInSphere(size.x, x).depth
         : a->kind == CC_BOX  ? ccInBox(size, x).depth
                              : ccInEllipsoid(size, x).depth;
}

// The part of the voxel (x, y, z) that the area leaves [1/255].
CC_FN int ccAreaLeaves(const CcArea* a, int x, int y, int z) {
  const double i = x + 0.5 - a->middle[0], j = y + 0.5 - a->middle[1], k = z + 0.5 - a->middle[2];
  const CcVec at = ccVec(a->turn[0] * i + a->turn[1] * j + a->turn[2] * k,
                         a->turn[3] * i + a->turn[4] * j + a->turn[5] * k,
                         a->turn[6] * i + a->turn[7] * j + a->turn[8] * k);
  const double depth = ccAreaDepth(a, at);
  const double share = ccMin64(ccMax64(depth + 0.5, 0.0), 1.0);
  return 255 - (int)(255.0 * share + 0.5);
}
