// Looks up many samples in a field side by side. Each step is a loop over lanes without branches,
// which the compiler turns into vector instructions (base/simd.h).
#pragma once

#include "contact/sample_search.h"

namespace cloudcontact::search {

constexpr int kLanes = 256, kVector = 16;

// Loops run over whole vectors. The lanes after the last repeat it and are not used.
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
  float x[kLanes], y[kLanes], z[kLanes];      // from the voxel's center [voxels]
  std::uint32_t a[kLanes], b[kLanes];         // the record (kernels/contact/field_voxel.h)
  float depth[kLanes];                        // [m]
  float nx[kLanes], ny[kLanes], nz[kLanes];   // of the plane that gives the depth
  float beside[kLanes];                       // ccDepthBeside() of coarse samples [own voxels]
  std::int32_t kind[kLanes];                  // CC_WET and so on
  std::int32_t wet[kLanes], several[kLanes];  // numbers of lanes: hits; records of several planes
};

// Finds the lanes' records.
void findRecords(const Direction& dir, const FieldData& other, Lanes& lanes);
// Finds depth and normal of the lanes whose records are one plane; other lanes get meaningless
// values. Here and below, `voxel` [m] is the other body's.
void findDepths(float voxel, Lanes& lanes);
// The same for the first `count` of lanes.several, whose records have several planes: the plane of
// least depth, or of greatest depth if the planes' half-spaces unite.
void choosePlanes(const FieldData& other, float voxel, int count, Lanes& lanes);
// Both. Returns how many lanes have several planes; lanes.several lists them.
int measure(const FieldData& other, float voxel, Lanes& lanes);
// Of the first `count` of lanes.several, measured, moves to the front those over which another
// plane of the record may give the depth (ccEdgeWithin()). Returns how many.
int edgesWithin(const Direction& dir, const FieldData& other, float voxel, int count, Lanes& lanes);
// Sets `beside` of samples of a coarse level. Of the records of several planes, `count` of them,
// the lanes are in lanes.several.
void findBeside(const Direction& dir, const FieldData& other, float voxel, int count, Lanes& lanes);
// The same where each lane has one plane.
void findBeside(const Direction& dir, Lanes& lanes);
// Sets the lanes' kinds from depths and normals. Wet lanes may be hits. CC_NEARBY of surfaces with
// `finer` only, from `beside`.
void classify(const Direction& dir, bool finer, Lanes& lanes);
// The largest depth [m] that a sample may have for which a lane's sample of a coarse level stands,
// by `beside`; -1e30 far outside.
void estimateNearest(const Direction& dir, const Lanes& lanes, float* estimates);
// Adds the first `count` of lanes.wet as hits; their samples are in `samples`. If one of them is no
// hit, it adds none and returns false.
bool addHits(const Direction& dir, const SampleColumns& samples, Lanes& lanes, int count,
             HitColumns& hits);
// Moves the hits among the first `count` of lanes.wet to the front, in their order. Returns how
// many there are.
int hitsFirst(const Direction& dir, const SampleColumns& samples, Lanes& lanes, int count);
// Lists the sample bricks that may touch the other body from where they are, or from up to `aside`
// [own voxels] away, in ascending order.
void nearBricks(const Direction& dir, const FieldData& other, float aside,
                std::vector<std::uint32_t>& near);

}  // namespace cloudcontact::search
