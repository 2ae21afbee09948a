// How deep the sharp edges and corners of a shape lie in a cloud.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/solid.h>

namespace cloudcontact {

// The greatest depth [m] of any point of the shape's edges inside `within`, a box in the cloud's
// frame; negative infinity where none is there, or the shape is round. `toCloud` takes the shape's
// frame to the cloud's.
double deepestEdge(const Solid& shape, const Pose& toCloud, const SurfaceField& cloud,
                   const Eigen::AlignedBox3d& within);

}  // namespace cloudcontact
