// Which voxels of a workpiece a tool meets: the paper's Step 2 (Fig. 5), for the kinds of digital
// objects that meet without becoming another kind first. The voxels are the collision voxel set B;
// CollisionFinder::gather() makes their digital normal.
//
// All four ask the same: does the middle of a workpiece's voxel with matter lie in the tool? Only
// points cannot be asked that; of them a voxel must hold one. So where tool and voxels are known
// equally well the answers are the same, and elsewhere they differ by the tool's outermost voxels.
// The answer does not depend on the number of threads (0: all cores), and is sorted by z, y, x.
#pragma once

#include <cloudcontact/objects/octree.h>
#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/sphere_cloud.h>
#include <cloudcontact/voxels/column_cloud.h>
#include <cloudcontact/workpiece/base_vector_field.h>

#include <vector>

namespace cloudcontact {

// `toolPlace`: the tool's frame in the workpiece's. All throw std::invalid_argument where it is not
// finite, and as validate() of their kinds. No interference is an empty result.

// Points against an octree: each point goes down its path of cubes.
std::vector<VoxelIndex> interference(const PointCloud& tool, const Pose& toolPlace,
                                     const Octree& workpiece, int threads = 1);

// Columns against columns, as two Z-buffers are compared: the tool's intervals are carried over
// into the workpiece's columns ("matching the coordinate systems in advance"), intersected there,
// and what both share is divided into voxels of the columns' width; their indices count from the
// workpiece's origin. Intervals of less than half a share count as nothing.
std::vector<VoxelIndex> interference(const ColumnCloud& tool, const Pose& toolPlace,
                                     const ColumnCloud& workpiece, int threads = 1);

// Spheres against voxels.
std::vector<VoxelIndex> interference(const SphereCloud& tool, const Pose& toolPlace,
                                     const Cloud& workpiece, int threads = 1);

// Cloud against cloud: a tool's voxel of half its coverage or more is in.
std::vector<VoxelIndex> interference(const Cloud& tool, const Pose& toolPlace,
                                     const Cloud& workpiece, int threads = 1);

}  // namespace cloudcontact
