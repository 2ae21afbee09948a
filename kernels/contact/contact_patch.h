// The last step of a query: the patches share the pair's law and become contacts (docs/force.md,
// "Shares of the patches"). Plain C for C++ and OpenCL C; a test checks the offsets.
//
// The paper's law (3) is one spring for the pair, FR = k d (contact_depth.h has d). The patches
// share the spring by area, and the force by their sums. A point's force is then its part of k
// times a depth, and that depth is no overlap: where the pressure has a slope, or patches oppose
// each other, it is up to three times d. So a point states a depth that is one, at most a little
// above d, and the stiffness that gives the same force there. The part of k is its slope.
#ifndef CLOUDCONTACT_KERNELS_CONTACT_PATCH_H
#define CLOUDCONTACT_KERNELS_CONTACT_PATCH_H

#include "kernels/contact/contact_error.h"
#include "kernels/contact/patch_tangent.h"

#define CC_LEAST_SHARE 0.003  // of the pair's force; lighter patches are dropped
// No patch is deeper than this many times the pair's depth, such as a wall with a sliver of area.
#define CC_MOST_DEPTH 1.5

// The terms that turn a pair's patches into a contact.
typedef struct {
  CcPlacement frame, toA;  // of the frame body in the world and in A's frame
  double pivots[2][3];     // what A and B turn about, in the frame body [m]
  double eases[2];         // how easily each turns, relative to the other
  double voxel;            // the larger of the bodies' [m]
  double stiffness, damping;
  double gap;      // by which the search moved the bodies together [m]
  int foundation;  // law: 0 one spring a pair, 1 stiffness per area
  int oneSided;    // one body is a shape
  int sampled;     // then the body with samples: 0 A, 1 B
  int unused;
} CcTerms;

// A point's depth exceeds the pair's by at most this, of the depth or in voxels.
#define CC_DEEPER 0.05
#define CC_DEEPER_VOXELS 0.05

// Sums over a pair's patches, its depth, that depth's error, and how pointed it is.
typedef struct {
  double force, area, shares, depth, error;
  double pointed;  // b of the pair's area, 0 where each patch has its own spring
} CcWhole;

typedef struct {
  double position[3], normal[3];  // world
  double depth, stiffness;        // [m], [N/m]
} CcContactPoint;

// Why a patch is not trusted, in the order of Doubt (contact.h).
#define CC_NO_DOUBT 0
#define CC_FEW_SAMPLES 1
#define CC_OPPOSED 2
#define CC_DEEP_PATCH 3

// A patch of a contact with its points, each of which has a quarter of the patch's slope and
// damping.
typedef struct {
  double position[3], normal[3];  // world
  double depth, stiffness, slope, damping, area, confidence;
  double center[3], seen[3];  // center of the area and normal, in A's frame
  CcContactPoint points[4];
  CcPatchTangent tangent;
  int doubt;
  float error;    // of the pair's depth [m]
  float pointed;  // CcWhole::pointed
} CcContactPatch;

// The pair's patches as a whole, but for the sum of their shares. `size`: of the patches' forces.
CC_FN CcWhole ccWholeOf(const CcPairSums* sums, double size, double depth, double error,
                        CC_GLOBAL const CcTerms* terms) {
  CcWhole w = {size, sums->area, 0.0, terms->foundation ? 0.0 : depth, error, 0.0};
  w.pointed = ccClamp64(ccPointedness(sums, w.depth), 0.0, CC_MOST_POINTED);
  return w;
}

// The height over a patch of the centers that the bodies turn about [m]: their mean, as each turns
// more easily. A hook has its own on the other side of the ring that it hangs in, and rolls there
// as a ball does.
CC_FN double ccLeverOf(CC_GLOBAL const CcTerms* terms, const CcPatchForce* force) {
  double sum = 0.0, eases = 0.0;
  for (int s = 0; s < 2; ++s) {
    const CcVec arm = ccMinus(force->center, ccVecAt(terms->pivots[s]));
    sum += terms->eases[s] * ccAbs64(ccDot64(force->normal, arm));
    eases += terms->eases[s];
  }
  return eases > 0.0 ? sum / eases : 0.0;
}

// Whether a patch counts. `all`: sum of the patches' forces. The foundation law is the gradient of
// an energy and drops no force.
CC_FN int ccCounts(CC_GLOBAL const CcSums* patch, double size, double all, double voxel,
                   int foundation) {
  const double least = foundation ? 0.0 : CC_LEAST_SHARE;
  return size > least * all && patch->area > 0.0 && patch->deepest > -CC_RIM * voxel;
}

// A patch's share of the pair's spring: by area, or by force if the area is too small for it.
CC_FN double ccShareOf(double area, double size, const CcWhole* whole) {
  return ccMax64(area / whole->area, size / (CC_MOST_DEPTH * whole->force));
}

CC_FN void ccPut64(CC_GLOBAL double* to, CcVec v) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

CC_FN void ccShareLaw(CC_GLOBAL const CcSums* patch, double size, CC_GLOBAL const CcTerms* terms,
                      const CcWhole* whole, double* area, double* share, double* depth) {
  *area = patch->area * (terms->oneSided ? 1.0 : 0.5);
  if (terms->foundation) {
    // The patch's own depth is its force over its area.
    const double deepest = ccMax64(0.0, patch->deepest) + CC_RIM * terms->voxel;
    *area = ccMax64(*area, size / deepest);
    *share = *area;
    *depth = size / *area;
    return;
  }
  *share = ccShareOf(patch->area, size, whole) / whole->shares;
  *depth = whole->depth * (size / whole->force) / *share;
}

