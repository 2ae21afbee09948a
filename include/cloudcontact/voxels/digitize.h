// From a mesh to a cloud: depth columns along an axis, cut into voxels (paper, step 1 and Fig. 4;
// docs/method.md, "Step 1: digital objects").
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/digitize_settings.h>

#include <Eigen/Geometry>
#include <vector>

namespace cloudcontact {

// The voxels of a body. The mesh is repaired first; holes are closed. Throws std::invalid_argument
// on a bad setting or a mesh without volume, std::length_error where the voxels would need more
// than settings.maxBytes (the message names a voxel size that fits).
Cloud digitize(const Mesh& mesh, const DigitizeSettings& settings,
               DigitizeReport* report = nullptr);

// A body of several materials: meshes inside one another or side by side, named after their
// materials. The body is their union. A voxel is of the material of the smallest mesh that holds at
// least half of the voxel's material. Meshes that bound no volume of their own (half of a shell
// whose other half is another mesh) count as part of the largest. With fewer than two meshes that
// bound a volume the cloud has no materials. Throws as above, and std::invalid_argument unless
// there are 1 to 256 meshes.
Cloud digitize(const std::vector<NamedMesh>& meshes, const DigitizeSettings& settings,
               DigitizeReport* report = nullptr);

// The voxel of a body of which nothing but the size is known: a hundredth of the diagonal of its
// bounds [m]. 0 for empty bounds.
double suggestedVoxel(const Eigen::AlignedBox3d& bounds);
// The voxel of a mesh for which none is stated [m]; the program takes it where no --voxel is given.
// A hundredth of the diagonal, or down to half of that where more than a tenth of the chords
// through the body are walls of less than two voxels, or walls and grooves in a row of less than
// five in the mean: an M16 nut gets 0.2 mm, ten voxels a pitch. Throws std::invalid_argument for a
// mesh without a size, and as validate(Mesh) does.
double suggestedVoxel(const Mesh& mesh);

// An upper bound of the memory that digitize() needs, without running it [bytes]. Throws
// std::invalid_argument as digitize() does.
std::size_t digitizeBytes(const Mesh& mesh, double voxelSize);

}  // namespace cloudcontact
