// The paper's sums over collision voxels, for contacts, haptics, soft nodes and devices alike: k
// and c, (1) and (2); the base vector (4); and the digital normal, (5) and (5'). Plain C for C++
// and OpenCL C; a test checks the offsets.
//
// A voxel counts by its share: how much of it lies inside D, times its coverage; or 1. A sum
// divided by `count` is the mean.
//
// On a device a team of CC_NORMAL_LANES shares an area: each lane adds every so many-th voxel in
// order, and the lanes are added in order. So the bits do not depend on what runs it.
#pragma once

#include "kernels/digitize/window_sums.h"

#define CC_NORMAL_LANES 64

// A collision voxel: its share, and the tool's cutting ability there.
typedef struct {
  ushort x, y, z, unused;
  float share, ability;
} CcTouchedVoxel;

// (1) and (2): sums over the tissues of a body's collision voxels.
typedef struct {
  double count, stiffness, damping;  // n, n k, n c
} CcTissueSum;

CC_FN void ccAddTissue(CcTissueSum* sum, double share, double stiffness, double damping) {
  sum->count += share;
  sum->stiffness += share * stiffness;
  sum->damping += share * damping;
}

typedef struct {
  double count;      // n: sum of the shares
  double weight;     // of share, hardness and cutting ability
  double vector[3];  // of f_j by that weight: n F of (5') [voxels]
  double plain[3];   // and by the share alone: n F of (5)
} CcNormalSum;

CC_FN CcNormalSum ccNoVectors(void) {
  const CcNormalSum none = {0.0, 0.0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  return none;
}

// f_j = Gr - Gc (4) of a voxel by the sums of its window; `gr`: the representative point [voxels].
// Zero where the window holds no matter.
CC_FN void ccBaseVector(const CcMoments* moments, CC_GLOBAL const double* gr, double* f) {
  const double scale = moments->mass > 0.0 ? 1.0 / moments->mass : 0.0;
  const double here = moments->mass > 0.0 ? 1.0 : 0.0;
  f[0] = here * gr[0] - moments->x * scale;
  f[1] = here * gr[1] - moments->y * scale;
  f[2] = here * gr[2] - moments->z * scale;
}

// The weight of a voxel in (5'): its share times h of its tissue and the tool's cutting ability.
CC_FN double ccWeightOf(double share, double hardness, double ability) {
  return share * ability * hardness;
}

// Adds a voxel of that weight.
CC_FN void ccAddVector(CcNormalSum* sum, const double* f, double share, double weight) {
  sum->count += share;
  sum->weight += weight;
  for (int k = 0; k < 3; ++k) {
    sum->vector[k] += weight * f[k];
    sum->plain[k] += share * f[k];
  }
}

// Whether a collision follows (5): where none of its voxels has a hardness, or no cutting part of
// the tool is there. Such material resists too.
CC_FN int ccIsPlain(const CcNormalSum* sum) {
  return !(sum->weight > 0.0);
}

CC_FN void ccAddLane(CcNormalSum* sum, CcNormalSum lane) {
  sum->count += lane.count;
  sum->weight += lane.weight;
  for (int k = 0; k < 3; ++k) {
    sum->vector[k] += lane.vector[k];
    sum->plain[k] += lane.plain[k];
  }
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
    const CcMoments moments = b->moments[cell];
    double f[3];
    ccBaseVector(&moments, terms, f);
    const double share = (double)v.share;
    ccAddVector(&sum, f, share, ccWeightOf(share, terms[3 + b->tissue[cell]], (double)v.ability));
  }
  return sum;
}