CC_FN int ccDoubtOf(CC_GLOBAL const CcSums* patch, double pushes, double confidence) {
  if (patch->deep > 0.5 * pushes) return CC_DEEP_PATCH;
  if (confidence < 0.3) return CC_OPPOSED;
  return patch->hits < 4 ? CC_FEW_SAMPLES : CC_NO_DOUBT;
}

// A contact but for its depths, which ccLevelDepths() shares out: of the points it has weights, and
// of the patch the depth that its part of k gives. `flat`: the patch in the plane across
// force->normal; `plan`, `found`: of its points.
CC_FN void ccContactOf(CC_GLOBAL const CcSums* patch, const CcPatchForce* force, const CcFlat* flat,
                       const CcPlan* plan, CC_GLOBAL const CcNearestHit* found,
                       CC_GLOBAL const CcTerms* terms, const CcWhole* whole,
                       CC_GLOBAL CcContactPatch* out) {
  double area, share, depth;
  ccShareLaw(patch, force->size, terms, whole, &area, &share, &depth);
  CcPatchPoint points[4];
  ccPointsOf(force, flat, plan, found, points);
  const CcVec arm = ccTimes(1.0 / force->size, ccCross64(force->normal, force->torque));
  const double a = patch->side[0].size, b = patch->side[1].size;
  const double pushes = terms->oneSided ? ccMax64(a, b) : 0.5 * (a + b);
  const double confidence = ccMin64(1.0, force->size / ccMax64(pushes, 1e-300));
  ccPut64(out->position, ccPlaced(&terms->frame, ccPlus(force->center, arm)));
  ccPut64(out->normal, ccTurned(&terms->frame, force->normal));
  out->depth = depth;
  out->stiffness = out->slope = terms->stiffness * share;
  out->damping = terms->damping * share;
  out->area = area;
  out->confidence = confidence;
  ccPut64(out->center, ccPlaced(&terms->toA, force->center));
  ccPut64(out->seen, ccTurned(&terms->toA, force->normal));
  for (int i = 0; i < 4; ++i) {
    ccPut64(out->points[i].position, ccPlaced(&terms->frame, points[i].position));
    ccPut64(out->points[i].normal, ccTurned(&terms->frame, points[i].normal));
    out->points[i].depth = points[i].weight;
  }
  out->tangent = ccTangentOf(patch, force, flat, plan, terms->gap > 0.0 ? 0.0 : depth,
                             ccTurned(&terms->frame, flat->t1));
  out->doubt = ccDoubtOf(patch, pushes, confidence);
  out->error = (float)whole->error;
  out->pointed = (float)whole->pointed;
}

// The most depth of a point, over the pair's.
CC_FN double ccMostRatio(CC_GLOBAL const CcTerms* terms, const CcWhole* whole) {
  return 1.0 + ccMax64(CC_DEEPER, CC_DEEPER_VOXELS * terms->voxel / whole->depth);
}

// The sum of the points' forces over the patch's: above 1 where they lean against each other. With
// one normal's lean of 13 deg the depths can still be kept and the stiffnesses still add up.
CC_FN double ccLeaning(CC_GLOBAL const CcContactPatch* contact, double most) {
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) sum += 0.25 * contact->points[i].depth;
  return ccMin64(sum, 0.5 + 0.5 * most);
}

// How far the pair's points must share k by their forces and no longer by area, 0..1, so that those
// of this patch are not too deep. 0 under the foundation law, and for bodies apart.
CC_FN double ccLevelling(CC_GLOBAL const CcContactPatch* contact, CC_GLOBAL const CcTerms* terms,
                         const CcWhole* whole) {
  if (terms->foundation || terms->gap > 0.0 || !(whole->depth > 0.0)) return 0.0;
  const double most = ccMostRatio(terms, whole), leaning = ccLeaning(contact, most);
  double level = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double ratio = contact->depth / whole->depth * contact->points[i].depth;
    if (ratio > most) level = ccMax64(level, (ratio / most - 1.0) / (ratio / leaning - 1.0));
  }
  return level;
}

// Shares the depths out: forces stay, stiffness follows.
CC_FN void ccLevelDepths(CC_GLOBAL CcContactPatch* contact, CC_GLOBAL const CcTerms* terms,
                         const CcWhole* whole, double level) {
  double ratio = 1.0, leaning = 1.0;
  if (level > 0.0) {
    ratio = contact->depth / whole->depth;
    leaning = ccLeaning(contact, ccMostRatio(terms, whole));
  }
  for (int i = 0; i < 4; ++i) {
    CC_GLOBAL CcContactPoint* point = &contact->points[i];
    const double harder = 1.0 + level * (ratio * point->depth / leaning - 1.0);
    point->stiffness = 0.25 * contact->slope * harder;
    point->depth = contact->depth * point->depth / harder - terms->gap;
  }
  const double harder = 1.0 + level * (ratio - 1.0);
  contact->stiffness = contact->slope * harder;
  contact->depth = contact->depth / harder - terms->gap;
}

#endif
