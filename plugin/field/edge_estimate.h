// Estimates of what a combination of faces leaves of a block: by the part of each voxel that a face
// alone leaves, not by sub-samples. They cost a tenth of edge_block.h and choose what is computed.
#pragma once

#include "field/edge_block.h"

namespace cloudcontact {

// About the sum over the block with the last of two or three faces, a plane, at another place: by
// each face's part of a voxel, not by sub-samples.
float roughMass(const Combination& c, float place);
// About the residual of a combination, by the same means.
float roughResidual(const BlockTarget& target, const Combination& c);

}  // namespace cloudcontact
