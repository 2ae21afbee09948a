// Lines, arrows and the width of text.
#include "draw/drawing.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact::program {

namespace {

// Mean advance of DejaVu Sans over running English text, in ems; bold is wider.
constexpr double kAdvance = 0.58, kBoldAdvance = 0.66;

}  // namespace

double widthOf(const std::string& words, double size, bool bold) {
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
  const auto bytes = std::count_if(words.begin(), words.end(), continues);
  const auto characters = static_cast<double>(words.size()) - static_cast<double>(bytes);
  return characters * size * (bold ? kBoldAdvance : kAdvance);
}

std::vector<Point> ringOf(const Rectangle& r) {
  return {r.low, {r.high.x(), r.low.y()}, r.high, {r.low.x(), r.high.y()}};
}

Polygons line(const Point& from, const Point& to, const Color& color, double width) {
  return {{{from, to}}, {std::nullopt, color, width}, false};
}

Polygons arrow(const Point& from, const Point& to, const Color& color, double width) {
  const double length = (to - from).norm();
  if (!(length > 0)) return {};
  const Point along = (to - from) / length, aside(-along.y(), along.x());
  const double head = std::min(3.6 * width, 0.6 * length);
  const Point neck = to - head * along;
  const double half = width / 2, wing = 0.42 * head;
  return {{{from + half * aside, neck + half * aside, neck + wing * aside, to, neck - wing * aside,
            neck - half * aside, from - half * aside}},
          {color, std::nullopt, 0}};
}

}  // namespace cloudcontact::program
