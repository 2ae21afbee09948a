// Whether a contact bears a body's weight.
#pragma once

#include "bullet/pair_query.h"

namespace cloudcontact {

// Whether points that are deeper than `least` [m] and bear the pull on one body over the other lie
// on all sides of its center, by `inside` [m] or more. Without pull any contact does.
bool holdsWeight(const PairQuery& query, const ContactResult& found, double least, double inside);

}  // namespace cloudcontact
