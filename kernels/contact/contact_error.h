// The error of a pair's depth, from the sums that gave it: what the truth stays below in 95 % of
// poses (docs/measurements.md, "Error of a depth"). Plain C for C++ and OpenCL C.
//
// Faces are known best. Where the depth comes from few hits on curved surfaces, it is as uncertain
// as their mean. Sharp places, whose normals spread, are worse in four ways: samples of a coarse
// level miss the tip between them, a sample lies deeper than the depth found, the tips of both
// bodies cross (both are incoherent), and the two bodies' samples disagree.
#ifndef CLOUDCONTACT_KERNELS_CONTACT_ERROR_H
#define CLOUDCONTACT_KERNELS_CONTACT_ERROR_H

#include "kernels/contact/contact_depth.h"

// Measured on the bodies of tests/contact/contact_cases.h and of the laboratory [voxels].
#define CC_ERROR_LEAST 0.003   // of a flat face
#define CC_ERROR_FACE 0.012    // per depth
#define CC_ERROR_NOISE 0.35    // of one hit on a curved surface
#define CC_ERROR_SHARP 0.08    // per depth, of an edge or a corner
#define CC_ERROR_SPARSE 0.45   // of a tip with samples twice as far apart; 3 times that: four times
#define CC_ERROR_CROSSED 1.25  // per depth, of two tips
#define CC_ERROR_HIDDEN 1.2    // per length by which a sample is deeper

// [m] `edged`: the part of the depth that edges gave which were looked up themselves, 0..1.
CC_FN double ccDepthError(const CcPairSums* s, const CcPairDepth* found, double edged, int level,
                          int oneSided, double voxel) {
  if (!(s->size > 0.0) || !(s->volume > 0.0)) return 0.0;
  const double depth = found->depth / voxel;
  const double curved = ccRamp(found->pointed, 0.05, CC_CURVED);
  const double sharp = (1.0 - found->smooth) * (1.0 - edged);
  const double lean = sharp * (1.0 - ccClamp64(s->lean / s->volume, 0.0, 1.0));
  const double both = 1.0 - ccAbs64(2.0 * s->trust / s->size - 1.0);
  const double hidden = ccMax64(0.0, s->most / voxel - depth);
  const double apart =
      oneSided ? 0.0
               : ccAbs64(ccDeepestByMoments(s->momentsA) - ccDeepestByMoments(s->momentsB)) / voxel;
  const double error =
      CC_ERROR_LEAST + (CC_ERROR_FACE + CC_ERROR_SHARP * sharp * curved) * depth +
      CC_ERROR_NOISE * curved / CC_SQRT64(ccMax64(1.0, (double)s->hits)) +
      lean * (CC_ERROR_SPARSE * (double)((1 << level) - 1) + CC_ERROR_CROSSED * both * depth) +
      CC_ERROR_HIDDEN * sharp * ccMin64(1.0, 4.0 * lean) * hidden + apart;
  return error * voxel;
}

#endif
