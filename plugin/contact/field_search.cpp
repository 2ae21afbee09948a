// Samples of one body looked up in the other's field: bricks of samples first, by their bounding
// sphere against the other's brick distance, then each sample in one 8-byte fetch.
#include "contact/shared_search.h"

namespace cloudcontact::search {

namespace {

struct FieldTarget {
  const Direction& dir;
  const FieldData& other;
  float voxel;  // of the other body [m]

  void nearBricks(std::vector<std::uint32_t>& near) const {
    search::nearBricks(dir, other, 0, near);
  }

  int measure(Lanes& lanes) const {
    findRecords(dir, other, lanes);
    const int count = search::measure(other, voxel, lanes);
    if (dir.level == kLevels - 1) return 0;
    return edgesWithin(dir, other, voxel, count, lanes);
  }

  void measureParts(Lanes& parts, const SampleColumns&) const {
    for (int i = 0; i < parts.count; ++i) parts.several[i] = i;
    choosePlanes(other, voxel, parts.count, parts);
  }

  float deepAt(const SurfaceSample& s) const {
    const V3 x = applied(dir.toOther, V3(s.position[0], s.position[1], s.position[2]));
    const CcPlace place = ccPlaceOf(other.records().bricks(), x.data());
    const int bricks = other.brickDistance()[static_cast<std::size_t>(place.brick)];
    return ccDepthBelow(bricks, voxel);
  }
};

}  // namespace

void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits, HitSearch::Shares& shares) {
  FieldTarget target{dir, other, static_cast<float>(other.cloud().voxelSize())};
  searchShared(dir, target, candidates, hits, shares);
}

}  // namespace cloudcontact::search
