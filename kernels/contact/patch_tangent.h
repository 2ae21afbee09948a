// How the force of a patch changes as the bodies move a little: to first order, from its sums.
// Plain C for C++ and OpenCL C.
//
// At x from the center of pressure, in the patch's plane, the bodies come nearer by c + g.x: c is
// their motion along the normal there, and g is how they turn about each other, plus D^T v, as a
// slide v of A over B meets normals that turn by D x over the patch. With a patch of area a, volume
// w (area times depth), area's center m, covariance C, and normals that turn by A and -B over it,
// D = (A - B) / 2:
//   w grows by a (c + g.m);
//   the center of pressure moves by ((C + m m^T) g + m c) a/w. Under a ball that rolls it goes as
//     far as the ball does; on a thread that turns in its nut g is zero;
//   the normal turns by D C g a/w - (A + B)/4 v, and with both bodies by how far each decides it.
// Points that follow the bodies, each with its part of k, move the center of pressure and turn the
// normal as well: those of a face by as much, those of a ball, which are all at one place, not at
// all. So what they do is taken off here.
#ifndef CLOUDCONTACT_KERNELS_PATCH_TANGENT_H
#define CLOUDCONTACT_KERNELS_PATCH_TANGENT_H

#include "kernels/contact/patch_force.h"

// [voxels] Patches that are less deep have no tangent: what moves them changes all of it.
#define CC_LEAST_MEAN 1e-6

// In floats, since it tells of small changes. Matrices are by rows, in the plane of t1 and n x t1.
typedef struct {
  float t1[3];      // world
  float middle[2];  // m [m]
  float roll[3];    // g to how far the points move besides [m]: uu, uv, vv
  float aside[2];   // c to the same
  float lean[4];    // D [1/m]
  float bend[4];    // (A + B) / 4 [1/m]
  float tilt[4];    // g to the turn of the normal
  float trustA;     // of A's turn in the normal's; the rest is B's
  float perDepth;   // a/w, or 0 of near misses [1/m]
} CcPatchTangent;

CC_FN void ccPutMatrix(float* to, CcMatrix2 m) {
  to[0] = (float)m.uu;
  to[1] = (float)m.uv;
  to[2] = (float)m.vu;
  to[3] = (float)m.vv;
}

// Of a patch whose plane's axes are `t1` and `t2` in the world. `depth`: of the patch, whose part
// of k gives its force there [m].
CC_FN CcPatchTangent ccTangentOf(CC_GLOBAL const CcSums* patch, const CcPatchForce* force,
                                 const CcFlat* f, const CcPlan* plan, double depth, CcVec t1) {
  CcPatchTangent t = {{(float)t1.x, (float)t1.y, (float)t1.z},
                      {0.0f, 0.0f},
                      {0.0f, 0.0f, 0.0f},
                      {0.0f, 0.0f},
                      {0.0f, 0.0f, 0.0f, 0.0f},
                      {0.0f, 0.0f, 0.0f, 0.0f},
                      {0.0f, 0.0f, 0.0f, 0.0f},
                      (float)force->trustA,
                      0.0f};
  const double least = CC_LEAST_MEAN * plan->voxel;
  if (!(patch->facing > least * patch->area) || !(depth > least)) return t;
  const double perDepth = patch->area / patch->facing;
  t.perDepth = (float)perDepth;
  // What the points do by themselves: their spread over the depth.
  const double per = 0.25 / depth;
  CcSymmetric2 own = {0.0, 0.0, 0.0};
  CcTwo middle = {0.0, 0.0};
  for (int i = 0; i < 4; ++i) {
    const CcTwo at = plan->at[i];
    own.uu += per * at.u * at.u;
    own.uv += per * at.u * at.v;
    own.vv += per * at.v * at.v;
    middle = ccTwo(middle.u + per * at.u, middle.v + per * at.v);
  }
  const CcTwo cop = plan->cop;
  t.middle[0] = (float)-cop.u;
  t.middle[1] = (float)-cop.v;
  t.roll[0] = (float)((f->spread.uu + cop.u * cop.u) * perDepth - own.uu);
  t.roll[1] = (float)((f->spread.uv + cop.u * cop.v) * perDepth - own.uv);
  t.roll[2] = (float)((f->spread.vv + cop.v * cop.v) * perDepth - own.vv);
  t.aside[0] = (float)(-cop.u * perDepth - middle.u);
  t.aside[1] = (float)(-cop.v * perDepth - middle.v);
  const double wa = force->trustA * perDepth, wb = (1.0 - force->trustA) * perDepth;
  const CcMatrix2 a = f->turn[0], b = f->turn[1], mine = ccTimesSymmetric(plan->lean, own);
  const CcMatrix2 tilt = {wa * a.uu - wb * b.uu - mine.uu, wa * a.uv - wb * b.uv - mine.uv,
                          wa * a.vu - wb * b.vu - mine.vu, wa * a.vv - wb * b.vv - mine.vv};
  const double noise = CC_LEAN_VOXELS * plan->voxel * CC_LEAN_VOXELS * plan->voxel;
  const CcMatrix2 both = {0.25 * (a.uu + b.uu), 0.25 * (a.uv + b.uv), 0.25 * (a.vu + b.vu),
                          0.25 * (a.vv + b.vv)};
  ccPutMatrix(t.tilt, tilt);
  ccPutMatrix(t.lean, plan->lean);
  ccPutMatrix(t.bend, ccTimesSymmetric(both, ccInverse(f->spread, noise)));
  return t;
}

#endif
