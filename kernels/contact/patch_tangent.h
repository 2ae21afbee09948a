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
//   the normal turns by D C g a/w - (A + B)/4 v, and with both bodies by how far each decides it;
//   as the bodies spin by s about the normal, they come nearer by s q(x), q = D x . (n x x), and a
//   torque of s times the mean of q^2 a/w times the force turns them back: a hook does not spin
//   freely in a ring. Its mean is that over an ellipse with the covariance C.
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
  float twist;      // spin to how the normals lean around the center of pressure [1/m]
} CcPatchTangent;

CC_FN void ccPutMatrix(float* to, CcMatrix2 m) {
  to[0] = (float)m.uu;
  to[1] = (float)m.uv;
  to[2] = (float)m.vu;
  to[3] = (float)m.vv;
}

// The mean of q^2 by the products of places, of uu uu, uv uv and so on.
typedef struct {
  double uuuu, uuuv, uuvv, uvvv, vvvv;
} CcFourths;

CC_FN double ccMeanTwist(CcMatrix2 d, CcFourths m) {
  const double apart = d.uu - d.vv, across = 0.5 * (d.uv + d.vu);
  return apart * apart * m.uuvv + across * across * (m.uuuu + m.vvvv - 2.0 * m.uuvv) +
         2.0 * apart * across * (m.uvvv - m.uuuv);
}

// Of an ellipse that is wet evenly.
CC_FN CcFourths ccFourthsOf(CcSymmetric2 c) {
  const CcFourths m = {2.0 * c.uu * c.uu, 2.0 * c.uu * c.uv,
                       (2.0 / 3.0) * (c.uu * c.vv + 2.0 * c.uv * c.uv), 2.0 * c.uv * c.vv,
                       2.0 * c.vv * c.vv};
  return m;
}

// Of four points.
CC_FN CcFourths ccFourthsAt(const CcTwo* at) {
  CcFourths m = {0.0, 0.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < 4; ++i) {
    const double uu = at[i].u * at[i].u, uv = at[i].u * at[i].v, vv = at[i].v * at[i].v;
    m.uuuu += 0.25 * uu * uu;
    m.uuuv += 0.25 * uu * uv;
    m.uuvv += 0.25 * uv * uv;
    m.uvvv += 0.25 * uv * vv;
    m.vvvv += 0.25 * vv * vv;
  }
  return m;
}

// How the points' normals lean around the center of pressure for a spin [1/m]: what the patch's
// torque asks for beside their own. `lean`: D.
CC_FN double ccTwistOf(const CcFlat* f, const CcPlan* plan, CcMatrix2 lean, double perDepth,
                       double depth) {
  double polar = CC_SPIN_NOISE * plan->voxel * plan->voxel;
  for (int i = 0; i < 4; ++i)
    polar += 0.25 * (plan->at[i].u * plan->at[i].u + plan->at[i].v * plan->at[i].v);
  const double all = perDepth * ccMeanTwist(lean, ccFourthsOf(f->spread)),
               own = ccMeanTwist(plan->lean, ccFourthsAt(plan->at)) / depth;
  return (all - own) / polar;
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
                      0.0f,
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
  const double noise = CC_LEAN_VOXELS * plan->voxel * CC_LEAN_VOXELS * plan->voxel,
               little = CC_SPIN_NOISE * plan->voxel * plan->voxel;
  const CcMatrix2 both = {0.25 * (a.uu + b.uu), 0.25 * (a.uv + b.uv), 0.25 * (a.vu + b.vu),
                          0.25 * (a.vv + b.vv)};
  // Unlike the points' own, since small patches tell how far they move well enough.
  const CcMatrix2 across = {0.5 * (a.uu - b.uu), 0.5 * (a.uv - b.uv), 0.5 * (a.vu - b.vu),
                            0.5 * (a.vv - b.vv)};
  const CcMatrix2 lean = ccTimesSymmetric(across, ccInverse(f->spread, little));
  t.twist = (float)ccTwistOf(f, plan, lean, perDepth, depth);
  ccPutMatrix(t.tilt, tilt);
  ccPutMatrix(t.lean, lean);
  ccPutMatrix(t.bend, ccTimesSymmetric(both, ccInverse(f->spread, noise)));
  return t;
}

#endif
