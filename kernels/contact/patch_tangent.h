// How the force of a patch changes as the bodies move a little: to first order, from its sums.
// Plain C for C++ and OpenCL C.
//
// At x from the center of pressure, in the patch's plane, the bodies come nearer by c + g.x: c is
// their motion along the normal there, and g is how they turn about each other, plus D^T v, as a
// slide v of A over B meets normals that turn by D x over the patch. With a patch of area a, volume
// v (area times depth), area's center m, covariance C, and normals that turn by A and -B over it,
// D = (A - B) / 2:
//   v grows by a c, but for a share that the slope of its pressure has;
//   the center of pressure moves by ((C + m m^T) g + m c) a/v. Under a ball that rolls it goes as
//     far as the ball does; on a thread that turns in its nut g is zero;
//   the normal turns by D C g a/v - (A + B)/4 v, and with both bodies by how far each decides it.
// Points that follow the bodies, each with its part of k, move the center of pressure and turn the
// normal as well: those of a face by as much, those of a ball, which are all at one place, not at
// all. So what they do is taken off here.
#ifndef CLOUDCONTACT_KERNELS_PATCH_TANGENT_H
#define CLOUDCONTACT_KERNELS_PATCH_TANGENT_H

#include "kernels/contact/patch_force.h"

typedef struct {
  double t1[3], t2[3];  // of the plane, world
  CcSymmetric2 roll;    // g to how far the points move besides [m]
  CcTwo aside;          // c to the same
  CcMatrix2 lean;       // D [1/m]
  CcMatrix2 bend;       // (A + B) / 4 [1/m]
  CcMatrix2 tilt;       // g to the turn of the normal
  double trustA;        // of A's turn in the normal's; the rest is B's
  double perDepth;      // a/v, or 0 of near misses [1/m]
} CcPatchTangent;

// `depth`: of the patch, whose part of k gives its force there [m].
CC_FN CcPatchTangent ccTangentOf(CC_GLOBAL const CcSums* patch, const CcPatchForce* force,
                                 const CcFlat* f, const CcPlan* plan, double depth) {
  CcPatchTangent t = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0},
                      {0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0},
                      force->trustA, 0.0};
  if (!(patch->facing > 0.0) || !(depth > 0.0)) return t;
  t.perDepth = patch->area / patch->facing;
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
  t.roll.uu = (f->spread.uu + cop.u * cop.u) * t.perDepth - own.uu;
  t.roll.uv = (f->spread.uv + cop.u * cop.v) * t.perDepth - own.uv;
  t.roll.vv = (f->spread.vv + cop.v * cop.v) * t.perDepth - own.vv;
  t.aside = ccTwo(-cop.u * t.perDepth - middle.u, -cop.v * t.perDepth - middle.v);
  const double wa = force->trustA * t.perDepth, wb = (1.0 - force->trustA) * t.perDepth;
  const CcMatrix2 a = f->turn[0], b = f->turn[1], mine = ccTimesSymmetric(plan->lean, own);
  t.tilt.uu = wa * a.uu - wb * b.uu - mine.uu;
  t.tilt.uv = wa * a.uv - wb * b.uv - mine.uv;
  t.tilt.vu = wa * a.vu - wb * b.vu - mine.vu;
  t.tilt.vv = wa * a.vv - wb * b.vv - mine.vv;
  t.lean = plan->lean;
  const double noise = CC_LEAN_VOXELS * plan->voxel * CC_LEAN_VOXELS * plan->voxel;
  const CcMatrix2 both = {0.25 * (a.uu + b.uu), 0.25 * (a.uv + b.uv), 0.25 * (a.vu + b.vu),
                          0.25 * (a.vv + b.vv)};
  t.bend = ccTimesSymmetric(both, ccInverse(f->spread, noise));
  return t;
}

#endif
