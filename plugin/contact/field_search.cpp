// Samples of one body looked up in the other's field: bricks of samples first, by their bounding
// sphere against the other's brick distance, then each sample in one 8-byte fetch.
#include "shared_search.h"

namespace cloudcontact::search {

namespace {

struct FieldTarget {
  const Direction& dir;
  const FieldData& other;
  float voxel;  // of the other body [m]
  CcLimits limits;

  void nearBricks(std::vector<std::uint32_t>& near) const {
    search::nearBricks(dir, other, 0, near);
  }

  int measure(Lanes& lanes) const {
    findRecords(dir, other, lanes);
    const int count = search::measure(other, voxel, lanes);
    if (dir.level == kLevels - 1) return 0;
    int divided = 0;
    for (int i = 0; i < count; ++i)
      if (edgeWithin(lanes, lanes.several[i])) lanes.several[divided++] = lanes.several[i];
    return divided;
  }

  // Whether another of the record's planes may give the depth somewhere within a wide sample.
  bool edgeWithin(const Lanes& lanes, int lane) const {
    const float width = dir.samples.levels[dir.level].samples.width[lanes.sample[lane]];
    const float n[3] = {lanes.nx[lane], lanes.ny[lane], lanes.nz[lane]};
    const float r[3] = {lanes.x[lane], lanes.y[lane], lanes.z[lane]};
    return ccEdgeWithin(&limits, {lanes.a[lane], lanes.b[lane]}, other.planes(), r,
                        lanes.depth[lane], n, width, voxel, dir.voxel) != 0;
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
  FieldTarget target{dir, other, static_cast<float>(other.cloud().voxelSize()), dir.limits()};
  searchShared(dir, target, candidates, hits, shares);
}

}  // namespace cloudcontact::search
