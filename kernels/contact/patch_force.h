// Direction, torque and points of a patch, from its sums. Plain C for C++ and OpenCL C.
//
// Force (docs/force.md, "Patch force"). The sum of area times depth along a body's own normals is
// the gradient of the overlap's energy. Under the paper's law, one spring a pair, the magnitude
// does not grow with area and the energy knows no edge. So the push of walls that run along the
// other body's face is removed as far as both bodies agree on it, and the more coherent body (a
// face against an edge) decides the direction.
//
// Points (docs/force.md, "Points"). For a patch with center x, covariance C and mean depth 1, four
// points at x0 + sqrt(C') (+-1, +-1) with depths 1 + g.xi have force 1 and center of pressure
// x0 + C' g, for any C' and g. So x0 = cop - C' g makes the wrench exact, and the rest is free:
//   g  = C^-1 (cop - x), the slope of the pressure, limited so that no point pulls;
//   C' = C where a body rests on the patch, shrunk to zero where it rolls on it.
// The root is symmetric, so the points do not turn with the eigenvectors of a round patch. Of a
// ring, they are exactly on its circle.
//
// Resting and rolling. As a body turns by an angle z over a patch of mean depth d, its center of
// pressure moves by C/d z: C/d is the height of the metacenter over the patch, as of a ship whose
// waterline is the patch. The body's own center, at the height l, moves by l z. So the pressure
// turns the body about its center by the force times (C/d - l) z, which is what points with C' = C
// - d l do within a step. Of a ball, as of all that is round about its center, this is zero, and
// points apart would brake it: an implicit step moves the pressure ahead, but not the center. Of a
// face, a ring or an edge C/d is many times l, and with its points in one place a body would rock
// on them for ever, since each step sees only afterwards how far it has turned.
//
// An arc or a thread is not wet where such a plan puts its points. Each point moves to the nearest
// hit (wet_hits.h) if it is beside all of them, and the weights follow. Last, it moves along its
// own normal to midway between the surfaces, which changes no moment.
#ifndef CLOUDCONTACT_KERNELS_PATCH_FORCE_H
#define CLOUDCONTACT_KERNELS_PATCH_FORCE_H

#include "kernels/base/vector64.h"
#include "kernels/contact/wet_hits.h"

// Below this incoherence both bodies decide alike; the noise of the fitted normals is 0.001.
#define CC_COHERENCE_NOISE 0.003
// A shape's normals have no noise but rounding. If they all agree the shape decides, even against a
// cloud's rim of which only the side is in contact (else a peg on its rim is pushed 11 deg aside).
#define CC_FORMULA_NOISE 1e-6
#define CC_LEAST_WEIGHT 0.05  // of a point, so that none pulls
// In patches narrower than this [voxels] the normals' gradient is noise. Points that do not lean
// with their flank brake a thread through the pair's damping: on an M16 thread their normals
// are 3.3 deg off the direction of the screw with 8, 1.3 deg with 1.
#define CC_LEAN_VOXELS 1.0
// [voxels^2] The same of a patch's spin, and of how far it moves as bodies slide: its sums tell
// both.
#define CC_SPIN_NOISE 0.05
// What a rolling body rests on is noise, 0.06 of C under a ball of 20 voxels that sags by 0.1, and
// points apart would brake it. So less than this counts as none, and a little more as it is.
// Without it balls and cylinders lose 1.4-3.3 % of their speed in 3 m, with it less than 1 %.
#define CC_ROUND 0.09
#define CC_ROUND_AGAIN 5.0
// [voxels] How uneven the fits leave surfaces: a light touch may spread as if it were deeper by
// this. Without it gears with half a voxel of backlash catch, since they roll on each other's
// flanks.
#define CC_UNEVEN 0.1
// [voxels] A patch whose surfaces bend by less is flat, as curvature times the spread of places. A
// box has 4e-6 at most, a peg of 40 voxels on a plane 0.03.
#define CC_FLAT 0.005
#define CC_MOST_SPIN 0.3  // [rad] by which a point's normal leans for the patch's spin
// The tangent of the most by which points lean from their patch's normal. What they press beside it
// they take back from each other: at 80 deg each presses six times what is left of it. The points
// of half a circle lean by 1.6; a sheet that another body has passed has both of its sides in a
// patch.
#define CC_MOST_LEAN 2.0
// [voxels] Points closer together than this share a moment by moving together, not by weights. With
// 0.5 weights swing so far from step to step that a nut gains 1 % of energy on its way down its
// bolt; from 1 to 4 it gains none.
#define CC_WET_NOISE 1.0

