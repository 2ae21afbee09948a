// Solids as the command line states them: sphere:R, box:X,Y,Z ... in meters.
#pragma once

#include <cloudcontact/law/solid.h>

#include <optional>
#include <string>

namespace cloudcontact::program {

// A body's primitive: sphere:R, box:X,Y,Z (full edges), cylinder:R,H, capsule:R,H, cone:R,H (axis
// z; a capsule's H lies between the centers of its caps) or halfspace (z < 0). Empty where `text`
// is no primitive. Throws BadInput where its sizes are missing or out of range.
std::optional<Solid> readPrimitive(const std::string& text);

// The cuttable area C of `option`: sphere:R, box:X,Y,Z or ellipsoid:X,Y,Z (full lengths). Throws
// BadInput naming the option.
Solid readWindow(const std::string& option, const std::string& text);

}  // namespace cloudcontact::program
