// The depth of the deepest point of a contact, from sums over its area (docs/force.md, "Depth of
// the pair"). Plain C for C++ and OpenCL C.
//
// By moments: ccDeepestByMoments(). They include the rim, which few samples resolve poorly: two
// spheres of 16 voxels pressed by 0.3 read up to 7 % too deep.
//
// By curvature: where both surfaces are smooth, the depth falls from the deepest point as t(x) = d
// - x K x / 2, so every sample gives d = t + x K x / 2. K is the rate at which the normals turn
// over the patch. The same spheres are 1.1 % off. A patch is smooth if its b by moments agrees with
// the b that the mean of x K x / 2 implies.
#ifndef CLOUDCONTACT_KERNELS_CONTACT_DEPTH_H
#define CLOUDCONTACT_KERNELS_CONTACT_DEPTH_H

#include "kernels/contact/patch_force.h"

#define CC_MOST_POINTED 2.0  // b of a corner; noise would give more
// The pair's depth exceeds that of the deepest sample by at most this [voxels].
#define CC_RIM 0.1
// Surfaces are smooth if the two values of b differ by less than b's noise, one over the root of
// the number of hits, and sharp from this many times that on. They are also sharp if their normals
// spread widely, as at a corner, where both values may agree by chance. The mean cosine of a ball
// of 10 voxels pressed in by one is 0.97.
#define CC_SHARP 1.6
#define CC_LEANS 0.93
#define CC_LEANS_FAR 0.87
// They are curved if b is more than noise; on a face it is 0.02.
#define CC_EVEN 0.1
#define CC_CURVED 0.3

// `moments`: M_k = sum of area times depth^k, k = 1..3. If the part of the area deeper than t
// falls like (1 - t/d)^b (b = 0 a face, 1/2 a cylinder's side, 1 a sphere or an edge, 2 a corner),
// then M2/M1 = 2 d / (2 + b) and M3/M2 = 3 d / (3 + b), which two ratios give b and d.
CC_FN double ccDeepestByMoments(const double* moments) {
  if (!(moments[0] > 0.0) || !(moments[1] > 0.0)) return 0.0;
  const double ratio = moments[2] * moments[0] / (moments[1] * moments[1]);
  const double b = ratio >= 1.4
                       ? CC_MOST_POINTED
                       : ccClamp64(3.0 * (ratio - 1.0) / (1.5 - ratio), 0.0, CC_MOST_POINTED);
  return (1.0 + 0.5 * b) * moments[1] / moments[0];
}

// 0 up to `none`, 1 from `all` on, linear between.
CC_FN double ccRamp(double x, double none, double all) {
  return ccClamp64((x - none) / (all - none), 0.0, 1.0);
}

// Sums over a pair's patches.
typedef struct {
  double momentsA[3], momentsB[3];
  double area, volume;          // [m^2, m^3]
  double square, middle, fall;  // times the volume [m^4]
  double lean, trust, size;     // [m^3]
  double most;                  // at a sample itself [m]
  int hits;
} CcPairSums;

CC_FN CcPairSums ccNoPatches(void) {
  CcPairSums sums;
  for (int k = 0; k < 3; ++k) sums.momentsA[k] = sums.momentsB[k] = 0.0;
  sums.area = sums.volume = sums.square = sums.middle = sums.fall = 0.0;
  sums.lean = sums.trust = sums.size = 0.0;
  sums.most = -1e300;
  sums.hits = 0;
  return sums;
}

CC_FN void ccAddPatch(CcPairSums* sums, CC_GLOBAL const CcSums* patch, double size, double trustA,
                      double fall, double lean, int oneSided) {
  for (int k = 0; k < 3; ++k) {
    sums->momentsA[k] += patch->side[0].depth[k];
    sums->momentsB[k] += patch->side[1].depth[k];
  }
  sums->hits += patch->hits;
  sums->area += patch->area;
  sums->volume += patch->facing;
  sums->square += (oneSided ? 0.5 : 1.0) * (patch->side[0].depth[1] + patch->side[1].depth[1]);
  sums->middle += patch->middle;
  sums->fall += patch->facing * fall;
  sums->lean += patch->facing * lean;
  sums->trust += size * trustA;
  sums->size += size;
  sums->most = ccMax64(sums->most, patch->deepest);
}

// The depth is measured at the surface of the more coherent body, by the other body's samples.
CC_FN double ccPairByMoments(const CcPairSums* s, int oneSided) {
  const double byA = ccDeepestByMoments(s->momentsA), byB = ccDeepestByMoments(s->momentsB);
  if (oneSided || byA == 0.0 || byB == 0.0) return ccMax64(byA, byB);
  return (s->trust * byB + (s->size - s->trust) * byA) / s->size;
}

// The pair's b at a given depth.
CC_FN double ccPointedness(const CcPairSums* s, double depth) {
  return s->volume > 0.0 ? depth * s->area / s->volume - 1.0 : 0.0;
}

// The weight of the depth by curvature, 0..1.
CC_FN double ccSmooth(const CcPairSums* s, double depth) {
  if (!(s->square > 0.0)) return 0.0;
  const double bulge = 2.0 * s->fall / s->square;
  const double off = ccAbs64(ccPointedness(s, depth) - bulge) * CC_SQRT64((double)s->hits);
  return ccRamp(off, CC_SHARP, 1.0) * ccRamp(s->lean / s->volume, CC_LEANS_FAR, CC_LEANS) *
         ccRamp(bulge, CC_EVEN, CC_CURVED);
}

typedef struct {
  double depth;    // of all patches together [m]
  double pointed;  // b by moments
  double smooth;   // weight of the depth by curvature
} CcPairDepth;

// `voxel` [m] the pair's.
CC_FN CcPairDepth ccDepthOfPair(const CcPairSums* s, int oneSided, double voxel) {
  CcPairDepth d = {0.0, 0.0, 0.0};
  if (!(s->size > 0.0)) return d;
  const double rough = ccPairByMoments(s, oneSided);
  d.smooth = ccSmooth(s, rough);
  d.pointed = ccPointedness(s, rough);
  d.depth = rough;
  if (d.smooth > 0.0) d.depth += d.smooth * ((s->middle + s->fall) / s->volume - rough);
  // Limits a rim of samples that hardly touch, which would read as deep as a face.
  d.depth = ccMax64(0.0, ccMin64(d.depth, s->most + CC_RIM * voxel));
  return d;
}

#endif
