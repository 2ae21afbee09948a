// The sharp points of a cloud: where the planes of a voxel on a convex edge or corner meet.
#pragma once

#include <cloudcontact/field/surface_field.h>

namespace cloudcontact {

// The depth [m] in `other` of the deepest sharp point of `sharp` inside `within`, a box in sharp's
// frame; negative infinity if there is none. `toOther`: from sharp's frame to other's.
double deepestSharpPoint(const SurfaceField& sharp, const SurfaceField& other, const Pose& toOther,
                         const Eigen::AlignedBox3d& within);

}  // namespace cloudcontact
