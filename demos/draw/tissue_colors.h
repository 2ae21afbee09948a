// One color for each tissue, the same in all pictures and charts.
#pragma once

#include <string>
#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Known tissues of teeth and flesh have natural colors, others distinct ones.
std::vector<Color> tissueColors(const std::vector<std::string>& names);

// Adds a colored square with the name on its right; returns the x of the next entry.
double addTissueKey(Drawing& drawing, const Point& at, const std::string& name, const Color& color);

}  // namespace cloudcontact::program
