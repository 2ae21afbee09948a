// What becomes of a sample whose depth is known.
#include "sample_search.h"

namespace cloudcontact::search {

namespace {

// A sample farther off the other surface than this [voxels] has no finer sample in its cell that
// touches: these lie at most kSlope beside it, times the sine between the surfaces, and both may
// bend by kSlack. By level.
constexpr float kSlack[kLevels] = {0, 0.25f, 0.8f}, kSlope[kLevels] = {0, 1.5f, 3.5f};

}  // namespace

void addHit(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep,
            std::vector<Hit>& hits) {
  const V3 own = dir.frameFromOwn * Eigen::Map<const V3>(s.normal);
  const V3 n = deep ? V3(-own) : V3(dir.frameFromOther * other);
  const float facing = -own.dot(n);
  const float sine = std::sqrt(std::max(0.0f, 1.0f - facing * facing));
  const CcWet wet = ccWet(depth, kHalfWidth * s.width * dir.voxel * sine);
  const V3 at = dir.toFrame(Eigen::Map<const V3>(s.position));
  if (wet.depth1 <= 0.0f) {
    HitSearch::Misses& misses = dir.misses;
    if (dir.level > 0 || depth < std::max(-misses.margin, misses.nearest - misses.within)) return;
    misses.nearest = std::max(misses.nearest, depth);
    misses.list.push_back({at - 0.5f * depth * own, own, n, s.area * dir.voxel * dir.voxel, 1, 0, 0,
                           0, depth, facing, static_cast<std::int8_t>(dir.side), 0});
    return;
  }
  // Along its own normal, so that its moment stays what it was.
  hits.push_back({at - 0.5f * wet.depth1 / wet.share * own, own, n, s.area * dir.voxel * dir.voxel,
                  wet.share, wet.depth1, wet.depth2, wet.depth3, depth, facing,
                  static_cast<std::int8_t>(dir.side), static_cast<std::int8_t>(deep)});
}

bool mayTouchBeside(const Direction& dir, const SurfaceSample& s, float depth, const V3& normal) {
  const float slack = kSlack[dir.level] + dir.misses.margin / dir.voxel, slope = kSlope[dir.level];
  const float beyond = -depth - slack;
  if (beyond < 0) return true;
  if (beyond > slope) return false;
  const float facing = (dir.turnToOther * Eigen::Map<const V3>(s.normal)).dot(normal);
  return beyond * beyond < slope * slope * (1.0f - facing * facing);
}

}  // namespace cloudcontact::search
