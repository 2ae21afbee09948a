// From a mesh to a cloud: depth columns along an axis, cut into voxels (paper, step 1 and Fig. 4).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/digitize_settings.h>

#include <vector>

namespace cloudcontact {

// Throws std::invalid_argument on a bad setting or a mesh without volume, std::length_error where
// the voxels would need more than maxBytes: the message says how much, and the size that fits.
Cloud digitize(const Mesh& mesh, const DigitizeSettings& settings,
               DigitizeReport* report = nullptr);

// A body of several materials: meshes that lie within one another or side by side, each of the
// material that it is named after. The body is all of them together; a voxel is of the smallest
// mesh that has at least half of the voxel's matter. Meshes that bound no volume of their own (a
// half of a shell whose other half is another mesh) leave their part to the largest. A cloud
// with fewer than two meshes that bound a volume has no materials. Throws as above, and where there
// is no mesh or more than 256.
Cloud digitize(const std::vector<NamedMesh>& meshes, const DigitizeSettings& settings,
               DigitizeReport* report = nullptr);

// An upper bound of the memory that digitising would hold, before anything is allocated [bytes].
std::size_t digitizeBytes(const Mesh& mesh, double voxelSize);

}  // namespace cloudcontact
