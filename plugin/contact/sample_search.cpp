// What becomes of a sample whose depth is known.
#include "contact/sample_search.h"

namespace cloudcontact::search {

void addHit(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep,
            HitColumns& hits) {
  const V3 at = applied(dir.toFrame, V3(s.position[0], s.position[1], s.position[2]));
  const V3 own = turned(dir.frameFromOwn, V3(s.normal[0], s.normal[1], s.normal[2]));
  const V3 n = deep ? V3(-own) : turned(dir.frameFromOther, other);
  const CcHit h = ccHitOf(at.data(), own.data(), n.data(), depth, dir.limits().halfWidth * s.width);
  const bool miss = h.wet.depth1 <= 0.0f;
  HitSearch::Misses& misses = dir.misses;
  if (miss && (dir.level > 0 || depth < std::max(-misses.margin, misses.nearest - misses.within)))
    return;
  Hit hit{V3(h.position[0], h.position[1], h.position[2]),
          own,
          n,
          s.area * dir.voxel * dir.voxel,
          h.wet.share,
          h.wet.depth1,
          h.wet.depth2,
          h.wet.depth3,
          depth,
          h.facing,
          static_cast<std::int8_t>(dir.side),
          static_cast<std::int8_t>(deep)};
  if (!miss) return hits.push_back(hit);
  misses.nearest = std::max(misses.nearest, depth);
  hit.position -= 0.5f * depth * own;
  hit.share = 1;
  hit.depth1 = hit.depth2 = hit.depth3 = 0;
  misses.list.push_back(hit);
}

}  // namespace cloudcontact::search
