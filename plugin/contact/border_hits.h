// Borders of open surfaces that cut into a cloud. The cloud's samples do not find them: beyond a
// border is outside.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "contact/pair_frame.h"

namespace cloudcontact {

// Places along the borders of the surface that one body is, about a voxel apart: each that is
// inside the cloud becomes a hit, as if the cloud's surface above it had a sample there. `gap` [m]:
// that of HitSearch, 0 where the hits are real; near misses give way to them. Where nothing
// touches, the places that are nearest become near misses if they are nearer than the cloud's
// samples, as far as the margin reaches: samples lie beside a border, and see it aslant. Returns
// the gap of what `hits` are now.
double addBorderHits(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                     double margin, double gap, HitColumns& hits);

}  // namespace cloudcontact
