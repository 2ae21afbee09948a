// A pair of axes: maps numbers to the drawing, with round ticks and labels.
#pragma once

#include <string>
#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

struct Plot {
  Rectangle frame;
  double left = 0, right = 1;  // values at the frame's sides
  double low = 0, high = 1;    // values at its bottom and top, in any order

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

// Adds the vertical axis: the frame, grid lines with figures on the left, and `name` above.
void addVerticalAxis(Drawing& drawing, const Plot& plot, const std::string& name);
// Adds the horizontal axis: figures and `name` below the frame.
void addHorizontalAxis(Drawing& drawing, const Plot& plot, const std::string& name);

// A line through many points (x, y), reduced to the lowest and highest of each px.
Polygons curve(const Plot& plot, const std::vector<Point>& numbers, const Color& color,
               double width);

}  // namespace cloudcontact::program
