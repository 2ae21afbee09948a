// A sample of one body that nearly touches the other.
#pragma once

#include "contact/field_lanes.h"
#include "contact/sample_search.h"

#include <optional>

namespace cloudcontact {

// A sample that nearly touches. `hit.other` is the normal where the other body is nearest; so is,
// the other way, `hit.own` of a sample beside an edge of its body.
struct NearMiss {
  Hit hit;       // at the sample itself
  float spread;  // half the range of its depth [m] (ccWet())
  float end;     // how much nearer it ends than its middle is, at an edge of its body, too [m]
};

// The sample `s`, from its middle to its near end; `seen`: the other body's plane there. None if a
// sample beside it is nearer. `other`: null for a shape. Adds to `asked` the places looked up.
std::optional<NearMiss> missOf(const search::Direction& dir, const FieldData* other,
                               const SurfaceSample& s, const search::SurfaceNear& seen,
                               std::size_t& asked);

// Of each lane the depth that no part of its sample exceeds [m], and whether it is `least` at least
// and within the margin: what is nearest to the other body is at most as near as the other's plane
// is. `halfWidth` [m]: of a sample one voxel wide.
void findMost(const search::Lanes& lanes, float halfWidth, float margin, float least, float* most,
              std::int32_t* near);

}  // namespace cloudcontact
