// A sample of one body in the records of another's field: its depth, whether it is a hit, whether
// finer samples beside it may be hits, and whether it must be divided. Plain C for C++ and OpenCL
// C.
#ifndef CLOUDCONTACT_KERNELS_SEARCH_H
#define CLOUDCONTACT_KERNELS_SEARCH_H

#include "kernels/contact/field_voxel.h"
#include "kernels/contact/sample.h"

// Kinds of samples.
#define CC_WET 1     // deep enough to be a hit
#define CC_DEEP 2    // below the band
#define CC_NEARBY 4  // finer samples of its cell may touch

// Values of `b` in a record without planes: below the band, or outside with a voxel of the band
// within four.
#define CC_DEEP_INSIDE 1u
#define CC_NEAR_OUTSIDE 2u

#define CC_HALF_WIDTH \
  0.5f  // of a sample; the depth varies over it by the sine between the surfaces
#define CC_HALF_DIAGONAL 0.71f
#define CC_WIDE 0.3f         // [voxels] wider samples are divided at an edge
#define CC_ROUNDED 1e-3f     // [voxels] more than sums of places are rounded by
#define CC_BEYOND_BAND 5.5f  // depth given to a sample below the band's last layer [voxels]

// What a sample of a coarse level stands for: the finer samples that face the same way. They rise
// at most `rise` above its plane, and lie within an ellipse in it: as far as the root of g.S.g
// along a direction g, S = {xx, yy, zz, xy, xz, yz}. In voxels, in the samples' grid.
typedef struct {
  float rise;
  float spread[6];
} CcCluster;

CC_FN float ccSpreadAlong(const CcCluster* e, const float* g) {
  const float* s = e->spread;
  return s[0] * g[0] * g[0] + s[1] * g[1] * g[1] + s[2] * g[2] * g[2] +
         2.0f * (s[3] * g[0] * g[1] + s[4] * g[0] * g[2] + s[5] * g[1] * g[2]);
}

// Limits of a level.
typedef struct {
  float halfWidth;  // [m] half the width of a sample one voxel wide
  float perVoxel;   // [1/m]
  int level;
  int nearby, nearOutside;  // CC_NEARBY if there are finer samples
} CcLimits;

// `level` of the samples, 0 the finest; `voxel` in meters.
CC_FN CcLimits ccLimitsOf(int level, float voxel) {
  CcLimits l;
  l.halfWidth = CC_HALF_WIDTH * voxel;
  l.perVoxel = 1.0f / voxel;
  l.level = level;
  l.nearby = level > 0 ? CC_NEARBY : 0;
  l.nearOutside = level > 1 ? CC_NEARBY : 0;
  return l;
}

// The kind of a sample `width` voxels wide at `depth` [m] in the other body, but for CC_NEARBY
// where the record tells of a surface.
CC_FN int ccKindOf(CC_NEAR const CcLimits* limits, CcVoxel record, float depth, float width) {
  const int surface = depth > -(limits->halfWidth * width) ? CC_WET : 0;
  const int plain = record.b == CC_DEEP_INSIDE    ? CC_DEEP | limits->nearby
                    : record.b == CC_NEAR_OUTSIDE ? limits->nearOutside
                                                  : 0;
  return (record.a & 0x70000000u) != 0 ? surface : plain;
}

// The largest depth [voxels] below a plane that the finer samples in the sample's own plane have:
// as far as the other's plane rises beside it. `depth` [m] and `normal`: the other's, in its frame.
CC_FN float ccDepthBeside(CC_NEAR const CcLimits* limits, CC_NEAR const float* turnToOther,
                          const CcCluster* cluster, float depth, const float* normal) {
  float other[3];
  ccTurnBack(turnToOther, normal, other);
  return depth * limits->perVoxel + CC_SQRT(ccMax(ccSpreadAlong(cluster, other), 0.0f));
}

// Whether finer samples that this one stands for may touch the surface of which the record tells.
// `beside`: ccDepthBeside() of the record's plane; of several, the least where they intersect, and
// the largest where they unite.
CC_FN int ccNearBeside(CC_NEAR const CcLimits* limits, CcVoxel record, float beside, float rise) {
  return ((record.a & 0xf0000000u) != 0) &
         (beside + ccBend(record, limits->level) + rise > -CC_ROUNDED);
}

// The same of a record with planes. `depth` [m] and `normal`: of the plane that gives the depth at
// `place`; `voxel`: the record's [m].
CC_FN int ccNearByPlanes(CC_NEAR const CcLimits* limits, CC_NEAR const float* turnToOther,
                         const CcCluster* cluster, CcVoxel record, CC_GLOBAL const CcVoxel* planes,
                         const float* place, float depth, const float* normal, float voxel) {
  float beside = ccDepthBeside(limits, turnToOther, cluster, depth, normal);
  const uint count = ccPlaneCount(record);
  const int concave = ccConcave(record);
  for (uint i = 0; count > 1u && i < count; ++i) {
    const CcDepth one = ccPlaneDepth(planes[record.b + i], place);
    const float own = ccDepthBeside(limits, turnToOther, cluster, one.depth * voxel, one.normal);
    beside = i == 0 ? own : concave ? ccMax(beside, own) : ccMin(beside, own);
  }
  return ccNearBeside(limits, record, beside, cluster->rise);
}

