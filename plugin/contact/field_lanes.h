// Looks up many samples in a field side by side. Each step is a loop over lanes without branches,
// which the compiler turns into vector instructions (base/simd.h).
#pragma once

#include "contact/lanes.h"

namespace cloudcontact::search {

// The record at a place in a field's grid [voxels], and where in its voxel that is.
CcVoxel recordAt(const FieldData& field, const float* x, CcPlace& place);
// Finds the lanes' records.
void findRecords(const Direction& dir, const FieldData& other, Lanes& lanes);
// Finds depth and normal of the lanes whose records are one plane; other lanes get meaningless
// values. Here and below, `voxel` [m] is the other body's.
void findDepths(float voxel, Lanes& lanes);
// Lists in lanes.several the lanes whose records have several planes; returns how many.
int findSeveral(Lanes& lanes);
// The depth and normal of the first `count` of lanes.several: the plane of least depth, or of
// greatest depth if the planes' half-spaces unite. With `beside` also `beside` of all the planes.
void choosePlanes(const Direction& dir, const FieldData& other, float voxel, bool beside, int count,
                  Lanes& lanes);
// The same of parts of samples, where all parts of a sample have its record and follow each other.
void choosePlanesOfParts(const FieldData& other, float voxel, Lanes& parts);
// All three, and with `beside` that of all lanes.
void measure(const Direction& dir, const FieldData& other, float voxel, bool beside, Lanes& lanes);
// Sets `beside` of samples of a coarse level, where each lane has one plane.
void findBeside(const Direction& dir, Lanes& lanes);
// Sets `facing`.
void findFacing(const Direction& dir, Lanes& lanes);
// Of the lanes whose records have several planes, lists in lanes.several those over which another
// plane of the record may give the depth (ccEdgeWithin()). Returns how many.
int edgesWithin(const Direction& dir, const FieldData& other, float voxel, Lanes& lanes);
// Sets the lanes' kinds from depths and `facing`. Wet lanes may be hits. CC_NEARBY of surfaces with
// `finer` only, from `beside`.
void classify(const Direction& dir, bool finer, Lanes& lanes);
// Of each lane's sample of a coarse level, the largest depth [m] that a sample may have for which
// it stands, by `beside`, or -1e30 far outside; and its own depth, or without a plane the same.
void estimateNearest(const Direction& dir, const Lanes& lanes, float* estimates, float* depths);
// Adds the first `count` of lanes.wet as hits; their samples are in `samples`. If one of them is no
// hit, it adds none and returns false. `other`: the other body's field; null: it is a shape.
bool addHits(const Direction& dir, const SampleColumns& samples, const FieldData* other,
             Lanes& lanes, int count, HitColumns& hits);
// How deep a place is in the other body, negative outside [m], and the normal there, outward, in
// that body's frame.
struct SurfaceNear {
  float depth;
  V3 normal;
};
// From a place outside the other body, by `seen` of its plane there, to the nearest surface. Planes
// end at edges, and beyond them go on as if they did not.
SurfaceNear nearestSurface(const Direction& dir, const FieldData& other, const V3& place,
                           const SurfaceNear& seen);
// Whether a place in the samples' grid is outside their own body.
bool isOutsideOwn(const Direction& dir, const V3& place);
// Moves the hits among the first `count` of lanes.wet to the front, in their order. Returns how
// many there are.
int hitsFirst(const Direction& dir, const SampleColumns& samples, Lanes& lanes, int count);
// Lists the lanes whose samples own voxels that may lie in the other body, after findFacing(): some
// of a voxel does where its center is half a voxel outside. Returns how many.
int findTouched(const Direction& dir, const Lanes& lanes, std::int32_t* list);
// Lists the sample bricks that may touch the other body from where they are, or from up to `aside`
// [own voxels] away, in ascending order.
void nearBricks(const Direction& dir, const FieldData& other, float aside,
                std::vector<std::uint32_t>& near);

}  // namespace cloudcontact::search
