// Axes and curves.
#include "draw/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "draw/picture_elements.h"

namespace cloudcontact::program {

namespace {

std::string tickText(double number, double step) {
  char text[32];
  const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  std::snprintf(text, sizeof text, "%.*f", digits, number == 0 ? 0.0 : number);
  return text;
}

double stepOf(const std::vector<double>& ticks) {
  return ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
}

}  // namespace

std::vector<double> roundTicks(double low, double high, int wanted) {
  if (low > high) std::swap(low, high);
  if (!(high > low)) return {low};
  const double rough = (high - low) / wanted;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double times : {5.0, 2.0, 1.0})
    if (times * power >= rough) step = times * power;
  std::vector<double> ticks;
  for (auto k = static_cast<long>(std::ceil(low / step - 1e-9));
       static_cast<double>(k) * step <= high + 1e-9 * step; ++k)
    ticks.push_back(static_cast<double>(k) * step);
  return ticks;
}

void addVerticalAxis(Drawing& drawing, const Plot& plot, const std::string& name) {
  const std::vector<double> ticks = roundTicks(plot.low, plot.high, 4);
  for (const double tick : ticks) {
    const double y = plot.y(tick);
    drawing.add(line({plot.frame.low.x(), y}, {plot.frame.high.x(), y}, kRule, 1));
    drawing.add(Text{{plot.frame.low.x() - 8, y + 5},
                     tickText(tick, stepOf(ticks)),
                     kSmallText,
                     kFaintInk,
                     Align::Right});
  }
  drawing.add(Polygons{{ringOf(plot.frame)}, {std::nullopt, kRule, 1}});
  drawing.add(Text{plot.frame.low - Point(0, 9), name, kTextSize, kInk, Align::Left, true});
}

void addHorizontalAxis(Drawing& drawing, const Plot& plot, const std::string& name) {
  const std::vector<double> ticks = roundTicks(plot.left, plot.right, 10);
  for (const double tick : ticks) {
    const Point at(plot.x(tick), plot.frame.high.y());
    drawing.add(line(at, at + Point(0, 5), kFaintInk, 1));
    drawing.add(Text{at + Point(0, 20), tickText(tick, stepOf(ticks)), kSmallText, kFaintInk,
                     Align::Middle});
  }
  drawing.add(Text{
      {plot.frame.center().x(), plot.frame.high.y() + 40}, name, kTextSize, kInk, Align::Middle});
}

Polygons curve(const Plot& plot, const std::vector<Point>& numbers, const Color& color,
               double width) {
  std::vector<Point> points;
  std::size_t k = 0;
  while (k < numbers.size()) {
    const double column = std::floor(plot.x(numbers[k].x()));
    std::size_t least = k, most = k;
    for (; k < numbers.size() && std::floor(plot.x(numbers[k].x())) == column; ++k) {
      if (numbers[k].y() < numbers[least].y()) least = k;
      if (numbers[k].y() > numbers[most].y()) most = k;
    }
    for (const std::size_t i : {std::min(least, most), std::max(least, most)})
      points.push_back(plot.at(numbers[i].x(), numbers[i].y()));
  }
  return {{points}, {std::nullopt, color, width}, false};
}

}  // namespace cloudcontact::program
