// First step of the field: which voxels the surface crosses, and the quadric of each.
#pragma once

#include "field/field_draft.h"

namespace cloudcontact {

// Coverage, 0..1, of the 3x3x3 block around a voxel, x fastest.
void gatherBlock(const Cloud& cloud, int x, int y, int z, float* coverage);

// The quadric of a voxel's block. Its weight is 0 where the surface does not cross the voxel.
CcSurface fitVoxel(const Cloud& cloud, int x, int y, int z);

void fitVoxels(FieldDraft& draft);
// Repeats the fit in `scope`. Returns the voxels whose quadric appeared, disappeared or changed.
VoxelSet renewFits(FieldDraft& draft, const VoxelSet& scope);

}  // namespace cloudcontact
