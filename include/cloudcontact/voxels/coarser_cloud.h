// Larger voxels of the same body, summed up from its own.
#pragma once

#include <cloudcontact/voxels/cloud.h>

namespace cloudcontact {

// The cloud with voxels 2^`halvings` times as large: each holds the mean coverage of the 8^halvings
// voxels in it, rounded once to 1/255 (halves to even), and the material that fills most of it. So
// a body keeps its volume, to less than 1/510 of each voxel at its surface. Its voxels are made of
// whole voxels of every finer level, and at least two empty ones lie around the body. Mass
// properties are better taken from the finest. Throws std::invalid_argument if `halvings` is not in
// 0..10.
Cloud coarserCloud(const Cloud& cloud, int halvings = 1);

}  // namespace cloudcontact
