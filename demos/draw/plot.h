// A pair of axes: where numbers come to lie on paper, ticks of round numbers, names with units.
#pragma once

#include <string>
#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

struct Plot {
  Rectangle frame;
  double left = 0, right = 1;  // numbers at the frame's sides
  double low = 0, high = 1;    // at its bottom and top; either may be the greater

  double x(double number) const {
    return frame.low.x() + (number - left) / (right - left) * frame.size().x();
  }
  double y(double number) const {
    return frame.high.y() - (number - low) / (high - low) * frame.size().y();
  }
  Point at(double across, double up) const { return {x(across), y(up)}; }
};

// Round numbers from `low` to `high`, about `wanted` of them.
std::vector<double> roundTicks(double low, double high, int wanted);

// The frame, lines across it at round numbers, and their figures on the left; `name` above it.
void addUpright(Drawing& drawing, const Plot& plot, const std::string& name);
// The figures below it, and what they are.
void addAcross(Drawing& drawing, const Plot& plot, const std::string& name);

// A line through many points (x, y), as fine as paper shows: the least and the greatest of each
// px.
Polygons curve(const Plot& plot, const std::vector<Point>& numbers, const Color& color,
               double width);

}  // namespace cloudcontact::program
