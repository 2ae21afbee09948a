// The part of a sample that is in the other body, where the rest is outside of it (docs/force.md,
// "Clipped depth"). Plain C for C++ and OpenCL C.
//
// The depth is taken to be linear over a sample, by the other's plane at its middle. If that plane
// leans against the sample, the part that is in is deep, and may lie where the other body has
// another surface: beyond the blunt corners of its bore, the face of a nut that touches by 0.03
// voxel read 0.2 voxel deep, and the pair's depth was 0.074. So the deep end of such a sample is
// looked up, too, and no part of it is deeper than that.
#ifndef CLOUDCONTACT_KERNELS_WET_PART_H
#define CLOUDCONTACT_KERNELS_WET_PART_H

#include "kernels/contact/search.h"

// [voxels of the sample] An end that is less deep is not looked up, and one that is deeper than the
// second is believed. From 0.1 on, a nut comes down its bolt 8 % slower: it is held back where
// crests lean against flanks.
#define CC_LEAST_END 0.25f
#define CC_SURE_END 0.45f
// Where the other body has less than the first of the depth by the plane at the middle, the plane
// is not its surface: the sample does not face it, so that no point of contact stands there. From
// the second on it does. On threads, points stood up to 1.8 voxels beside a surface.
#define CC_NOT_THERE 0.1f
#define CC_THERE 0.3f

typedef struct {
  float at[3];  // in the samples' grid
  float depth;  // [m] by the plane at the sample's middle
} CcWetEnd;

// The deep end of a sample at `x` [own voxels] with `normal`, where the other body has `depth` [m]
// and `other` as its normal in its own frame. Returns whether it must be looked up.
CC_FN int ccWetEndOf(CC_NEAR const CcLimits* limits, CC_NEAR const float* turnToOther,
                     const float* x, const float* normal, float width, const float* other,
                     float depth, CcWetEnd* end) {
  float m[3];
  ccTurnBack(turnToOther, other, m);
  const float along = ccDot(normal, m), square = ccMax(1.0f - along * along, 0.0f),
              sine = CC_SQRT(square);
  end->depth = depth + limits->halfWidth * width * sine;
  if (!(end->depth * limits->perVoxel > CC_LEAST_END)) return 0;
  // Down the slope of the depth, in the sample's plane.
  const float by = CC_HALF_WIDTH * width / ccMax(sine, CC_LEAST_SPREAD);
  for (int i = 0; i < 3; ++i) end->at[i] = x[i] + by * (along * normal[i] - m[i]);
  return 1;
}

// The depth [m] of an end in a record without planes.
CC_FN float ccEndBelow(const CcWetEnd* end, CcVoxel record) {
  return record.b == CC_DEEP_INSIDE ? end->depth : 0.0f;
}

// Limits the parts of a sample that is not all wet to the depth [m] that the other body has at its
// end: of depths that are evenly spread from 0 on. And how far it faces the other body. Returns by
// how much the hit moves along its own normal, as it lies midway between the surfaces.
CC_FN float ccLimitWet(const CcWetEnd* end, float perVoxel, float depth, float share, float* facing,
                       float* depth1, float* depth2, float* depth3) {
  if (!(depth < end->depth)) return 0.0f;
  const float believed =
      ccMin((end->depth * perVoxel - CC_LEAST_END) / (CC_SURE_END - CC_LEAST_END), 1.0f);
  const float most = ccMax(end->depth + believed * (depth - end->depth), 0.0f),
              below = most / end->depth, square = most * most,
              middle = most * (1.0f - 0.5f * below);
  const float there =
      ccMin(ccMax((depth / end->depth - CC_NOT_THERE) / (CC_THERE - CC_NOT_THERE), 0.0f), 1.0f);
  *facing *= 1.0f + believed * (there - 1.0f);
  *depth1 = share * middle;
  *depth2 = share * square * (1.0f - below * (2.0f / 3.0f));
  *depth3 = share * square * most * (1.0f - 0.75f * below);
  return 0.5f * (0.5f * end->depth - middle);
}

#endif
