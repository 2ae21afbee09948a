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

}  // namespace cloudcontact