// A patch's force before the law scales it: direction and torque, in units of area times depth.
typedef struct {
  CcVec normal;   // direction of the force on B; zero if there is none
  double size;    // of the force [m^3]
  CcVec torque;   // about the patch's center [m^4]
  CcVec center;   // of the area, frame body [m]
  double trustA;  // weight of A's surface, 0..1; larger if A is more coherent
  // How far curvature separates the surfaces over the patch, the mean weighted by volume [m]. For a
  // patch of depth d: d/3 for balls, d/5 for a cylinder's side on a face, 0 for faces that fit.
  double fall;
  double lean;  // mean cosine of A's normals to their mean, times the same of B's
} CcPatchForce;

// The patch in its own plane.
typedef struct {
  CcVec n, t1, t2;
  CcSymmetric2 spread, inverse;  // C, and C^-1, regularized
  CcMatrix2 turn[2];             // of each body's normals over the patch: curvature times C [m]
} CcFlat;

// A matrix by columns times a vector.
CC_FN CcVec ccColumnsTimes(CC_GLOBAL const double* m, CcVec v) {
  return ccPlus(ccPlus(ccTimes(v.x, ccVecAt(m)), ccTimes(v.y, ccVecAt(m + 3))),
                ccTimes(v.z, ccVecAt(m + 6)));
}

// From the plane's coordinates to the frame body's.
CC_FN CcVec ccOutOfPlane(const CcFlat* f, CcVec v) {
  return ccPlus(ccTimes(v.z, f->n), ccPlus(ccTimes(v.x, f->t1), ccTimes(v.y, f->t2)));
}

CC_FN CcFlat ccFlatten(CC_GLOBAL const CcSums* patch, CcVec n) {
  CcFlat f;
  f.n = n;
  ccTangents64(n, &f.t1, &f.t2);
  const double per = 1.0 / patch->area;
  const CcVec x = ccTimes(per, ccVecAt(patch->first));
  const double x1 = ccDot64(x, f.t1), x2 = ccDot64(x, f.t2);
  const CcVec s1 = ccColumnsTimes(patch->second, f.t1), s2 = ccColumnsTimes(patch->second, f.t2);
  f.spread.uu = per * ccDot64(f.t1, s1) - x1 * x1;
  f.spread.uv = per * ccDot64(f.t1, s2) - x1 * x2;
  f.spread.vv = per * ccDot64(f.t2, s2) - x2 * x2;
  // A patch of one sample has no spread; a thousandth of its area regularizes it.
  f.inverse = ccInverse(f.spread, 1e-3 * (patch->area + f.spread.uu + f.spread.vv));
  double cosine = 0.0;
  for (int s = 0; s < 2; ++s) {
    const CcVec mean = ccTimes(per, ccVecAt(patch->normal[s]));
    const double m1 = ccDot64(mean, f.t1), m2 = ccDot64(mean, f.t2);
    const CcVec b1 = ccColumnsTimes(patch->normalBy[s], f.t1),
                b2 = ccColumnsTimes(patch->normalBy[s], f.t2);
    f.turn[s].uu = per * ccDot64(f.t1, b1) - m1 * x1;
    f.turn[s].uv = per * ccDot64(f.t1, b2) - m1 * x2;
    f.turn[s].vu = per * ccDot64(f.t2, b1) - m2 * x1;
    f.turn[s].vv = per * ccDot64(f.t2, b2) - m2 * x2;
    cosine += 0.5 * ccAbs64(ccDot64(mean, n));
  }
  const double scale = 1.0 / ccMax64(cosine, 0.3);
  for (int s = 0; s < 2; ++s) {
    f.turn[s].uu *= scale;
    f.turn[s].uv *= scale;
    f.turn[s].vu *= scale;
    f.turn[s].vv *= scale;
  }
  return f;
}

