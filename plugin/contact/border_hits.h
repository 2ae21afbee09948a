// Borders of open surfaces that cut into a cloud. The cloud's samples do not find them: beyond a
// border is outside.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "contact/pair_frame.h"

namespace cloudcontact {

// Places along the borders of the surface that one body is, a voxel apart: each that is inside the
// cloud becomes a hit, as if the cloud's surface above it had a sample there. Appends them and
// returns their number; with `instead` they replace earlier hits if there are any.
std::size_t addBorderHits(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                          bool instead, HitColumns& hits);

}  // namespace cloudcontact
