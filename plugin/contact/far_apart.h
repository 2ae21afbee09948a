// Whether two bodies are so far from each other that none of their samples need be looked at.
#pragma once

#include <cloudcontact/contact/contact.h>

namespace cloudcontact {

// True only where the bodies' boxes, each along its body's own axes, are parted by more than
// `reach` [m].
bool farApart(const ContactBody& a, const ContactBody& b, double reach);

}  // namespace cloudcontact
