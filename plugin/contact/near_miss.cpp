// Where a sample comes nearest to the other body.
#include "contact/near_miss.h"

#include "base/simd.h"
#include "contact/field_lanes.h"
#include "kernels/contact/sharp_point.h"

#include <algorithm>

namespace cloudcontact {

using namespace search;

namespace {

constexpr float kLeans = 0.5f;   // sine of 30 deg between a sample and the other's surface
constexpr float kBeyond = 0.5f;  // [own voxels] from a sample's end, where its body is asked
// [own voxels] A sample whose ends differ in depth by less is as deep as its middle.
constexpr float kLevel = 1e-3f;

// A sample as far from the other body's surface as `near` says, over `share` of its area.
NearMiss missAt(const Direction& dir, const SurfaceSample& s, const SurfaceNear& near, float spread,
                float share = 1) {
  NearMiss miss{hitOf(dir, s, near.depth, near.normal, false), spread, spread};
  miss.hit.position = applied(dir.toFrame, V3(s.position[0], s.position[1], s.position[2]));
  miss.hit.area *= share;
  return miss;
}

}  // namespace

CC_LANES void findMost(const Lanes& lanes, float halfWidth, float margin, float least, float* most,
                       std::int32_t* near) {
  const float* const width = lanes.own.width;
  const int count = padded(lanes.count);
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float facing = lanes.facing[i], sine = CC_SQRT(ccMax(1.0f - facing * facing, 0.0f));
    most[i] = lanes.depth[i] + halfWidth * width[i] * sine;
    near[i] = ((lanes.a[i] & 0x70000000u) != 0) & (lanes.depth[i] >= -margin) & (most[i] >= least);
  }
}

// The near end is where the sample's plane comes nearest to the other body, as far as the sample
// goes.
//
// Beside one that leans there is a nearer one, unless an edge of its body is there. Such an edge is
// near a face of the other, so that the gap closes along the other's normal. With the mean of both,
// a nut's crests seemed to close as they slide along the flanks, and the rows that held them back
// shook it; and so did those of walls that lean on a peg's chamfer, near which the peg's edge is.
std::optional<NearMiss> missOf(const Direction& dir, const FieldData* other, const SurfaceSample& s,
                               const SurfaceNear& seen, std::size_t& asked) {
  const V3 place(s.position[0], s.position[1], s.position[2]),
      own(s.normal[0], s.normal[1], s.normal[2]);
  asked += other != nullptr;
  SurfaceNear near = other ? nearestSurface(dir, *other, place, seen) : seen;
  V3 there;
  ccTurnBack(dir.turnToOther, near.normal.data(), there.data());
  const V3 slope = -there - own.dot(-there) * own;
  const float sine = slope.norm(), half = dir.limits().halfWidth * s.width;
  if (sine > kLeans) {
    ++asked;
    if (!isOutsideOwn(dir, place + (half / dir.voxel + kBeyond) / sine * slope))
      return std::nullopt;
    NearMiss miss = missAt(dir, s, near, 0);
    miss.hit.own = -miss.hit.other;
    miss.end = half * sine;
    return miss;
  }
  if (!(half * sine > kLevel * dir.voxel)) return missAt(dir, s, near, 0);
  if (!other) return missAt(dir, s, near, half * sine);
  ++asked;
  // Over an edge of the other body, no farther than to the place below it.
  const bool isOverEdge = near.normal.dot(seen.normal) < CC_SHARP_ALIKE;
  const float by = isOverEdge ? std::min(half, -near.depth * sine) : half;
  const SurfaceNear end = nearestSurface(dir, *other, place + by / dir.voxel / sine * slope,
                                         {near.depth + by * sine, near.normal});
  if (by < half) return missAt(dir, s, end, 0, 1 - by / half);
  return missAt(dir, s, {near.depth, end.normal}, std::max(end.depth - near.depth, 0.0f));
}

}  // namespace cloudcontact
