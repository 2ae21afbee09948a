// The voxels of a cloud in another grid.
#pragma once

#include <cloudcontact/voxels/cloud.h>

namespace cloudcontact {

// The box around the voxels with material, not around the grid [m].
Eigen::AlignedBox3d boundsOfVoxels(const Cloud& cloud);

// The cloud with its voxels stretched to cells of edges `spacing` [m], the lowest corner of voxel
// (0,0,0) at `origin`, in voxels of `voxelSize` [m]. Voxels that the surface crosses are divided
// along the surface inside them, so smaller voxels keep it smooth. Throws as cloudGrid() does, with
// messages that begin with `what`.
Cloud inVoxels(const char* what, const Cloud& cloud, const Vec3& spacing, const Vec3& origin,
               double voxelSize);

}  // namespace cloudcontact
