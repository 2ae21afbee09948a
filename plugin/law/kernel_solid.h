// A solid as kernels know it (kernels/base/plain_solid.h).
#pragma once

#include <cloudcontact/law/solid.h>

#include <optional>

#include "kernels/base/plain_solid.h"

namespace cloudcontact {

// None of a hull, a cloud and triangles, whose numbers are lists.
std::optional<CcSolid> plainSolid(const Solid& solid);

}  // namespace cloudcontact
