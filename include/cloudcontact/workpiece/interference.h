// Interference: the collision voxels B of a tool and a workpiece, both of voxels. Paper, Step 2,
// Fig. 5. CollisionFinder::gather() computes the digital normal of the voxels. Other digital kinds
// become voxels first, by toCloud(): none of them is found faster (docs/method.md, "Step 2:
// interference").
#pragma once

#include <cloudcontact/field/base_vector_field.h>

#include <vector>

namespace cloudcontact {

// The voxels of the workpiece that hold material and whose centers lie in voxels of the tool with
// coverage of one half or more. `toolPlace`: the tool's frame in the workpiece's. Sorted by z, y,
// x; the same for any number of threads (0: all cores). Without interference the result is empty.
// Throws std::invalid_argument where the place is not finite.
std::vector<VoxelIndex> interference(const Cloud& tool, const Pose& toolPlace,
                                     const Cloud& workpiece, int threads = 1);

}  // namespace cloudcontact
