// The closed form of a cloud that is a ball, box, cylinder, capsule, cone or convex body with flat
// faces, for rays and sweeps.
#pragma once

#include <cloudcontact/field/recognized_shape.h>

namespace cloudcontact {

// The shape that the cloud is within a tenth of a voxel, in its frame; null if it is none, or if it
// was cut. The first call finds it; calls may come from several threads.
const PlacedSolid* closedForm(const SurfaceField& field);

}  // namespace cloudcontact
