// How deep the sharp edges and corners of one body are in another (docs/force.md, "Depth of the
// pair"). Plain C for C++ and OpenCL C.
//
// Near a sample each voxel with several planes is asked. Two planes meet in a line, of which the
// point nearest to the voxel's middle counts, and three in a corner. A point counts if it lies in
// or beside its voxel and behind the voxel's other planes.
#ifndef CLOUDCONTACT_KERNELS_SHARP_POINT_H
#define CLOUDCONTACT_KERNELS_SHARP_POINT_H

#include "kernels/contact/field_voxel.h"
#include "kernels/contact/look_up.h"

#define CC_SHARP_BESIDE 0.6f   // [voxels] from the voxel's middle, along each axis
#define CC_SHARP_BEHIND 0.05f  // [voxels] that a point may lie before another plane
#define CC_SHARP_ALIKE 0.98f   // planes closer than 11 deg have no sharp edge
#define CC_SHARP_LEAST 0.3f    // volume of three normals that meet in a corner

// A field's records.
typedef struct {
  CcBricks bricks;
  CC_GLOBAL const int* firsts;
  CC_GLOBAL const CcVoxel *records, *planes;
} CcRecords;

CC_FN CcVoxel ccRecordOf(CC_NEAR const CcRecords* f, const float* x, CcPlace* place) {
  *place = ccPlaceOf(f->bricks, x);
  return f->records[f->firsts[place->brick] + place->cell];
}

// The planes of a record, from its voxel's middle.
typedef struct {
  int count;
  CcDepth plane[CC_MAX_PLANES];
} CcPlanes;

// Whether a point lies in or beside its voxel and behind all its planes.
CC_FN int ccIsSharp(const CcPlanes* p, const float* x) {
  const float far = ccMax(ccMax(ccAbs(x[0]), ccAbs(x[1])), ccAbs(x[2]));
  int is = far <= CC_SHARP_BESIDE;
  for (int k = 0; k < p->count; ++k)
    is &= p->plane[k].depth - ccDot(p->plane[k].normal, x) >= -CC_SHARP_BEHIND;
  return is;
}

// Whether most neighbors that know corners have a point behind all their planes. The line of two
// planes goes on past a corner, and one voxel in a hundred beside a corner has a wrong face.
CC_FN int ccIsConfirmed(CC_NEAR const CcRecords* own, const float* at) {
  int yes = 0, no = 0;
  for (int k = 0; k < 27; ++k) {
    const float aside[3] = {(float)(k % 3 - 1), (float)(k / 3 % 3 - 1), (float)(k / 9 - 1)};
    const float x[3] = {at[0] + aside[0], at[1] + aside[1], at[2] + aside[2]};
    CcPlace place;
    const CcVoxel record = ccRecordOf(own, x, &place);
    if (ccPlaneCount(record) < 3u || ccConcave(record)) continue;
    for (int i = 0; i < 3; ++i) place.r[i] -= aside[i];
    const float depth = ccVoxelDepth(record, own->planes, place.r).depth;
    depth > -2.0f * CC_SHARP_BEHIND ? ++yes : ++no;
  }
  return yes >= no;
}

// One body's sharp points on their way into another.
typedef struct {
  CcRecords own, other;
  CcMap toOther, toFrame;  // from the own grid, as in CcWay
  float voxel;             // the own one [m]
} CcSharpWay;

// The larger of `deepest` [other's voxels] and the depth of a point at `x` from a voxel's middle.
CC_FN float ccSharpDepth(CC_NEAR const CcSharpWay* way, const CcPlanes* p, const float* middle,
                         const float* x, float deepest) {
  if (!ccIsSharp(p, x)) return deepest;
  const float at[3] = {middle[0] + x[0], middle[1] + x[1], middle[2] + x[2]};
  float there[3];
  ccApply(&way->toOther, at, there);
  CcPlace place;
  const CcVoxel record = ccRecordOf(&way->other, there, &place);
  if (ccPlaneCount(record) == 0u) return deepest;
  const float depth = ccVoxelDepth(record, way->other.planes, place.r).depth;
  return depth > deepest && ccIsConfirmed(&way->own, at) ? depth : deepest;
}

