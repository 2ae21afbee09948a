// Interference: the collision voxels B of a tool and a workpiece, for kinds of digital objects that
// need no conversion first. Paper, Step 2, Fig. 5. CollisionFinder::gather() computes the digital
// normal of the voxels.
//
// A voxel of the workpiece is in B if it holds material and its center lies in the tool; against
// points, if it holds a point. Where tool and voxels are equally fine, all functions return the
// same voxels; elsewhere results differ by the tool's outermost voxels. Results are sorted by z,
// y, x and do not depend on the number of threads (0: all cores).
#pragma once

#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/sphere_cloud.h>
#include <cloudcontact/voxels/column_cloud.h>

#include <vector>

namespace cloudcontact {

// `toolPlace`: the tool's frame in the workpiece's. All throw std::invalid_argument where it is not
// finite, and as validate() of their kinds. Without interference the result is empty.

// Points against an octree: each point descends through the cubes that hold it.
std::vector<VoxelIndex> interference(const PointCloud& tool, const Pose& toolPlace,
                                     const Octree& workpiece, int threads = 1);

// Columns against columns, as two Z-buffers are compared ("matching the coordinate systems in
// advance"). The workpiece's intervals are divided into voxels of the columns' width, with indices
// from the workpiece's origin; a voxel counts if the tool's intervals hold its center. Intervals
// with a share below one half are ignored.
std::vector<VoxelIndex> interference(const ColumnCloud& tool, const Pose& toolPlace,
                                     const ColumnCloud& workpiece, int threads = 1);

// Spheres against voxels.
std::vector<VoxelIndex> interference(const SphereCloud& tool, const Pose& toolPlace,
                                     const Cloud& workpiece, int threads = 1);

// Voxels against voxels: the tool's voxels with coverage of one half or more.
std::vector<VoxelIndex> interference(const Cloud& tool, const Pose& toolPlace,
                                     const Cloud& workpiece, int threads = 1);

}  // namespace cloudcontact