// Whether a wet sample may be a hit; never 0 if it is. `facing`: cosine between the normals, to
// 1e-5.
CC_FN int ccMayHit(CC_NEAR const CcLimits* limits, float depth, float facing, float width) {
  const float reach = limits->halfWidth * width;
  return (depth > 0.0f) | (depth * depth <= reach * reach * (1.0f - facing * facing + 1e-4f));
}

// Whether a plane may give the depth somewhere within `far` [m] of a sample at which another plane
// gives `depth` [m] and `normal`. `place`: from the record's voxel; `voxel`: the record's [m].
CC_FN int ccPlaneWithin(CcVoxel plane, const float* place, float depth, const float* normal,
                        float far, float voxel) {
  const CcDepth d = ccPlaneDepth(plane, place);
  const float turn[3] = {d.normal[0] - normal[0], d.normal[1] - normal[1], d.normal[2] - normal[2]};
  const float apart = ccAbs(d.depth * voxel - depth);
  return (apart > 0.0f) & (apart < far * CC_SQRT(ccDot(turn, turn)));
}

// Whether a sample must be divided if it lies over an edge: it is wide, and a part of it may be a
// hit. Where planes intersect, a part is at most as deep as below the plane that gives the middle's
// depth. `facing`: cosine between the normals, to 1e-5; `own`: the sample's voxel [m].
CC_FN int ccMayDivide(CC_NEAR const CcLimits* limits, CcVoxel record, float depth, float facing,
                      float width, float own) {
  const float slope = CC_SQRT(ccMax(1.0f - facing * facing, 0.0f) + 1e-4f);
  const float beside = own * (CC_HALF_DIAGONAL * width * slope + CC_HALF_WIDTH * CC_WIDE);
  const int unites = (record.a & 0x80000000u) != 0;
  return (width > CC_WIDE) & (depth > -(limits->halfWidth * width)) & (unites | (depth > -beside));
}

// Whether another plane of the record may give the depth somewhere within a sample `width` voxels
// wide that may have to be divided. The rest as above.
CC_FN int ccEdgeWithin(CC_NEAR const CcLimits* limits, CcVoxel record,
                       CC_GLOBAL const CcVoxel* planes, const float* place, float depth,
                       const float* normal, float facing, float width, float voxel, float own) {
  if (!ccMayDivide(limits, record, depth, facing, width, own)) return 0;
  const float far = CC_HALF_DIAGONAL * (width * own);
  for (uint k = 0; k < ccPlaneCount(record); ++k) {
    if (ccPlaneWithin(planes[record.b + k], place, depth, normal, far, voxel)) return 1;
  }
  return 0;
}

// The number of parts along each side of a divided sample.
CC_FN int ccPartsAlong(float width) {
  const float ratio = width / CC_WIDE;
  const int whole = (int)ratio;
  return whole + (ratio > (float)whole ? 1 : 0);
}

// From the sample's middle to that of its k-th part; t1 and t2 are tangents of the sample.
CC_FN void ccPartAside(float width, int along, int k, const float* t1, const float* t2,
                       float* aside) {
  const float a = (float)(k % along) - 0.5f * (float)(along - 1),
              b = (float)(k / along) - 0.5f * (float)(along - 1);
  for (int i = 0; i < 3; ++i) aside[i] = width * (a * t1[i] + b * t2[i]);
}

// Depth [m] of a sample below the band, by the number of bricks to the nearest one with the band.
CC_FN float ccDepthBelow(int bricks, float voxel) {
  const int whole = bricks > 1 ? bricks - 1 : 0;
  return (CC_BEYOND_BAND + (float)(whole * 8)) * voxel;
}

// Whether a brick of samples, within `radius` of `center`, may touch the other body. `ratio`: of
// the voxels, own to other; `between`: voxels from each of the other's bricks to its band.
CC_FN int ccBrickTouches(CC_NEAR const CcMap* toOther, const float* center, float radius,
                         float ratio, CcBricks bricks, CC_GLOBAL const int* between) {
  float at[3];
  ccApply(toOther, center, at);
  int brick;
  const float away = ccAwayFrom(bricks, at, &brick);
  const float reach = (radius + 0.5f) * ratio;
  return (away <= reach) & ((float)between[brick] - away <= reach);
}

// Makes a hit: maps `at`, the sample's normal and the other's into the pair's frame.
CC_FN CcHit ccHitIn(CC_NEAR const CcMap* toFrame, CC_NEAR const float* fromOwn,
                    CC_NEAR const float* fromOther, const float* at, const float* normal,
                    const float* other, float depth, float spread) {
  float place[3], own[3], there[3];
  ccApply(toFrame, at, place);
  ccTurn(fromOwn, normal, own);
  ccTurn(fromOther, other, there);
  return ccHitOf(place, own, there, depth, spread);
}

#endif