// The push across the patch's normal that the walls of both bodies share.
CC_FN CcVec ccSharedWall(CcVec pushA, CcVec pushB, CcVec wallA, CcVec wallB) {
  const CcVec none = {0.0, 0.0, 0.0}, all = ccPlus(pushA, pushB);
  CcVec shared = none;
  for (int round = 0; round < 3; ++round) {
    const CcVec n = ccUnit64(ccMinus(all, ccTimes(2.0, shared)));
    const CcVec a = ccMinus(wallA, ccTimes(ccDot64(n, wallA), n)),
                b = ccMinus(wallB, ccTimes(ccDot64(n, wallB), n));
    if (ccDot64(a, b) <= 0.0) return none;
    const double least = CC_SQRT64(ccMin64(ccDot64(a, a), ccDot64(b, b)));
    shared = ccTimes(least, ccUnit64(ccPlus(a, b)));
  }
  return shared;
}

// Whether neither surface of a patch bends by more than the fits' noise, so that a plane tells the
// gap between them everywhere [m]. On an arc that plane is that of the middle alone: a peg whose
// points took their gaps from it jammed in its hole.
CC_FN int ccIsFlat(const CcFlat* f, double voxel) {
  double bends = 0.0;
  for (int s = 0; s < 2; ++s) {
    const CcMatrix2 t = f->turn[s];
    bends += t.uu * t.uu + t.uv * t.uv + t.vu * t.vu + t.vv * t.vv;
  }
  return bends < (CC_FLAT * voxel) * (CC_FLAT * voxel);
}

// Half of curvature times the spread of places, summed over directions. A sample counts by its
// middle alone, which lies on the mean of its surface, so the curvature over its own width (a
// variance of a twelfth of its area each way) is added. Leaning normals shorten distances across
// the patch: by their cosines, exact to second order for a ball on a face.
CC_FN double ccFallOf(CC_GLOBAL const CcSums* patch, const CcFlat* f, double lean, int oneSided,
                      int sampled) {
  const CcMatrix2 a = f->turn[0], b = f->turn[1];
  const double wa = oneSided ? (sampled ? 0.0 : 1.0) : 0.5, wb = oneSided ? 1.0 - wa : 0.5;
  const CcSymmetric2 in = f->inverse;
  const double curved = (wa * a.uu + wb * b.uu) * in.uu +
                        (wa * (a.uv + a.vu) + wb * (b.uv + b.vu)) * in.uv +
                        (wa * a.vv + wb * b.vv) * in.vv;
  const double within = patch->width / patch->area / 12.0 * curved;
  const double per = 1.0 / patch->facing;
  const double bent =
      (patch->opening - ccDot64(ccVecAt(patch->apart), ccVecAt(patch->place)) * per) * per;
  return 0.5 * (bent / ccMax64(lean, 0.5) + within);
}

// How far a body's pushes cancel each other; `push` is their sum. A body without samples in the
// patch, such as a flank that a tooth's tip just touches, is known by the normals that the other's
// samples found there: then `push` takes their direction and the size of `other`.
CC_FN double ccIncoherence(CC_GLOBAL const CcSums* patch, int s, double noise, CcVec other,
                           CcVec* push) {
  const double size = patch->side[s].size;
  if (size != 0.0) return ccMax64(0.0, 1.0 - ccLength64(*push) / ccMax64(size, 1e-300)) + noise;
  const CcVec normal = ccVecAt(patch->normal[s]);
  const double found = ccLength64(normal);
  if (!(found > 0.0)) return 1e3;  // the other decides
  const double sign = s == 0 ? 1.0 : -1.0;
  *push = ccTimes(sign * ccLength64(other) / found, normal);
  return ccMax64(0.0, 1.0 - found / patch->area) + CC_COHERENCE_NOISE;
}

