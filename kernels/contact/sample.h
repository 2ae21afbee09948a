// One sample's part of a contact: a small piece of area at a mean depth d in the other body, tilted
// against the other's surface (docs/force.md, "Clipped depth"). Plain C for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_SAMPLE_H
#define CLOUDCONTACT_KERNELS_SAMPLE_H

#include "kernels/contact/look_up.h"

#define CC_LEAST_SPREAD 1e-30f  // [m] avoids a division by zero in a branch that is not taken

// Means over the piece of the depth's powers, with the depth clipped at zero.
typedef struct {
  float share;   // of the piece that is wet, 0..1
  float middle;  // mean depth of that share
  float depth1;  // mean of max(d, 0)
  float depth2;  // of its square
  float depth3;  // of its cube
} CcWet;

// `depth`: at the piece's centroid. `spread`: half the range of the depth over the piece, which is
// taken to be evenly distributed: half the piece's width times the sine between the two surfaces.
// Without it the rim of a contact consists of whole samples: crossed edges turn by 6.3 deg at a
// depth of 0.5 instead of 2.2, and the force of a shallow cap is 3 % high.
CC_FN CcWet ccWet(float depth, float spread) {
  // The depth is evenly spread from `low` to `high`. Only selections, no branches, so that loops
  // over samples vectorize.
  CcWet wet;
  const float low = ccMax(depth - spread, 0.0f), high = ccMax(depth + spread, 0.0f);
  const float part = high / (2.0f * ccMax(spread, CC_LEAST_SPREAD));
  wet.share = depth >= spread ? 1.0f : part;
  const float range = 0.5f * (high - low);
  wet.middle = 0.5f * (low + high);
  wet.depth1 = wet.share * wet.middle;
  wet.depth2 = wet.share * (wet.middle * wet.middle + range * range * (1.0f / 3.0f));
  wet.depth3 = wet.depth1 * (wet.middle * wet.middle + range * range);
  return wet;
}

// A sample that lies in the other body, seen in the pair's frame.
typedef struct {
  float position[3];  // midway between the two surfaces
  float own[3];       // outward normal of the body that the sample belongs to
  float other[3];     // of the body that it lies in
  float facing;       // cosine between own and -other
  CcWet wet;
} CcHit;

// `at`: the sample; `spread`: half its width; lengths in meters, all in the pair's frame. The hit
// lies on the sample's own normal, which keeps its moment.
CC_FN CcHit ccHitOf(const float* at, const float* own, const float* other, float depth,
                    float spread) {
  CcHit hit;
  hit.facing = -ccDot(own, other);
  hit.wet = ccWet(depth, spread * CC_SQRT(ccMax(1.0f - hit.facing * hit.facing, 0.0f)));
  const float back = 0.5f * hit.wet.middle;
  hit.own[0] = own[0];
  hit.own[1] = own[1];
  hit.own[2] = own[2];
  hit.other[0] = other[0];
  hit.other[1] = other[1];
  hit.other[2] = other[2];
  hit.position[0] = at[0] - back * own[0];
  hit.position[1] = at[1] - back * own[1];
  hit.position[2] = at[2] - back * own[2];
  return hit;
}

#endif
