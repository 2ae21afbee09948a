// The smallest gap between two bodies that do not touch, for Bullet's closest-point queries.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <optional>

namespace cloudcontact {

// The nearest place, depth negative, where the gap is at most `within` [m]. Every surface sample of
// a cloud is looked up in the other body: exact against a formula, and between two clouds as far as
// their bands reach, beyond which there is nothing. For queries: it costs all samples.
std::optional<ContactPoint> closestGap(const ContactBody& a, const ContactBody& b, double within);

}  // namespace cloudcontact
