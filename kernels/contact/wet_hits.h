// Where a patch is wet, by its hits, so that its points stand on the surfaces (docs/force.md,
// "Points"). Plain C for C++ and OpenCL C.
//
// A hit lies midway between the two surfaces, and its plane goes on as far as the sample that it
// stands for. A place is looked up among the hits of a patch: which one is nearest, first beside
// it in the patch's plane, then above or below it. So a place between two turns of a thread finds
// one of them, and no mean of both.
#ifndef CLOUDCONTACT_KERNELS_WET_HITS_H
#define CLOUDCONTACT_KERNELS_WET_HITS_H

#include "kernels/base/vector64.h"
#include "kernels/contact/hit_bins.h"

#define CC_COVERS 0.35  // [widths of a hit's sample] a place as near as this counts as within it
// [voxels] Places as near as this to a sample stay where they are in the patch's plane. Farther
// ones move this many times the way that they are beyond, up to the hit's middle: an arc is deepest
// there, and its samples' borders are dry.
#define CC_BESIDE_VOXELS 0.25
// [voxels] Only the points of patches that are pressed this deep move: beside rims that hardly
// touch, samples stand that do not touch at all.
#define CC_PRESSED_VOXELS 0.1
#define CC_INWARD 3.0
// Of a way above or below a place, and of one to a hit's middle, against one to its sample's
// border.
#define CC_ABOVE (1.0 / 16.0)
#define CC_MIDDLES (1.0 / 64.0)
#define CC_WET_ROUNDS 2      // of moving places and balancing them
#define CC_LARGEST 0.3       // [cells of a bin] the largest sample reaches this far from its middle
#define CC_LEAST_COSINE 0.5  // between a point's normal and a hit's
#define CC_LEAST_GATE 0.5f   // hits of walls are not where a patch is

// The hit nearest to a line through `place` along `normal`, near that place; all in the frame body.
typedef struct {
  CcVec place, normal;
  double reach;       // of a sample, in its widths
  double above;       // what the square of a way along the line counts, CC_ABOVE
  double square;      // of the least way, by its parts' weights [m^2]
  double nearest;     // its root [m]
  CcVec at, surface;  // the hit, and its normal from A to B
  CcVec aside;        // from the line to the hit
  double beside;      // from the line to the border of its sample [m]
  double away;        // the same, with the way along the line [m]
  double moves;       // how much of its way to the hit the place goes, 0..1
  int found;
} CcNearestHit;

CC_FN CcNearestHit ccNoHit(CcVec place, CcVec normal, double reach, double above) {
  const CcVec none = {0.0, 0.0, 0.0};
  const CcNearestHit n = {place,  normal, reach, above, 1e300, 1e150, place,
                          normal, none,   0.0,   0.0,   1.0,   0};
  return n;
}

CC_FN CcVec ccAside(CcVec from, CcVec normal) {
  return ccMinus(from, ccTimes(ccDot64(from, normal), normal));
}

// The square of the way from the line to a point, if it is `from` the place.
CC_FN double ccSquareAside(CcVec from, CcVec normal) {
  const double along = ccDot64(from, normal);
  return ccDot64(from, from) - along * along;
}

// How far away a bin is. Of equally near hits those of the nearest bin come first, then the bins in
// their order.
CC_FN double ccSquareTo(const CcNearestHit* best, CcVec middle) {
  const CcVec from = ccMinus(middle, best->place);
  return ccDot64(from, from);
}

// The way from a line to a hit.
typedef struct {
  CcVec from, aside;  // from the place, and from the line, to the hit
  double away;        // length of `aside`
  double beside;      // from the line to the border of the hit's sample [m]
  double above;       // along the line to the hit's plane [m]
  double square;      // by the parts' weights [m^2]
} CcWayToHit;

// But for what is above. `width`: root of the sample's area [m].
CC_FN CcWayToHit ccWayBeside(const CcNearestHit* to, double cell, CcVec where, double width) {
  CcWayToHit way;
  way.from = ccMinus(where, to->place);
  way.aside = ccAside(way.from, to->normal);
  way.away = ccLength64(way.aside);
  const double reach = ccMin64(to->reach * width, CC_LARGEST * cell);
  way.beside = ccMax64(0.0, way.away - reach);
  way.above = 0.0;
  way.square = way.beside * way.beside + CC_MIDDLES * (way.away * way.away);
  return way;
}

