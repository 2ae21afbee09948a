// How far the depth of a pair is that of its edges (docs/force.md, "Depth of the pair"). Plain C
// for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_CONTACT_EDGES_H
#define CLOUDCONTACT_KERNELS_CONTACT_EDGES_H

#include "kernels/contact/contact_depth.h"

// Edges count from the first b on, and fully from the second. On a face and on a cylinder's side
// (0.55) the mean over many samples is more accurate than one point.
#define CC_EDGED 0.6
#define CC_ALL_EDGE 0.8
// The same of how much more coherent one of two clouds is.
#define CC_ON_FACE 0.5
#define CC_ALL_ON_FACE 0.9

// The weight of edges, 0..1, by the b at the depth of the deepest sample at least: moments over
// coarse samples may read less, and then b, too.
CC_FN double ccEdged(const CcPairSums* s, const CcPairDepth* d) {
  const double pointed = ccMax64(d->pointed, ccPointedness(s, s->most));
  return (1.0 - d->smooth) * ccRamp(pointed, CC_EDGED, CC_ALL_EDGE);
}

// The same of two clouds: of an edge or a corner on a face, which is the far more coherent surface.
// Where edges cross, no point of either is as deep as the pair; on a thread both bodies have edges.
CC_FN double ccEdgedOnFace(const CcPairSums* s, const CcPairDepth* d) {
  const double one = ccAbs64(2.0 * s->trust / s->size - 1.0);
  return ccEdged(s, d) * ccRamp(one, CC_ON_FACE, CC_ALL_ON_FACE);
}

// Takes the depth of edges that were looked up, where they are deeper.
CC_FN void ccTakeEdge(CcPairDepth* d, double edged, double edge) {
  d->depth += edged * ccMax64(0.0, edge - d->depth);
}

#endif