// Where three planes meet; returns whether they do.
CC_FN int ccCornerOf(const CcDepth* a, const CcDepth* b, const CcDepth* c, float* x) {
  const float *n = a->normal, *m = b->normal, *o = c->normal;
  const float mo[3] = {m[1] * o[2] - m[2] * o[1], m[2] * o[0] - m[0] * o[2],
                       m[0] * o[1] - m[1] * o[0]},
              on[3] = {o[1] * n[2] - o[2] * n[1], o[2] * n[0] - o[0] * n[2],
                       o[0] * n[1] - o[1] * n[0]},
              nm[3] = {n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2],
                       n[0] * m[1] - n[1] * m[0]};
  const float volume = ccDot(n, mo);
  if (ccAbs(volume) < CC_SHARP_LEAST) return 0;
  const float per = 1.0f / volume;
  for (int i = 0; i < 3; ++i) x[i] = per * (a->depth * mo[i] + b->depth * on[i] + c->depth * nm[i]);
  return 1;
}

// The same of all sharp points of the voxel at `middle`.
CC_FN float ccSharpIn(CC_NEAR const CcSharpWay* way, const float* middle, float deepest) {
  CcPlace place;
  const CcVoxel record = ccRecordOf(&way->own, middle, &place);
  if (ccPlaneCount(record) < 2u || ccConcave(record)) return deepest;
  const float none[3] = {0.0f, 0.0f, 0.0f};
  CcPlanes p;
  p.count = (int)ccPlaneCount(record);
  for (int k = 0; k < p.count; ++k)
    p.plane[k] = ccPlaneDepth(way->own.planes[record.b + (uint)k], none);
  for (int i = 0; i < p.count; ++i)
    for (int j = i + 1; j < p.count; ++j) {
      const CcDepth *a = &p.plane[i], *b = &p.plane[j];
      const float c = ccDot(a->normal, b->normal);
      if (c > CC_SHARP_ALIKE) continue;
      const float per = 1.0f / (1.0f - c * c), u = per * (a->depth - c * b->depth),
                  v = per * (b->depth - c * a->depth);
      float x[3];
      for (int l = 0; l < 3; ++l) x[l] = u * a->normal[l] + v * b->normal[l];
      deepest = ccSharpDepth(way, &p, middle, x, deepest);
      for (int k = j + 1; k < p.count; ++k)
        if (ccCornerOf(a, b, &p.plane[k], x)) deepest = ccSharpDepth(way, &p, middle, x, deepest);
    }
  return deepest;
}

// The number of voxels that are asked about a sample of a level, and the middle of the k-th.
CC_FN int ccSharpVoxels(int level) {
  const int edge = 2 * (1 << level) + 1;
  return edge * edge * edge;
}
CC_FN void ccSharpMiddle(const float* sample, int level, int k, float* middle) {
  const int reach = 1 << level, edge = 2 * reach + 1;
  const int aside[3] = {k % edge - reach, k / edge % edge - reach, k / (edge * edge) - reach};
  for (int i = 0; i < 3; ++i) {
    const float whole = (float)(int)ccMax(sample[i], 0.0f);
    middle[i] = whole + (float)aside[i] + 0.5f;
  }
}

// Where the sample of a hit is in its grid [voxels]. `at`: the hit in the frame [m]; `middle`: the
// mean depth of its wet part [m]; `own`: its normal.
CC_FN void ccSampleOfHit(CC_NEAR const CcSharpWay* way, const float* at, const float* own,
                         float middle, float* sample) {
  float back[3];
  for (int i = 0; i < 3; ++i) back[i] = at[i] + 0.5f * middle * own[i] - way->toFrame.shift[i];
  ccTurnBack(way->toFrame.turn, back, sample);
  const float per = 1.0f / (way->voxel * way->voxel);
  for (int i = 0; i < 3; ++i) sample[i] *= per;
}

#endif
