// The field's record of a voxel near the surface: 8 bytes that hold one plane, or the index of
// several planes at an edge. Plain C for C++ and OpenCL C; a test checks the offsets.
//
//   a: bits 0-27 the outward normal, octahedral, 14 bits each way (worst error 0.01 deg);
//      bits 28-30 the number of planes, 0: no surface near; bit 31: set if the planes'
//      half-spaces unite (a concave edge), clear if they intersect (a convex edge)
//   b: one plane: bits 0-23 its offset from the voxel's center, 8.16 fixed point, in voxels;
//      several: index of the first in the list of planes, which are records of one plane each
//   Bits 24-31 of b of one plane, 0-7 of a of several: how far the surface rises above the planes
//   nearby, ccBend().
#ifndef CLOUDCONTACT_KERNELS_FIELD_VOXEL_H
#define CLOUDCONTACT_KERNELS_FIELD_VOXEL_H

#include "kernels/base/vector.h"

#define CC_NORMAL_STEPS 16383.0f
#define CC_OFFSET_STEPS 65536.0f
#define CC_MAX_PLANES 6
// [voxels] The most that a record says of its bend. A surface may rise by more at an edge: where a
// thread of five voxels a pitch touches lightly, 0.125 leaves out 6 % of what presses, 0.3 1.2 %,
// 0.4 0.6 %.
#define CC_MOST_BEND 0.4f
#define CC_BEND_STEPS 15.0f

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
  v.b = (uint)(int)(offset * CC_OFFSET_STEPS + (offset < 0.0f ? -0.5f : 0.5f)) & 0xffffffu;
  return v;
}

CC_FN CcVoxel ccPackPlanes(uint first, uint count, int concave) {
  CcVoxel v;
  v.a = (count << 28) | (concave ? 0x80000000u : 0u);
  v.b = first;
  return v;
}

// By how many steps each level's bend is less than CC_MOST_BEND: bits 0-3 within the reach of a
// coarse sample of level 1, bits 4-7 of level 2. Rounded down.
CC_FN uint ccPackBend(float one, float two) {
  const float steps = CC_BEND_STEPS / CC_MOST_BEND;
  const uint a = (uint)(ccMin(ccMax((CC_MOST_BEND - one) * steps, 0.0f), CC_BEND_STEPS)),
             b = (uint)(ccMin(ccMax((CC_MOST_BEND - two) * steps, 0.0f), CC_BEND_STEPS));
  return a | (b << 4);
}
CC_FN void ccSetBend(CcVoxel* v, uint bend) {
  if (ccPlaneCount(*v) == 1u)
    v->b = (v->b & 0xffffffu) | (bend << 24);
  else
    v->a = (v->a & ~0xffu) | bend;
}
// By how far [voxels] the surface may rise above the record's planes where finer samples lie for
// which one of this level stands. Only of records with planes.
CC_FN float ccBend(CcVoxel v, int level) {
  const uint bend = ccPlaneCount(v) == 1u ? v.b >> 24 : v.a & 0xffu;
  const uint less = level == 1 ? bend & 15u : bend >> 4;
  return CC_MOST_BEND - (float)(int)less * (CC_MOST_BEND / CC_BEND_STEPS);
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
  d.depth = (float)((int)(v.b << 8) >> 8) * (1.0f / CC_OFFSET_STEPS) - ccDot(n, x);
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