// The force of a patch: under the foundation law the exact gradient of the overlap's energy; under
// the paper's law without the push of walls that run along the other body. `oneSided`: one body is
// a shape, and only samples of `sampled` (0: A's) push. Sets *flat only if `lean` is not 0.
CC_FN CcPatchForce ccForceOf(CC_GLOBAL const CcSums* patch, int foundation, int oneSided,
                             int sampled, CcFlat* flat) {
  CcPatchForce out;
  const CcVec origin = ccVecAt(patch->origin), first = ccVecAt(patch->first);
  out.center = patch->area > 0.0 ? ccPlus(origin, ccTimes(1.0 / patch->area, first)) : origin;
  out.trustA = 0.5;
  out.fall = out.lean = 0.0;
  const CcVec arm = ccMinus(origin, out.center);
  // A's outward normals push B, B's own push it back.
  CcVec pushA = ccVecAt(patch->side[0].push), pushB = ccTimes(-1.0, ccVecAt(patch->side[1].push));
  const CcVec momentA = ccPlus(ccVecAt(patch->side[0].moment), ccCross64(arm, pushA)),
              momentB = ccMinus(ccCross64(arm, pushB), ccVecAt(patch->side[1].moment));
  const double byA = oneSided ? (sampled ? 0.0 : 1.0) : 0.5, byB = oneSided ? 1.0 - byA : 0.5;
  const CcVec force = ccPlus(ccTimes(byA, pushA), ccTimes(byB, pushB));
  out.torque = ccPlus(ccTimes(byA, momentA), ccTimes(byB, momentB));
  out.size = ccLength64(force);
  out.normal = ccUnit64(force);
  if (foundation || !(out.size > 0.0)) return out;

  const CcVec shared = ccSharedWall(pushA, pushB, ccVecAt(patch->side[0].wall),
                                    ccTimes(-1.0, ccVecAt(patch->side[1].wall)));
  pushA = ccMinus(pushA, shared);
  pushB = ccMinus(pushB, shared);
  const double noiseA = oneSided && sampled ? CC_FORMULA_NOISE : CC_COHERENCE_NOISE,
               noiseB = oneSided && !sampled ? CC_FORMULA_NOISE : CC_COHERENCE_NOISE;
  const double a = ccIncoherence(patch, 0, noiseA, pushB, &pushA),
               b = ccIncoherence(patch, 1, noiseB, pushA, &pushB);
  out.trustA = b / (a + b);
  const CcVec n = ccUnit64(ccPlus(ccTimes(out.trustA, pushA), ccTimes(1.0 - out.trustA, pushB)));
  if (!(ccDot64(n, n) > 0.0)) return out;
  const double size = 0.5 * (ccLength64(pushA) + ccLength64(pushB)), per = 1.0 / out.size;
  // Keeps the line of action: through the old center of pressure, with the old spin.
  const CcVec pressure = ccTimes(per, ccCross64(out.normal, out.torque));
  const double spin = ccDot64(out.normal, out.torque) * size * per;
  out.torque = ccPlus(ccCross64(pressure, ccTimes(size, n)), ccTimes(spin, n));
  out.normal = n;
  out.size = size;
  if (!(patch->facing > 0.0)) return out;
  const double perArea = 1.0 / patch->area;
  out.lean = ccLength64(ccVecAt(patch->normal[0])) * perArea *
             (ccLength64(ccVecAt(patch->normal[1])) * perArea);
  *flat = ccFlatten(patch, n);
  out.fall = ccFallOf(patch, flat, out.lean, oneSided, sampled);
  return out;
}

// The spread of the points, C', and how the common normal turns over it [1/m].
typedef struct {
  CcSymmetric2 kept;
  CcMatrix2 lean;
} CcExtent;

