// The contacts of a take or of a moment for the page (page/contacts.js).
#pragma once

#include "io/json.h"
#include "replay/packed_arrays.h"
#include "replay/replay_contacts.h"

namespace cloudcontact::program {

// Positions are integers in units of 1/8191 of the diagonal of all contacts, directions in 1/127,
// depths in 1/1023 of the largest depth. Forces are stored as square roots in 1/1023 of the
// largest, which keeps the digits of small ones.
Json contactsJson(const ReplayContacts& contacts, PackedArrays& arrays);

}  // namespace cloudcontact::program
