// A drawing as the text of an SVG file.
#pragma once

#include <string>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Groups become <g id="NAME">. Deterministic.
std::string svgText(const Drawing& drawing);

}  // namespace cloudcontact::program
