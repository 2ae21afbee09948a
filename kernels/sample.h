// What one sample of a surface adds to a contact: a small piece of area that lies at a mean depth d
// in the other body and leans against its surface. Plain C for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_SAMPLE_H
#define CLOUDCONTACT_KERNELS_SAMPLE_H

#include "surface_fit.h"

// Means over the piece of the depth's powers, each with the depth cut off at zero.
typedef struct {
  float share;   // of the piece that is wet, 0..1
  float depth1;  // mean of max(d, 0)
  float depth2;  // of its square
  float depth3;  // of its cube
} CcWet;

// `depth` at the piece's centroid; `spread` the half-range of the depth over the piece, which is
// taken to be evenly distributed: half the piece's width times the sine between the two surfaces.
// Without it the rim of every contact is counted by whole samples: crossed edges turn by 6.3 deg at
// depth 0.5 instead of 2.2 (FORCE.md), and the force of a shallow cap is 3 % high.
CC_FN CcWet ccWet(float depth, float spread) {
  CcWet wet;
  if (depth >= spread) {
    wet.share = 1.0f;
    wet.depth1 = depth;
    wet.depth2 = depth * depth + spread * spread * (1.0f / 3.0f);
    wet.depth3 = depth * (depth * depth + spread * spread);
    return wet;
  }
  const float in = ccMax(depth + spread, 0.0f);
  if (in <= 0.0f) {
    wet.share = wet.depth1 = wet.depth2 = wet.depth3 = 0.0f;
    return wet;
  }
  wet.share = in / (2.0f * spread);
  wet.depth1 = in * wet.share * 0.5f;
  wet.depth2 = in * in * wet.share * (1.0f / 3.0f);
  wet.depth3 = in * in * in * wet.share * 0.25f;
  return wet;
}

#endif
