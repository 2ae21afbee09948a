// A plain solid as a cloud's samples see it: the depth at a place of the samples' grid. Plain C for
// C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_SHAPE_DEPTH_H
#define CLOUDCONTACT_KERNELS_SHAPE_DEPTH_H

#include "kernels/base/plain_solid.h"
#include "kernels/contact/search.h"

// Cosine of 26 deg: normals of a solid that differ by more over a sample meet at an edge.
#define CC_ONE_FACE 0.9f

typedef struct {
  CcSolid solid;
  CcPlacement toSolid;  // from the samples' grid [voxels] to the solid's frame [m]
  // Of a half-space, whose depth is linear in the grid's coordinates: offset - slope . x [m], and
  // its normal.
  float slope[3], offset, normal[3];
  float unused;
} CcShape;

CC_FN CcDepth ccHalfSpaceDepth(CC_GLOBAL const CcShape* s, const float* x) {
  const CcDepth d = {s->offset - (s->slope[0] * x[0] + s->slope[1] * x[1] + s->slope[2] * x[2]),
                     {s->normal[0], s->normal[1], s->normal[2]}};
  return d;
}

CC_FN CcSolidPoint ccPointInShape(CC_GLOBAL const CcShape* s, const float* x) {
  return ccInSolid(&s->solid, ccPlaced(&s->toSolid, ccVec(x[0], x[1], x[2])));
}

// Depth [m] and normal, in the solid's frame.
CC_FN CcDepth ccShapeDepth(CC_GLOBAL const CcShape* s, const float* x) {
  if (s->solid.kind == CC_HALF_SPACE) return ccHalfSpaceDepth(s, x);
  const CcSolidPoint p = ccPointInShape(s, x);
  const CcDepth d = {(float)p.depth, {(float)p.normal.x, (float)p.normal.y, (float)p.normal.z}};
  return d;
}

// What stands for a shape's record anywhere: one plane. A half-space rises above it nowhere. Beside
// the edge of another shape the way to it leans, and samples that lean on that reach farther.
CC_FN CcVoxel ccShapeRecord(int halfSpace) {
  CcVoxel record = ccPackPlanes(0, 1, 0);
  if (halfSpace) ccSetBend(&record, ccPackBend(0.0f, 0.0f));
  return record;
}

// Whether samples within `radius` voxels of a place may touch.
CC_FN int ccMayTouchShape(CC_GLOBAL const CcShape* s, const float* x, float radius, float voxel) {
  return ccPointInShape(s, x).depth >= -((radius + 0.5f) * voxel);
}

// Of a sample over an edge, half its diagonal [voxels]; 0 where it is small, or far from the solid.
CC_FN float ccHalfOverEdge(float width, float depth, float voxel) {
  const float reach = CC_HALF_DIAGONAL * width;
  return (width > CC_WIDE) & (ccAbs(depth) <= reach * voxel) ? reach : 0.0f;
}
// Four places beside a sample's middle; t1 and t2 are its tangents.
CC_FN void ccBesideSample(const float* middle, float reach, int k, const float* t1, const float* t2,
                          float* x) {
  const float* t = k < 2 ? t1 : t2;
  const float by = k & 1 ? -reach : reach;
  for (int i = 0; i < 3; ++i) x[i] = middle[i] + by * t[i];
}

// Whether the solid has an edge within a sample of the finest level.
CC_FN int ccShapeEdgeWithin(CC_GLOBAL const CcShape* s, const float* middle, const float* normal,
                            float width, float voxel, const CcDepth* at) {
  const float reach = ccHalfOverEdge(width, at->depth, voxel);
  if ((s->solid.kind == CC_HALF_SPACE) | !(reach > 0.0f)) return 0;
  float t1[3], t2[3];
  ccTangents(normal, t1, t2);
  for (int k = 0; k < 4; ++k) {
    float x[3];
    ccBesideSample(middle, reach, k, t1, t2, x);
    const CcDepth beside = ccShapeDepth(s, x);
    if (ccDot(beside.normal, at->normal) < CC_ONE_FACE) return 1;
  }
  return 0;
}

#endif
