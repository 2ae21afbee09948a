// The digital normal of a collision area, (5'): the sum over its collision voxels of share,
// hardness, ability and base vector. Plain C for C++ and OpenCL C; a test checks the offsets.
//
// A team of CC_NORMAL_LANES shares an area: each lane adds every so many-th voxel in order, and the
// lanes are added in order. So the bits do not depend on what runs it.
#ifndef CLOUDCONTACT_KERNELS_DIGITAL_NORMAL_H
#define CLOUDCONTACT_KERNELS_DIGITAL_NORMAL_H

#include "kernels/digitize/window_sums.h"

#define CC_NORMAL_LANES 64

// A collision voxel: its share inside D times its coverage, and the tool's cutting ability there.
typedef struct {
  ushort x, y, z, unused;
  float share, ability;
} CcTouchedVoxel;

typedef struct {
  double count;      // n: sum of the shares
  double vector[3];  // sum of share, hardness, ability and f_j [voxels]
} CcNormalSum;

CC_FN CcNormalSum ccNoVectors(void) {
  const CcNormalSum none = {0.0, {0.0, 0.0, 0.0}};
  return none;
}

// Adds a voxel's share of f_j = Gr - Gc (4). `gr`: the representative point [voxels]; `hardness`: h
// of the voxel's tissue.
CC_FN void ccAddVector(CcNormalSum* sum, CcMoments moments, CC_GLOBAL const double* gr,
                       CcTouchedVoxel voxel, double hardness) {
  if (!(moments.mass > 0.0)) return;
  const double share = (double)voxel.share, weight = share * (double)voxel.ability * hardness;
  const double scale = 1.0 / moments.mass;
  sum->count += share;
  sum->vector[0] += weight * (gr[0] - moments.x * scale);
  sum->vector[1] += weight * (gr[1] - moments.y * scale);
  sum->vector[2] += weight * (gr[2] - moments.z * scale);
}

CC_FN void ccAddLane(CcNormalSum* sum, CcNormalSum lane) {
  sum->count += lane.count;
  for (int k = 0; k < 3; ++k) sum->vector[k] += lane.vector[k];
}

// Adds the voxels of one lane: `first`, first + CC_NORMAL_LANES ... below `end`. `terms`: Gr's
// three coordinates, then h of each tissue.
CC_FN CcNormalSum ccSumLane(const CcWorkpiece* w, CC_GLOBAL const double* terms,
                            CC_GLOBAL const CcTouchedVoxel* voxels, uint first, uint end) {
  CcNormalSum sum = ccNoVectors();
  for (uint k = first; k < end; k += CC_NORMAL_LANES) {
    const CcTouchedVoxel v = voxels[k];
    const int block = w->table[(v.x >> 3) + w->nx * ((v.y >> 3) + w->ny * (v.z >> 3))];
    if (block < 0) continue;
    const int cell = (v.x & 7) | (v.y & 7) << 3 | (v.z & 7) << 6;
    CC_GLOBAL const CcBlock* b = &w->blocks[block];
    ccAddVector(&sum, b->moments[cell], terms, v, terms[3 + b->tissue[cell]]);
  }
  return sum;
}

#endif
