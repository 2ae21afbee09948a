// A vector of voxels or boxes at once.
#include "contact/owned_lanes.h"

#include "base/simd.h"

namespace cloudcontact::search {

namespace {

constexpr int kAtOnce = OwnedVoxels::kBoxed;

}  // namespace

CC_LANES std::uint32_t voxelsBelow(const OwnedPlane& plane, const OwnedVoxels::Level& level,
                                   std::uint32_t first, int count) {
  const OwnedPlane p = plane;
  const OwnedVoxel* const v = &level.voxels[first];
  std::uint32_t bits = 0;
  for (int i = 0; i < kAtOnce; ++i) {
    const float below = p.here - (p.nx * v[i].x() + p.ny * v[i].y() + p.nz * v[i].z());
    bits |= std::uint32_t{below > p.least} << i;
  }
  return bits & ((1u << count) - 1);
}

CC_LANES std::uint32_t boxesBelow(const OwnedPlane& plane, const OwnedBoxes& boxes,
                                  std::uint32_t first, int count) {
  const OwnedPlane p = plane;
  const float ax = ccAbs(p.nx), ay = ccAbs(p.ny), az = ccAbs(p.nz);
  const float *const x = &boxes.x[first], *const y = &boxes.y[first], *const z = &boxes.z[first];
  const float *const u = &boxes.halfX[first], *const v = &boxes.halfY[first],
                     *const w = &boxes.halfZ[first];
  std::uint32_t bits = 0;
  for (int i = 0; i < kAtOnce; ++i) {
    const float middle = p.here - (p.nx * x[i] + p.ny * y[i] + p.nz * z[i]);
    bits |= std::uint32_t{middle + (ax * u[i] + ay * v[i] + az * w[i]) > p.least} << i;
  }
  return bits & ((1u << count) - 1);
}

}  // namespace cloudcontact::search
