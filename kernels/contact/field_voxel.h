// The field's record of a voxel near the surface: 8 bytes that hold one plane, or the index of
// several planes at an edge. Plain C for C++ and OpenCL C; a test checks the offsets.
//
//   a: bits 0-27 the outward normal, octahedral, 14 bits each way (worst error 0.01 deg);
//      bits 28-30 the number of planes, 0: no surface near; bit 31: set if the planes'
//      half-spaces unite (a concave edge), clear if they intersect (a convex edge)
//   b: one plane: its offset from the voxel's center, 16.16 fixed point, in voxels;
//      several: index of the first in the list of planes, which are records of one plane each
#ifndef CLOUDCONTACT_KERNELS_FIELD_VOXEL_H
#define CLOUDCONTACT_KERNELS_FIELD_VOXEL_H

#include "kernels/base/vector.h"

#define CC_NORMAL_STEPS 16383.0f
#define CC_OFFSET_STEPS 65536.0f
#define CC_MAX_PLANES 6

typedef struct {
  uint a, b;
} CcVoxel;

typedef struct {
  float depth;      // positive inside, voxels
  float normal[3];  // of the plane that gives it
} CcDepth;

CC_FN uint ccPlaneCount(CcVoxel v) {
  return (v.a >> 28) & 7u;
}
CC_FN int ccConcave(CcVoxel v) {
  return (int)(v.a >> 31);
}

CC_FN CcVoxel ccPackPlane(const float* n, float offset) {
  const float sum = ccAbs(n[0]) + ccAbs(n[1]) + ccAbs(n[2]);
  float x = n[0] / sum, y = n[1] / sum;
  if (n[2] < 0.0f) {
    const float fx = (1.0f - ccAbs(y)) * (x < 0.0f ? -1.0f : 1.0f);
    y = (1.0f - ccAbs(x)) * (y < 0.0f ? -1.0f : 1.0f);
    x = fx;
  }
  CcVoxel v;
  v.a = (uint)((x * 0.5f + 0.5f) * CC_NORMAL_STEPS + 0.5f) |
        ((uint)((y * 0.5f + 0.5f) * CC_NORMAL_STEPS + 0.5f) << 14) | (1u << 28);
  v.b = (uint)(int)(offset * CC_OFFSET_STEPS + (offset < 0.0f ? -0.5f : 0.5f));
  return v;
}

CC_FN CcVoxel ccPackPlanes(uint first, uint count, int concave) {
  CcVoxel v;
  v.a = (count << 28) | (concave ? 0x80000000u : 0u);
  v.b = first;
  return v;
}

// The plane's depth at x (from the voxel's center, voxels).
CC_FN CcDepth ccPlaneDepth(CcVoxel v, const float* x) {
  CcDepth d;
  float* n = d.normal;
  n[0] = (float)(v.a & 16383u) * (2.0f / CC_NORMAL_STEPS) - 1.0f;
  n[1] = (float)((v.a >> 14) & 16383u) * (2.0f / CC_NORMAL_STEPS) - 1.0f;
  n[2] = 1.0f - ccAbs(n[0]) - ccAbs(n[1]);
  const float fold = ccMax(-n[2], 0.0f);
  n[0] += n[0] < 0.0f ? fold : -fold;
  n[1] += n[1] < 0.0f ? fold : -fold;
  const float scale = 1.0f / CC_SQRT(ccDot(n, n));
  n[0] *= scale;
  n[1] *= scale;
  n[2] *= scale;
  d.depth = (float)(int)v.b * (1.0f / CC_OFFSET_STEPS) - ccDot(n, x);
  return d;
}

// The voxel's depth at x: the least over a convex edge's planes, the largest over a concave one's.
CC_FN CcDepth ccVoxelDepth(CcVoxel v, CC_GLOBAL const CcVoxel* planes, const float* x) {
  const uint count = ccPlaneCount(v);
  if (count == 1u) return ccPlaneDepth(v, x);
  CcDepth best = ccPlaneDepth(planes[v.b], x);
  const int concave = ccConcave(v);
  for (uint i = 1; i < count; ++i) {
    const CcDepth d = ccPlaneDepth(planes[v.b + i], x);
    if (concave ? d.depth > best.depth : d.depth < best.depth) best = d;
  }
  return best;
}

#endif