// How much of a spread of places along one direction a body rests on [m^2]: all but what it `rolls`
// on, once it is more than that and what `noise` makes of it.
CC_FN double ccRests(double spread, double rolls, double noise) {
  const double rests = spread - rolls, sure = rests - noise - CC_ROUND * spread;
  return ccMin64(ccMax64(ccMin64(rests, CC_ROUND_AGAIN * sure), 0.0), spread);
}

// `lever`: the height of the center that a body turns about [m]; `depth`: the mean.
CC_FN CcExtent ccExtentOf(const CcFlat* f, double lever, double depth, double voxel) {
  const CcMatrix2 a = f->turn[0], b = f->turn[1];
  const CcSymmetric2 c = f->spread;
  // Applies ccRests() to both eigenvalues, middle -+ apart, without eigenvectors.
  const double middle = 0.5 * (c.uu + c.vv), lean = 0.5 * (c.uu - c.vv),
               apart = CC_SQRT64(lean * lean + c.uv * c.uv);
  const double rolls = lever * depth, uneven = lever * CC_UNEVEN * voxel;
  const double low = ccRests(middle - apart, rolls, uneven),
               high = ccRests(middle + apart, rolls, uneven);
  const double mean = 0.5 * (high + low), slope = apart > 0.0 ? 0.5 * (high - low) / apart : 0.0;
  const CcMatrix2 across = {0.5 * (a.uu - b.uu), 0.5 * (a.uv - b.uv), 0.5 * (a.vu - b.vu),
                            0.5 * (a.vv - b.vv)};
  const double noise = CC_LEAN_VOXELS * voxel * CC_LEAN_VOXELS * voxel;
  CcExtent e;
  e.kept.uu = mean + slope * lean;
  e.kept.uv = slope * c.uv;
  e.kept.vv = mean - slope * lean;
  e.lean = ccTimesSymmetric(across, ccInverse(c, noise));
  return e;
}

// A point in the frame body; `weight`: its force relative to a quarter of the patch's.
typedef struct {
  CcVec position, normal;
  double weight;
} CcPatchPoint;

// Four places from the center of pressure, and their weights, as the sums have them. Returns how
// the weights rise in the plane [1/m].
CC_FN CcTwo ccPlacesOf(const CcFlat* f, const CcExtent* e, CcTwo cop, CcTwo* at, double* weight) {
  CcTwo slope = ccOn(f->inverse, cop);
  const CcSymmetric2 root = ccMatrixRoot(e->kept);
  const CcTwo corner[2] = {{root.uu + root.uv, root.uv + root.vv},
                           {root.uv - root.uu, root.vv - root.uv}};
  const double most = ccMax64(ccAbs64(slope.u * corner[0].u + slope.v * corner[0].v),
                              ccAbs64(slope.u * corner[1].u + slope.v * corner[1].v));
  if (-most < CC_LEAST_WEIGHT - 1.0) {
    slope.u *= (1.0 - CC_LEAST_WEIGHT) / most;
    slope.v *= (1.0 - CC_LEAST_WEIGHT) / most;
  }
  const CcTwo aside = ccOn(e->kept, slope);
  for (int i = 0; i < 4; ++i) {
    const double sign = i < 2 ? 1.0 : -1.0;
    const CcTwo from = {sign * corner[i & 1].u, sign * corner[i & 1].v};
    at[i] = ccTwo(from.u - aside.u, from.v - aside.v);
    weight[i] = 1.0 + (slope.u * from.u + slope.v * from.v);
  }
  return slope;
}

// A patch's points on the way: from the center of pressure, which is at `cop` in the plane.
typedef struct {
  CcTwo cop, at[4];
  double weight[4], voxel;
  double pressed;  // ccPressed()
  CcMatrix2 lean;
  CcTwo slope;   // of the weights, as the sums have them [1/m]
  double along;  // their weight at the center of pressure
  int apart;     // near misses: a point's weight is for its gap
} CcPlan;

