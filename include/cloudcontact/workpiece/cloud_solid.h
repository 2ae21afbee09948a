// Clouds as solids and areas: a whole tool, its cutting surface, or any other cloud.
#pragma once

#include <cloudcontact/law/solid.h>
#include <cloudcontact/voxels/cloud.h>

namespace cloudcontact {

// Where the cloud has matter; `place` is that of its frame. Throws std::invalid_argument where the
// cloud is empty.
PlacedSolid cloudSolid(const Cloud& cloud, const Pose& place = {});

// The matter of `tool` within `thickness` [m] of its surface and, if given, inside `where`: the
// cutting surface of a tool (paper, Fig. 6 c). Throws std::invalid_argument where nothing is left
// or the thickness is not positive.
Cloud surfaceLayer(const Cloud& tool, double thickness, const PlacedSolid* where = nullptr);

}  // namespace cloudcontact