// Beside its sample a hit's plane says nothing.
CC_FN void ccAddAbove(const CcNearestHit* to, CcVec surface, CcWayToHit* way) {
  const CcVec within = way->away > 0.0
                           ? ccMinus(way->from, ccTimes(way->beside / way->away, way->aside))
                           : way->from;
  way->above = ccDot64(surface, within) / ccMax64(ccDot64(surface, to->normal), CC_LEAST_COSINE);
  way->square = way->square + to->above * (way->above * way->above);
}

// Makes a hit the nearest.
CC_FN void ccTakeHit(CcNearestHit* best, CcVec where, CcVec surface, const CcWayToHit* way) {
  best->square = way->square;
  best->nearest = CC_SQRT64(way->square);
  best->at = where;
  best->surface = surface;
  best->aside = way->aside;
  best->beside = way->beside;
  best->away = CC_SQRT64(way->beside * way->beside + way->above * way->above);
  best->found = 1;
}

// A hit's normal from A to B. `own`, `other`: of the body whose sample it is, and of the other;
// `side`: 0 for A's samples.
CC_FN CcVec ccSurfaceOf(const float* own, const float* other, int side) {
  const double sign = side == 0 ? 1.0 : -1.0;
  return ccUnit64(
      ccTimes(sign, ccMinus(ccVec(own[0], own[1], own[2]), ccVec(other[0], other[1], other[2]))));
}

// `at`: the hit; the rest as for ccSurfaceOf() and ccGate().
CC_FN void ccTryHit(CcNearestHit* best, double cell, const float* at, const float* own,
                    const float* other, float facing, float depth, float area, int side) {
  if (ccGate(facing, depth) < CC_LEAST_GATE) return;
  const CcVec where = ccVec(at[0], at[1], at[2]);
  const double most = best->nearest + CC_LARGEST * cell;
  if (!(ccSquareAside(ccMinus(where, best->place), best->normal) < most * most)) return;
  CcWayToHit way = ccWayBeside(best, cell, where, CC_SQRT64((double)area));
  if (!(way.square < best->square)) return;
  const CcVec surface = ccSurfaceOf(own, other, side);
  ccAddAbove(best, surface, &way);
  if (way.square < best->square) ccTakeHit(best, where, surface, &way);
}

// How sure it is where a patch is wet, by its deepest sample: 0 where none is inside.
CC_FN double ccPressed(double deepest, double voxel) {
  return ccClamp64(deepest / (CC_PRESSED_VOXELS * voxel), 0.0, 1.0);
}

// Whether a place may have to move. A place between the samples of a face has them on all sides, so
// what is nearest to its mirror image at the hit tells.
CC_FN int ccIsBeside(const CcNearestHit* found, double voxel) {
  return found->found && found->beside > CC_BESIDE_VOXELS * voxel;
}
CC_FN CcNearestHit ccMirrored(const CcNearestHit* found) {
  return ccNoHit(ccMinus(found->place, found->aside), found->normal, found->reach, found->above);
}
CC_FN double ccMoves(const CcNearestHit* mirrored, double voxel) {
  return mirrored->found ? ccMin64(1.0, mirrored->away / voxel) : 1.0;
}

// The way across its normal from a place to where the patch is wet.
CC_FN CcVec ccWayToWet(const CcNearestHit* found, double voxel) {
  const double beyond = found->beside - CC_BESIDE_VOXELS * voxel;
  if (!found->found || !(beyond > 0.0)) return ccVec(0.0, 0.0, 0.0);
  const double part = ccMin64(1.0, CC_INWARD * beyond / ccLength64(found->aside));
  return ccTimes(found->moves * part, found->aside);
}

// How far along `normal` a place is from midway between the surfaces.
CC_FN double ccRiseToWet(const CcNearestHit* found, CcVec place, CcVec normal) {
  if (!found->found) return 0.0;
  return ccDot64(found->surface, ccMinus(found->at, place)) /
         ccMax64(ccDot64(found->surface, normal), CC_LEAST_COSINE);
}

#endif
