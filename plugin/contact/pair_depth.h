// The one depth of a pair for the paper's law (3), FR = k d (docs/force.md, "Depth of the pair").
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "contact/pair_frame.h"
#include "kernels/contact/contact_error.h"

namespace cloudcontact {

// A shape in a cloud. The cloud's samples see too little of the shape's edges.
struct ShapeInCloud {
  const ContactBody* shape = nullptr;
  const ContactBody* cloud = nullptr;
  const HitColumns* hits = nullptr;  // in the cloud's frame
  int level = 0;                     // of the samples that hit
};

// Two clouds that touch, and the hits in their frame.
struct CloudsInFrame {
  const ContactBody *a = nullptr, *b = nullptr;
  const PairFrame* frame = nullptr;
  const HitColumns* hits = nullptr;
};

struct PairDepth {
  double depth = 0, error = 0;  // [m] ccDepthError()
};
// The depth of all patches together. `shape`, `clouds`: null if there are none, or if the bodies do
// not touch. `level`: of the samples that hit. `voxel`: the pair's [m].
PairDepth pairDepth(const CcPairSums& patches, const ShapeInCloud* shape,
                    const CloudsInFrame* clouds, bool oneSided, int level, double voxel);

}  // namespace cloudcontact
