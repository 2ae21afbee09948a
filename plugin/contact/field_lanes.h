// Samples on their way through another body's field, many side by side: each step is a loop over
// lanes without branches, which the compiler turns into vector instructions (simd.h).
#pragma once

#include "contact/sample_search.h"

namespace cloudcontact::search {

constexpr int kLanes = 256, kVector = 16;

// Loops go on to a whole number of vectors: what is left over would be done one by one. A few lanes
// behind the last repeat it, and nobody looks at them.
constexpr int padded(int count) {
  return (count + kVector - 1) & ~(kVector - 1);
}
template <typename Number>
void pad(Number* lanes, int count) {
  for (int i = count; i < padded(count); ++i) lanes[i] = lanes[count - 1];
}

struct Lanes {
  int count = 0;
  std::uint32_t sample[kLanes];
  std::int32_t record[kLanes];                // number of the record
  float x[kLanes], y[kLanes], z[kLanes];      // from the voxel's centre [voxels]
  std::uint32_t a[kLanes], b[kLanes];         // the record (kernels/field_voxel.h)
  float depth[kLanes];                        // [m]
  float nx[kLanes], ny[kLanes], nz[kLanes];   // of the plane that gave it
  std::int32_t kind[kLanes];                  // CC_WET and so on
  std::int32_t wet[kLanes], several[kLanes];  // numbers of lanes: hits, records of several planes
};

// The lanes' records; `voxel` [m] below is the other body's.
void findRecords(const Direction& dir, const FieldData& other, Lanes& lanes);
// Depth and normal of lanes whose record is one plane; what others get means nothing.
void findDepths(float voxel, Lanes& lanes);
// The same for the first `count` of lanes.several, whose records have several planes: by the least,
// or, where these unite, by the greatest.
void choosePlanes(const FieldData& other, float voxel, int count, Lanes& lanes);
// Both. How many of lanes.several have several planes.
int measure(const FieldData& other, float voxel, Lanes& lanes);
// Of the first `count` of lanes.several, measured, those first over which another of the record's
// planes than the one that gave the depth may give it (ccEdgeWithin()). Returns how many.
int edgesWithin(const Direction& dir, const FieldData& other, float voxel, int count, Lanes& lanes);
// Kinds, from depths and normals. Wet is what may come to a hit, or, with `missesToo`, what is near
// enough to be told of as a near miss.
void classify(const Direction& dir, bool missesToo, Lanes& lanes);
// Makes the first `count` of lanes.wet hits; their samples are `samples`. Adds none, and returns
// false, where one of them is no hit.
bool addHits(const Direction& dir, const SampleColumns& samples, Lanes& lanes, int count,
             HitColumns& hits);
// Parts the first `count` of lanes.wet: those that are hits stay, the others go to `dry`. Returns
// how many stay.
int partHits(const Direction& dir, const SampleColumns& samples, Lanes& lanes, int count,
             std::int32_t* dry);
// Numbers of the sample bricks that may touch the other body where they are, or `aside` [own
// voxels] from there, first to last.
void nearBricks(const Direction& dir, const FieldData& other, float aside,
                std::vector<std::uint32_t>& near);

}  // namespace cloudcontact::search
