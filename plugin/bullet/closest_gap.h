// Answers to Bullet's queries: the points of a contact, or the smallest gap between two bodies.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <optional>

#include "bullet/pair_law.h"

class btManifoldResult;

namespace cloudcontact {

// The smallest gap, as a point of negative depth, if it is at most `within` [m]. It looks up all
// samples of each cloud in the other body: exact against a shape. Clouds that are not near are
// measured by the triangles of their surfaces.
std::optional<ContactPoint> closestGap(const ContactBody& a, const ContactBody& b, double within);

// Gives a Bullet query the points of a contact or, if the bodies are apart, the gap.
void reportTo(btManifoldResult& result, const PairSides& sides, const ContactBody& a,
              const ContactBody& b, const ContactResult& contact);

}  // namespace cloudcontact
