// Second step of the field: edges and corners (docs/engine.md, "Edges"). A window across an edge
// sees a blunt surface, 30 deg off at half a voxel from a right angle. Where a block's quadric does
// not explain its coverage, the flat or gently curved faces found beside it are continued into the
// block. Two or three of them, or four to six at a tip, replace the quadric if their intersection
// (convex edge) or union (concave edge) reproduces the coverage well enough. If a face is too
// narrow for a fit of its own, as on the crest of a thin thread, the plane midway between two
// others is tried, placed by the block's mass.
#pragma once

#include "field/edge_queue.h"

namespace cloudcontact {

void findEdges(FieldDraft& draft);

// Marks in `queue` the searches that renewFits(draft, refitted) = changed has made stale, and does
// `most` of all that wait there (0: all). `before` are the draft's bricks before that. Returns the
// voxels whose pieces appeared, disappeared or changed.
VoxelSet renewEdges(FieldDraft& draft, EdgeQueue& queue, const SurfaceBricks& before,
                    const VoxelSet& refitted, const VoxelSet& changed, std::optional<int> most);

}  // namespace cloudcontact
