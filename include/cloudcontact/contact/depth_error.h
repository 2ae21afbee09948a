// How far the depth of a contact may be off.
#pragma once

#include <cloudcontact/contact/contact.h>

namespace cloudcontact {

// [m] The pair's depth is right to this in 95 % of poses, as measured on bodies whose contact is
// known (docs/measurements.md, "Error of a depth"). Of two bodies deeper in each other than half a
// wall nothing is known, and this does not say so. 0 without a contact. `contact`: of these bodies
// where they are now, by ContactFinder or a device.
double depthError(const ContactBody& a, const ContactBody& b, const ContactResult& contact);

}  // namespace cloudcontact
