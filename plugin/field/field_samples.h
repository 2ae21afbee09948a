// Third step of the field: samples. Each piece of surface inside a voxel becomes a quadrature point
// at its centroid with its area, so that sums over samples integrate linear functions over flat
// faces exactly (docs/force.md, "Samples").
#pragma once

#include "field/field_draft.h"
#include "field/sample_set.h"

namespace cloudcontact {

// Samples of all voxels, or of those in `scope`. Also stores the areas and centroids of the pieces
// in the draft.
std::vector<CutSample> cutSamples(FieldDraft& draft, const VoxelSet* scope = nullptr);

}  // namespace cloudcontact
