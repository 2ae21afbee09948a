// A level's search in a field or in a shape.
#include "contact/level_search.h"

#include "contact/lane_search.h"
#include "contact/search_targets.h"

namespace cloudcontact::search {

void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits, Shares& shares) {
  FieldTarget target{dir, other, static_cast<float>(other.cloud().voxelSize())};
  searchShared(dir, target, candidates, hits, shares);
}

void searchShape(const Direction& dir, const Solid& shape, const Pose& toShape,
                 Candidates& candidates, HitColumns& hits, Shares& shares) {
  ShapeTarget target{dir, shape, toShape, dir.samples.levels[dir.level].samples};
  searchShared(dir, target, candidates, hits, shares);
}

}  // namespace cloudcontact::search
