// The bin of a hit, and the conditions under which bins grow together to a patch (docs/force.md,
// "Bins", "Growing patches"). Plain C for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_HIT_BINS_H
#define CLOUDCONTACT_KERNELS_HIT_BINS_H

#include "kernels/base/vector64.h"
#include "kernels/contact/hit_sums.h"

// A sample fully faces the other body if the cosine between the normals exceeds this. At a wall
// that runs along the other's face the cosine is zero within the noise of the fitted normals
// (0.02).
#define CC_FACING 0.2f
// Of a piece of surface whose middle is outside the other body, what lies behind the other's plane
// is in that body only if the piece faces it: beyond an edge the plane is not the surface. It
// counts from this cosine on. Otherwise a box just above another, turned by 1 degree, is pushed
// away by the extended sides of its own bottom edges, by any force.
#define CC_ACROSS 0.02f
// Bins are alike if the mean normals on one body agree this well (22 deg) ...
#define CC_AGREE 0.93
// ... and those on the other do not disagree.
#define CC_DISAGREE (-0.2)
// Bins are close if their centers are nearer than this share of a cell. A bin that joins by a link
// alone must have this share of its patch's push.
#define CC_CLOSE 0.5
#define CC_LEAST_LINK 0.05
#define CC_LINK 0.7

#define CC_KEY_BITS 14  // of a cell's coordinate; no grid has more cells

typedef struct {
  int x, y, z;    // cell
  int direction;  // one of six
  float gate;     // how far it faces the other body, 0..1
} CcBinOfHit;

// `depth`: at the sample's middle.
CC_FN float ccGate(float facing, float depth) {
  const float inside = facing * (1.0f / CC_FACING),
              outside = (facing - CC_ACROSS) * (1.0f / (CC_FACING - CC_ACROSS));
  return ccMin(ccMax(depth > 0.0f ? inside : outside, 0.0f), 1.0f);
}

// The direction is the axis nearest to the other body's normal less the gated own normal. It is
// seen from A to B for samples of either body (`side` 0: A's), so that both meet in one bin.
// `perCell` [1/m].
CC_FN CcBinOfHit ccBinOf(const float* at, const float* own, const float* other, float facing,
                         float depth, int side, float perCell) {
  CcBinOfHit b;
  const float u = at[0] * perCell, v = at[1] * perCell, w = at[2] * perCell;
  const int x = (int)u, y = (int)v, z = (int)w;
  b.x = x - (u < (float)x ? 1 : 0);
  b.y = y - (v < (float)y ? 1 : 0);
  b.z = z - (w < (float)z ? 1 : 0);
  b.gate = ccGate(facing, depth);
  const float sign = side == 0 ? -1.0f : 1.0f;
  const float nx = sign * (other[0] - b.gate * own[0]), ny = sign * (other[1] - b.gate * own[1]),
              nz = sign * (other[2] - b.gate * own[2]);
  const float ax = ccAbs(nx), ay = ccAbs(ny), az = ccAbs(nz);
  const int yz = ay >= az ? 2 + (ny < 0.0f) : 4 + (nz < 0.0f);
  const int xs = 0 + (nx < 0.0f);
  b.direction = ((ax >= ay) & (ax >= az)) != 0 ? xs : yz;
  return b;
}

CC_FN ulong ccBinKey(int x, int y, int z, int direction) {
  const ulong mask = ((ulong)1 << CC_KEY_BITS) - 1;
  return ((ulong)x & mask) | ((ulong)y & mask) << CC_KEY_BITS |
         ((ulong)z & mask) << (2 * CC_KEY_BITS) | (ulong)direction << (3 * CC_KEY_BITS);
}

// The mean normals of a bin or of a patch.
typedef struct {
  CcVec normal[2];   // sums of A's and of B's normals
  double length[2];  // of these
} CcFaces;

// Whether dot / length >= least, without the division if rounding cannot matter. A sum without
// length counts as 1.
CC_FN int ccAtLeast(double dot, double length, double least) {
  if (!(length > 0.0)) return 1.0 >= least;
  const double beyond = dot - least * length, doubt = 1e-14 * length;
  if (beyond > doubt) return 1;
  if (beyond < -doubt) return 0;
  return dot / length >= least;
}

CC_FN int ccAlike(const CcFaces* a, const CcFaces* b, double agree) {
  double dot[2], length[2];
  for (int s = 0; s < 2; ++s) {
    dot[s] = ccDot64(a->normal[s], b->normal[s]);
    length[s] = a->length[s] * b->length[s];
  }
  return (ccAtLeast(dot[0], length[0], agree) || ccAtLeast(dot[1], length[1], agree)) &&
         ccAtLeast(dot[0], length[0], CC_DISAGREE) && ccAtLeast(dot[1], length[1], CC_DISAGREE);
}

// Where edges cross, each face of one body meets two of the other. That makes four bins; the last
// shares no face with the first, but one with each neighbor. Links are short, or a whole turn of a
// thread would become one patch. `weight`: of the bin; `all`: of the patch.
CC_FN int ccLinked(const CcFaces* bin, const CcFaces* from, double weight, double all, CcVec center,
                   CcVec centerFrom, double close) {
  if (weight < CC_LEAST_LINK * all || !ccAlike(bin, from, CC_LINK)) return 0;
  return ccLength64(ccMinus(center, centerFrom)) < close;
}

#endif
