// Second step of the field: edges and corners (docs/method.md, "Edges"). A window across an edge
// sees a blunt surface, 30 deg off at half a voxel from a right angle. Where a block's quadric does
// not explain its coverage, the flat or gently curved faces found beside it are continued into the
// block. Two or three of them, or four to six at a tip, replace the quadric if their intersection
// (convex edge) or union (concave edge) reproduces the coverage well enough. If a face is too
// narrow for a fit of its own, as on the crest of a thin thread, the plane midway between two
// others is tried, placed by the block's mass.
#pragma once

#include "field/field_draft.h"

namespace cloudcontact {

void findEdges(FieldDraft& draft);

// Repeats the search after renewFits(draft, refitted) = changed. `before` are the draft's bricks
// before that. Returns the voxels whose pieces appeared, disappeared or changed.
VoxelSet renewEdges(FieldDraft& draft, const SurfaceBricks& before, const VoxelSet& refitted,
                    VoxelSet changed);

}  // namespace cloudcontact
