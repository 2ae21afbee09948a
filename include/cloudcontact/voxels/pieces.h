// What becomes of a cloud when matter is taken from it: what is left of the voxels, and how many
// bodies that is. All results lie in the cloud's own grid, so that what is known of the whole (its
// field, its display mesh) can be renewed rather than made anew.
#pragma once

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <span>
#include <vector>

namespace cloudcontact {

// The cloud after cuts. They only take away: what would add matter is left as it is. Voxels may
// come in any order and more than once. Throws std::out_of_range where a voxel is outside the grid,
// std::invalid_argument where the cloud is empty.
Cloud cutCloud(const Cloud& cloud, std::span<const VoxelCut> cuts);

// The cloud's connected parts: two voxels hang together where they share a face and both have
// coverage, however little; an edge or a corner in common is not enough. A part has the coverage
// that the whole has in its voxels, so that coverages add up; the whole's list of materials, and of
// its voxels' materials its own. Parts come in the order of their first voxel, brick by brick. A
// cloud of one part is given back as it is; one without coverage has none.
std::vector<Cloud> pieces(const Cloud& cloud);

}  // namespace cloudcontact
