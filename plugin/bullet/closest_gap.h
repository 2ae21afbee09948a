// The gap of two bodies that do not touch, for Bullet's queries that ask for a distance.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <optional>

namespace cloudcontact {

// The smallest gap, as a point of negative depth, if it is at most `within` [m]. It looks up all
// samples of each cloud in the other body: exact against a shape. Clouds that are not near are
// measured by the triangles of their surfaces.
std::optional<ContactPoint> closestGap(const ContactBody& a, const ContactBody& b, double within);

}  // namespace cloudcontact
