// The part of a sample that is in the other body, where the rest is outside of it (docs/force.md,
// "Clipped depth"). Plain C for C++ and OpenCL C.
//
// The depth is taken to be linear over a sample, by the other's plane at its middle. If that plane
// leans against the sample, the part that is in is deep and may lie where the other body has another
// surface: beyond a blunt edge, a face that touches by 0.03 voxel read 0.2 voxel deep there. So such
// a part is asked for once more, in its own middle, and counts as far as it is in the body there.
#ifndef CLOUDCONTACT_KERNELS_WET_PART_H
#define CLOUDCONTACT_KERNELS_WET_PART_H

#include "kernels/contact/search.h"

// [voxels of the sample] A part that is less deep in the mean is not asked for.
#define CC_LEAST_PART 0.05f

typedef struct {
  float at[3];  // its middle, in the samples' grid
  float depth;  // [m] its mean depth by the plane at the sample's middle
} CcWetPart;

// The part of a sample at `x` [own voxels] with `normal`, where the other body has `depth` [m] and
// `other` as its normal in its own frame. Returns whether it must be asked for.
CC_FN int ccWetPartOf(CC_NEAR const CcLimits* limits, CC_NEAR const float* turnToOther,
                      const float* x, const float* normal, float width, const float* other,
                      float depth, CcWetPart* part) {
  float m[3];
  ccTurnBack(turnToOther, other, m);
  const float along = ccDot(normal, m), square = ccMax(1.0f - along * along, 0.0f),
              sine = CC_SQRT(square), spread = limits->halfWidth * width * sine;
  const CcWet wet = ccWet(depth, spread);
  part->depth = wet.middle;
  if (!(wet.middle * limits->perVoxel > CC_LEAST_PART) || wet.share >= 1.0f) return 0;
  // Down the slope of the depth, in the sample's plane.
  const float by = (wet.middle - depth) * limits->perVoxel / square;
  for (int i = 0; i < 3; ++i) part->at[i] = x[i] + by * (along * normal[i] - m[i]);
  return 1;
}

// How far it counts, 0..1. `depth` [m]: what the other body has there.
CC_FN float ccPartCounts(const CcWetPart* part, float depth) {
  return ccMin(ccMax(depth / part->depth, 0.0f), 1.0f);
}

// The same where the other's record has no planes.
CC_FN float ccPartCountsBelow(CcVoxel record) {
  return record.b == CC_DEEP_INSIDE ? 1.0f : 0.0f;
}

#endif
