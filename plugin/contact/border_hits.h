// Borders of open surfaces that cut into a cloud. The cloud's samples do not find them: beyond a
// border is outside.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "contact/pair_frame.h"

namespace cloudcontact {

// Places along the borders of the surface that one body is, a voxel apart: each that is inside the
// cloud becomes a hit, as if the cloud's surface above it had a sample there. `gap` [m]: that of
// HitSearch, 0 where the hits are real. Near misses give way to such hits, and to the places within
// `margin` [m] of the cloud if these are nearer: the cloud's samples lie beside a border, and see
// it aslant. Returns the gap of what `hits` are now.
double addBorderHits(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                     double margin, double gap, HitColumns& hits);

}  // namespace cloudcontact
