// What a patch touches: sums over its collision voxels.
#pragma once

#include "contact/binner.h"

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// Sums over the collision voxels of a patch, of both bodies.
struct PatchMatter {
  double count[2] = {};                       // n of each body: sum of the voxels' shares
  double stiffness[2] = {}, damping[2] = {};  // sum of share times the tissue's k and c
  // Sum of share, hardness, ability and base vector: those of A's voxels less those of B's, in the
  // pair's frame [m]. `moment`: of the same about the frame's origin [m^2].
  Vec3 vectors = Vec3::Zero(), moment = Vec3::Zero();
  double lengths = 0;  // sum of their lengths [m]

  void add(const PatchMatter& other, double share = 1) {
    for (int s = 0; s < 2; ++s) {
      count[s] += share * other.count[s];
      stiffness[s] += share * other.stiffness[s];
      damping[s] += share * other.damping[s];
    }
    vectors += share * other.vectors;
    moment += share * other.moment;
    lengths += share * other.lengths;
  }
};

// The hits that a query has found, and their bins.
struct FoundHits {
  const HitColumns& hits;
  const Binner& binner;
  int level = 0;    // of the samples
  double cell = 0;  // of the bins [m]
  double gap = 0;   // HitSearch::gap() [m]
};

}  // namespace cloudcontact
