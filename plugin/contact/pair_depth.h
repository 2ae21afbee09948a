// The one depth of a pair for the paper's law (3), FR = k d (docs/force.md, "Depth of the pair").
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "contact/pair_frame.h"
#include "kernels/contact/contact_patch.h"

namespace cloudcontact {

// Two bodies, and the hits or near misses in their frame.
struct DepthQuery {
  const ContactBody *a = nullptr, *b = nullptr;
  const PairFrame* frame = nullptr;
  const HitColumns* hits = nullptr;
  int level = 0;  // of the samples that hit
};

struct PairDepth {
  double depth = 0, error = 0;  // [m] ccDepthError()
  // How far a near patch is as deep as its deepest sample ends, 0..1: a tip.
  // Moments at the depth to which near misses are moved are off by a thirtieth of it, and what
  // stands on tips would rock between that and the first touch, which is such an end.
  double ended = 0;
};
// The depth of all patches together.
PairDepth pairDepth(const CcPairSums& patches, const DepthQuery& pair, const CcTerms& terms);

}  // namespace cloudcontact
