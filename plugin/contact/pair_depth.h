// The one depth of a pair of bodies that the paper's law (3), FR = k d, asks for.
#pragma once

#include "contact/hits.h"
#include "kernels/contact/contact_depth.h"

namespace cloudcontact {

// A plain shape in a cloud: its edges are what the cloud's samples see too little of.
struct ShapeInCloud {
  const ContactBody* shape = nullptr;
  const ContactBody* cloud = nullptr;
  const HitColumns* hits = nullptr;  // frame: the cloud's
  int level = 0;                     // of the samples that hit
};

// Of all patches together [m]; `voxel` [m] the pair's. `shape` where one body is a plain shape (and
// the bodies touch), null where both are clouds.
double pairDepth(const CcPairSums& patches, const ShapeInCloud* shape, bool oneSided, double voxel);

}  // namespace cloudcontact