// Where the points of a patch would stand by its sums. `lever`: from its center to what a body
// turns about [m]; `voxel`: the pair's [m].
CC_FN CcPlan ccPlanOf(CC_GLOBAL const CcSums* patch, const CcPatchForce* force, const CcFlat* f,
                      double lever, double voxel) {
  CcPlan plan;
  plan.pressed = ccPressed(patch->deepest, voxel);
  const CcExtent e = ccExtentOf(f, lever, patch->facing / patch->area, voxel);
  // From the area's center to the center of pressure.
  const CcVec arm = ccTimes(1.0 / force->size, ccCross64(f->n, force->torque));
  plan.cop = ccTwo(ccDot64(f->t1, arm), ccDot64(f->t2, arm));
  plan.voxel = voxel;
  plan.lean = e.lean;
  plan.slope = ccPlacesOf(f, &e, plan.cop, plan.at, plan.weight);
  const CcTwo aside = ccOn(e.kept, plan.slope);
  plan.along = 1.0 + (plan.slope.u * aside.u + plan.slope.v * aside.v);
  plan.apart = 0;
  return plan;
}

// A place of a plan, and the normal there without the patch's spin, in the frame body.
CC_FN CcVec ccPlannedPlace(const CcPlan* plan, const CcPatchForce* force, const CcFlat* f, int i) {
  const CcVec in = ccVec(plan->cop.u + plan->at[i].u, plan->cop.v + plan->at[i].v, 0.0);
  return ccPlus(force->center, ccOutOfPlane(f, in));
}
CC_FN CcVec ccPlannedNormal(const CcPlan* plan, const CcFlat* f, int i) {
  const CcTwo turned = ccTurn2(plan->lean, plan->at[i]);
  return ccUnit64(ccOutOfPlane(f, ccVec(turned.u, turned.v, 1.0)));
}

// Whether a place of a plan moves, unless its mirror image is as near to a hit.
CC_FN int ccMayMove(const CcPlan* plan, const CcNearestHit* found) {
  return plan->pressed > 0.0 && ccIsBeside(found, plan->voxel);
}

// Gives the weights the least change that keeps the center of pressure, as far as no point pulls;
// what is left moves all places.
CC_FN void ccBalance(CcPlan* plan) {
  CcTwo *at = plan->at, middle = {0.0, 0.0}, off = {0.0, 0.0}, rest = {0.0, 0.0};
  CcSymmetric2 spread = {0.0, 0.0, 0.0};
  double* weight = plan->weight;
  for (int i = 0; i < 4; ++i) {
    middle = ccTwo(middle.u + 0.25 * at[i].u, middle.v + 0.25 * at[i].v);
    off = ccTwo(off.u - weight[i] * at[i].u, off.v - weight[i] * at[i].v);
  }
  for (int i = 0; i < 4; ++i) {
    const double u = at[i].u - middle.u, v = at[i].v - middle.v;
    spread.uu += u * u;
    spread.uv += u * v;
    spread.vv += v * v;
  }
  const double noise = CC_WET_NOISE * plan->voxel;
  const CcTwo tilt = ccOn(ccInverse(spread, noise * noise), off);
  double more[4], part = 1.0;
  for (int i = 0; i < 4; ++i) {
    more[i] = tilt.u * (at[i].u - middle.u) + tilt.v * (at[i].v - middle.v);
    // A weight may be below the least by rounding, and stay as it is.
    if (more[i] < 0.0 && weight[i] + more[i] < CC_LEAST_WEIGHT)
      part = ccMin64(part, ccMax64(0.0, weight[i] - CC_LEAST_WEIGHT) / -more[i]);
  }
  for (int i = 0; i < 4; ++i) {
    weight[i] += part * more[i];
    rest = ccTwo(rest.u + 0.25 * weight[i] * at[i].u, rest.v + 0.25 * weight[i] * at[i].v);
  }
  for (int i = 0; i < 4; ++i) at[i] = ccTwo(at[i].u - rest.u, at[i].v - rest.v);
}

