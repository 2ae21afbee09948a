// Cuts in a cloud: the voxels that remain, and the connected bodies that they form. All results lie
// in the cloud's own grid, so that its field and its display mesh can be updated instead of
// rebuilt.
#pragma once

#include <cloudcontact/base/span.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <vector>

namespace cloudcontact {

// The cloud after cuts. Cuts only remove material; entries that would add some are ignored. Voxels
// may come in any order and repeatedly. Throws std::out_of_range where a voxel is outside the grid,
// std::invalid_argument where the cloud is empty.
Cloud cutCloud(const Cloud& cloud, Span<const VoxelCut> cuts);

// The connected parts of a cloud. Two voxels are connected where they share a face and both have
// coverage; a common edge or corner does not connect. Parts keep the coverage and the materials of
// their voxels, so coverages add up to those of the whole. They come in the order of their first
// voxel, brick by brick. A cloud of one part is returned unchanged; one without coverage has no
// part.
std::vector<Cloud> pieces(const Cloud& cloud);

// pieces(after) for a cut of `before`, which must be a cloud of one part in the same grid. Faster:
// where the voxels beside the cut are still connected near it, nothing farther is searched.
std::vector<Cloud> pieces(const Cloud& after, const Cloud& before);

}  // namespace cloudcontact
