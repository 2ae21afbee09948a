// Draws titles, scale bars, tables and keys.
#include "draw/picture_elements.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact::program {

namespace {

constexpr double kLine = 22;                          // line height of a table [px]
constexpr double kMostBar = 160, kMostSmallBar = 52;  // largest lengths of scale bars [px]

// The largest of 1, 2 and 5 times a power of ten up to `most`.
double roundBelow(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double step : {5.0, 2.0})
    if (step * power <= most) return step * power;
  return power;
}

void addBar(Drawing& drawing, const Point& left, const Point& right, double width) {
  drawing.add(line(left, right, kInk, width));
  for (const Point& end : {left, right})
    drawing.add(line(end - Point(0, 5), end + Point(0, 5), kInk, std::min(width, 2.0)));
}

}  // namespace

void addTitle(Drawing& drawing, const std::string& title, const std::string& below) {
  drawing.title = title;
  drawing.add(Text{{kMargin, 40}, title, 22, kInk, Align::Left, true});
  drawing.add(Text{{kMargin, 64}, below, 15, kFaintInk});
}

void addScaleBar(Drawing& drawing, const Rectangle& frame, double pxPerMeter) {
  const double length = roundBelow(kMostBar / pxPerMeter);
  const Point left(frame.low.x() + 16, frame.high.y() - 16);
  const Point right = left + Point(length * pxPerMeter, 0);
  drawing.add(GroupBegin{"scale-bar", {}});
  const Rectangle back{left - Point(8, 28), right + Point(8, 9)};
  drawing.add(Polygons{{ringOf(back)}, {Color{255, 255, 255, 0.8}, std::nullopt, 0}});
  addBar(drawing, left, right, 3);
  drawing.add(Text{(left + right) / 2 - Point(0, 10), lengthText(length), kTextSize, kInk,
                   Align::Middle, true, true});
  drawing.add(GroupEnd{});
}

void addFrame(Drawing& drawing, const Rectangle& frame) {
  drawing.add(Polygons{{ringOf(frame)}, {std::nullopt, kRule, 1}});
}

void addCaption(Drawing& drawing, const Rectangle& frame, const std::string& words,
                double pxPerMeter) {
  drawing.add(Text{frame.low + Point(8, 18), words, kSmallText, kFaintInk});
  const double length = roundBelow(kMostSmallBar / pxPerMeter);
  const Point right(frame.high.x() - 10, frame.low.y() + 14);
  const Point left = right - Point(length * pxPerMeter, 0);
  addBar(drawing, left, right, 2);
  drawing.add(Text{left + Point(-7, 4), lengthText(length), kSmallText, kInk, Align::Right});
}

Rectangle belowCaption(const Rectangle& frame) {
  return {frame.low + Point(0, 26), frame.high};
}

Table::Table(Drawing& drawing, const Point& at, double width)
    : drawing_(drawing), left_(at.x()), width_(width), y_(at.y()) {}

void Table::heading(const std::string& words) {
  drawing_.add(Text{{left_, y_ + 14}, words, 15, kInk, Align::Left, true});
  y_ += 20;
  drawing_.add(line({left_, y_}, {left_ + width_, y_}, kRule, 1));
  y_ += 2;
}

void Table::row(const std::string& name, const std::string& figure) {
  y_ += kLine;
  drawing_.add(Text{{left_, y_ - 4}, name, kTextSize, kFaintInk});
  drawing_.add(Text{{left_ + width_, y_ - 4}, figure, kTextSize, kInk, Align::Right});
}

void Table::note(const std::string& words) {
  y_ += 19;
  drawing_.add(Text{{left_, y_ - 4}, words, kSmallText, kFaintInk});
}

void addKeyText(Drawing& drawing, const Point& at, const std::string& term,
                const std::string& meaning) {
  drawing.add(Text{at, term, kTextSize, kInk, Align::Left, true});
  drawing.add(Text{at + Point(0, 18), meaning, kSmallText, kFaintInk});
}

}  // namespace cloudcontact::program
