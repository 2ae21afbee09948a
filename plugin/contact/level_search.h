// The search of one level in one direction.
#pragma once

#include <cloudcontact/law/solid.h>

#include "contact/sample_search.h"

namespace cloudcontact::search {

// Looks samples up in the other body's field. Bricks of samples come first, by their bounding
// spheres and the other's distances from brick to brick.
void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits, Shares& shares);
// Looks samples up in a shape's formula. `toShape` maps from the samples' grid [m].
void searchShape(const Direction& dir, const Solid& shape, const Pose& toShape,
                 Candidates& candidates, HitColumns& hits, Shares& shares);

}  // namespace cloudcontact::search