// Moves the places of a plan that are dry to the hits nearest to them. Returns whether any moved.
CC_FN int ccMoveToWet(CcPlan* plan, const CcFlat* f, CC_GLOBAL const CcNearestHit* found) {
  int moved = 0;
  for (int i = 0; i < 4; ++i) {
    const CcNearestHit hit = found[i];
    const CcVec way = ccTimes(plan->pressed, ccWayToWet(&hit, plan->voxel)), n = hit.normal;
    if (ccDot64(way, way) == 0.0) continue;
    // Along its normal a place is free, so the way counts by where it meets the plane.
    const double back = ccDot64(way, f->n) / ccDot64(n, f->n);
    plan->at[i] = ccTwo(plan->at[i].u + (ccDot64(way, f->t1) - back * ccDot64(n, f->t1)),
                        plan->at[i].v + (ccDot64(way, f->t2) - back * ccDot64(n, f->t2)));
    moved = 1;
  }
  if (moved) ccBalance(plan);
  return moved;
}

// The weight of a plan's point. That of a near miss is for its gap, which is that of the surfaces
// where it stands. Balanced weights would give points of a face whose gap is even different gaps,
// and the one that touches first would turn the body.
CC_FN double ccWeightOf(const CcPlan* plan, int i) {
  if (!plan->apart) return plan->weight[i];
  const CcTwo at = plan->at[i];
  return ccMax64(CC_LEAST_WEIGHT, plan->along + (plan->slope.u * at.u + plan->slope.v * at.v));
}

// Makes a plan's places the patch's points in the frame body, which together have its force and
// torque. `found`: what is nearest to each place.
CC_FN void ccPointsOf(const CcPatchForce* force, const CcFlat* f, const CcPlan* plan,
                      CC_GLOBAL const CcNearestHit* found, CcPatchPoint* points) {
  const double noise = CC_SPIN_NOISE * plan->voxel * plan->voxel;
  const CcTwo* at = plan->at;
  CcTwo turned[4];
  double spin = ccDot64(f->n, force->torque) * (1.0 / force->size), polar = 0.0, most = 0.0;
  for (int i = 0; i < 4; ++i) {
    turned[i] = ccTurn2(plan->lean, at[i]);
    spin -= 0.25 * plan->weight[i] * (at[i].u * turned[i].v - at[i].v * turned[i].u);
    polar += 0.25 * plan->weight[i] * (at[i].u * at[i].u + at[i].v * at[i].v);
  }
  const double limit = CC_MOST_SPIN / CC_SQRT64(ccMax64(polar, 1e-300));
  const double omega = polar > 0.0 ? ccClamp64(spin / (polar + noise), -limit, limit) : 0.0;
  for (int i = 0; i < 4; ++i) {
    turned[i] = ccTwo(turned[i].u - omega * at[i].v, turned[i].v + omega * at[i].u);
    most = ccMax64(most, turned[i].u * turned[i].u + turned[i].v * turned[i].v);
  }
  const double less = most > CC_MOST_LEAN * CC_MOST_LEAN ? CC_MOST_LEAN / CC_SQRT64(most) : 1.0;
  for (int i = 0; i < 4; ++i) {
    const double u = less * turned[i].u, v = less * turned[i].v;
    const double shorter = 1.0 / CC_SQRT64(1.0 + (u * u + v * v));
    const CcVec normal = ccTimes(shorter, ccOutOfPlane(f, ccVec(u, v, 1.0)));
    const CcVec place = ccPlannedPlace(plan, force, f, i);
    points[i].normal = normal;
    const CcNearestHit hit = found[i];
    points[i].position = ccPlus(place, ccTimes(ccRiseToWet(&hit, place, normal), normal));
    // Along the patch's normal the weights add up to 1; across it the lean of one takes back the
    // others', since all are linear in the places.
    points[i].weight = ccWeightOf(plan, i) / shorter;
  }
}

#endif
