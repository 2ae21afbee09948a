// The field's record of a voxel near the surface: 8 bytes that hold one plane, or the index of
// several planes at an edge. Plain C for C++ and OpenCL C; a test checks the offsets.
//
//   a: bits 0-27 the outward normal, octahedral, 14 bits each way (worst error 0.01 deg);
//      bits 28-30 the number of planes, 0: no surface near; bit 31: set if the planes'
//      half-spaces unite (a concave edge), clear if they intersect (a convex edge)
//   b: one plane: bits 8-31 its offset from the voxel's center, 8.16 fixed point, in voxels;
//      several: index of the first in the list of planes, which are records of one plane each
//   Bits 0-7 of b of one plane and of a of several: how far the surface rises above the planes
//   nearby, ccBend().
//   No plane, and bit 31 of a: the voxel is outside the band, where no depth is stored. Normal and
//   offset are of a plane; the surface nearby rises above it by the bend at most.
#ifndef CLOUDCONTACT_KERNELS_FIELD_VOXEL_H
#define CLOUDCONTACT_KERNELS_FIELD_VOXEL_H

#include "kernels/base/vector.h"

#define CC_NORMAL_STEPS 16383.0f
#define CC_OFFSET_STEPS 65536.0f
#define CC_MAX_PLANES 6
// [voxels] Steps of a bend on levels 1 and 2, and outside, and what is taken for one that nobody
// has measured. A surface may rise by more at an edge: where a thread of five voxels a pitch
// touches lightly, 0.125 leaves out 6 % of what presses, 0.3 1.2 %, 0.4 0.6 %.
#define CC_BEND_STEP 0.08f
#define CC_WIDE_BEND_STEP 0.15f
#define CC_OUTSIDE_STEP 0.03125f
#define CC_UNKNOWN_BEND 0.4f

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
  v.b = (uint)(int)(offset * CC_OFFSET_STEPS + (offset < 0.0f ? -0.5f : 0.5f)) << 8;
  return v;
}

CC_FN CcVoxel ccPackPlanes(uint first, uint count, int concave) {
  CcVoxel v;
  v.a = (count << 28) | (concave ? 0x80000000u : 0u);
  v.b = first;
  return v;
}

// 15 less the steps of each level's bend, or 1 of one that is larger: bits 0-3 within the reach of
// a coarse sample of level 1, bits 4-7 of level 2. 0: not measured.
CC_FN uint ccPackBend(float one, float two) {
  const float a = 15.0f - one / CC_BEND_STEP, b = 15.0f - two / CC_WIDE_BEND_STEP;
  return (uint)ccMin(ccMax(a, 1.0f), 15.0f) | (uint)ccMin(ccMax(b, 1.0f), 15.0f) << 4;
}
CC_FN void ccSetBend(CcVoxel* v, uint bend) {
  uint* to = ccPlaneCount(*v) == 1u ? &v->b : &v->a;
  *to = (*to & ~0xffu) | bend;
}
// Whether the record holds a plane that bounds what is near a voxel outside.
CC_FN int ccOutside(CcVoxel v) {
  return (v.a >> 28) == 8u;
}
// Makes such a record, if the bend is not larger than it can say. `plane`: of ccPackPlane().
CC_FN int ccPackOutside(CcVoxel plane, float bend, CcVoxel* v) {
  const float steps = ccMax(bend, 0.0f) / CC_OUTSIDE_STEP;
  if (!(steps < 255.0f)) return 0;
  v->a = (plane.a & 0xfffffffu) | 0x80000000u;
  v->b = (plane.b & ~0xffu) | ((uint)steps + 1u);
  return 1;
}
// By how far [voxels] the surface may rise above the record's planes where finer samples lie for
// which one of this level stands. Of records with planes, or outside; there those of level 1 are
// too far from the surface.
CC_FN float ccBend(CcVoxel v, int level) {
  const uint bend = (ccPlaneCount(v) > 1u ? v.a : v.b) & 0xffu;
  const int less = (int)(level == 1 ? bend & 15u : bend >> 4);
  const float measured = (float)(15 - less) * (level == 1 ? CC_BEND_STEP : CC_WIDE_BEND_STEP),
              near = less == 0 ? CC_UNKNOWN_BEND : measured,
              outside = level == 1 ? -1e30f : (float)(int)bend * CC_OUTSIDE_STEP;
  return ccOutside(v) ? outside : near;
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
  d.depth = (float)((int)v.b >> 8) * (1.0f / CC_OFFSET_STEPS) - ccDot(n, x);
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
