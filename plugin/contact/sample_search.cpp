// Memory of a search, and single samples as hits.
#include "contact/sample_search.h"

namespace cloudcontact::search {

void CoarseFound::begin(std::size_t samples) {
  known = true;
  if (estimate.size() >= samples) return;
  estimate.resize(samples);
  depth.resize(samples);
}

void CoarseFound::reserveLike(const CoarseFound& other) {
  bricks.reserve(other.bricks.capacity());
  estimate.reserve(other.estimate.capacity());
  depth.reserve(other.depth.capacity());
}

void Candidates::reserveLike(const Candidates& other) {
  // A search swaps `runs` and `finer`.
  const std::size_t found = std::max(other.runs.capacity(), other.finer.capacity());
  runs.reserve(found);
  finer.reserve(found);
  next.reserve(other.next.capacity());
  bricks.reserve(other.bricks.capacity());
  deep.reserve(other.deep.capacity());
  touched.reserve(other.touched.capacity());
  parts.fit(other.parts);
  places.reserve(other.places.capacity());
}

void Shares::reserveLike(const Shares& other) {
  runs.reserve(other.runs.capacity());
  if (all.size() < other.all.size()) all.resize(other.all.size());
  for (std::size_t i = 0; i < other.all.size(); ++i) {
    all[i].candidates.reserveLike(other.all[i].candidates);
    all[i].hits.reserveLike(other.all[i].hits);
  }
}

Hit hitOf(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep) {
  const V3 at = applied(dir.toFrame, V3(s.position[0], s.position[1], s.position[2]));
  const V3 own = turned(dir.frameFromOwn, V3(s.normal[0], s.normal[1], s.normal[2]));
  const V3 n = deep ? V3(-own) : turned(dir.frameFromOther, other);
  const CcHit h = ccHitOf(at.data(), own.data(), n.data(), depth, dir.limits().halfWidth * s.width);
  return cloudcontact::hitOf(h, s.area * dir.voxel * dir.voxel, depth, dir.side, deep);
}

}  // namespace cloudcontact::search
