// The contact of two shapes given by formulas, as ContactFinder gives that of clouds
// (docs/engine.md, "Shapes").
#pragma once

#include <cloudcontact/contact/contact.h>

namespace cloudcontact {

class PatchIds;

// Whether findShapes() takes this pair and law: shapes that are simple (isSimple), not both
// half-spaces, and one spring a pair. Not Foundation, whose force goes by the area of a dented
// surface.
bool takesShapes(const Solid& a, const Solid& b, const ContactSettings& settings);

// The contact of two bodies whose `shape` is set, but for the points' IDs: one patch of one, two or
// four points. False if the bodies are too deep in each other for closed forms (pressDirection).
// `voxel` [m]: the pair's. `meetsLightly`: bodies that overlap by less than a tenth of a voxel are
// seen as if they were about to touch, so that all of the faces that meet within the step count,
// and not the strip that touches first.
bool findShapes(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                double voxel, ContactResult& found, bool meetsLightly = false);
// The IDs of such a contact; `a` and `voxel` as above.
void giveIds(const ContactBody& a, double voxel, PatchIds& ids, ContactResult& found);

}  // namespace cloudcontact
