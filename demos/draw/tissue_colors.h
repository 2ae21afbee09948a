// One colour a tissue, the same in every picture and chart.
#pragma once

#include <string>
#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Those of teeth and flesh look as one expects; all others get colours that stay apart.
std::vector<Color> tissueColors(const std::vector<std::string>& names);

// A coloured square with the name right of it; returns where the next one may stand.
double addTissueKey(Drawing& drawing, const Point& at, const std::string& name, const Color& color);

}  // namespace cloudcontact::program
