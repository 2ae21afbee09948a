// Figures, bars and tables of the pictures.
#include "picture_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace cloudcontact::program {

namespace {

constexpr double kLine = 22;                          // from one line of a table to the next [px]
constexpr double kMostBar = 160, kMostSmallBar = 52;  // lengths of scale bars [px]

// Three digits, never an exponent where the number is below a million.
std::string threeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text,
                std::abs(value) < 999.5 || std::abs(value) > 1e6 ? "%.3g" : "%.0f", value);
  return text;
}

// The greatest of 1, 2 and 5 times a power of ten that is not above `most`.
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

std::string lengthText(double metres) {
  const double size = std::abs(metres);
  if (size == 0) return "0 mm";
  if (size < 1e-5) return threeDigits(1e6 * metres) + " \u00b5m";
  if (size < 0.9995) return threeDigits(1e3 * metres) + " mm";
  return threeDigits(metres) + " m";
}

std::string volumeText(double cubicMetres) {
  if (cubicMetres < 1e-6) return threeDigits(1e9 * cubicMetres) + " mm\u00b3";
  if (cubicMetres < 1e-2) return threeDigits(1e6 * cubicMetres) + " cm\u00b3";
  return threeDigits(cubicMetres) + " m\u00b3";
}

std::string forceText(double newtons) {
  const double size = std::abs(newtons);
  if (size > 0 && size < 0.1) return threeDigits(1e3 * newtons) + " mN";
  if (size >= 1000) return threeDigits(1e-3 * newtons) + " kN";
  return threeDigits(newtons) + " N";
}

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) < 9.995 ? "%.2f" : "%.1f", value);
  return text;
}

std::string tripleText(const Eigen::Vector3d& v) {
  std::string text;
  for (int k = 0; k < 3; ++k) {
    char number[48];
    std::snprintf(number, sizeof number, "%.3f", std::abs(v[k]) < 5e-4 ? 0.0 : v[k]);
    text += (k ? ", " : "(") + std::string(number);
  }
  return text + ")";
}

std::string countText(std::size_t count) {
  std::string text = std::to_string(count);
  for (int k = static_cast<int>(text.size()) - 3; k > 0; k -= 3)
    text.insert(static_cast<std::size_t>(k), "\u2009");
  return text;
}

std::string shortName(const std::string& path, std::size_t most) {
  const std::string name = std::filesystem::path(path).filename().string();
  if (name.size() <= most) return name;
  const std::size_t half = (most - 1) / 2;
  return name.substr(0, half) + "\u2026" + name.substr(name.size() - half);
}

void addTitle(Drawing& drawing, const std::string& title, const std::string& below) {
  drawing.title = title;
  drawing.add(Text{{kMargin, 40}, title, 22, kInk, Align::Left, true});
  drawing.add(Text{{kMargin, 64}, below, 15, kFaintInk});
}

void addScaleBar(Drawing& drawing, const Rectangle& frame, double pxPerMetre) {
  const double length = roundBelow(kMostBar / pxPerMetre);
  const Point left(frame.low.x() + 16, frame.high.y() - 16);
  const Point right = left + Point(length * pxPerMetre, 0);
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
                double pxPerMetre) {
  drawing.add(Text{frame.low + Point(8, 18), words, kSmallText, kFaintInk});
  const double length = roundBelow(kMostSmallBar / pxPerMetre);
  const Point right(frame.high.x() - 10, frame.low.y() + 14);
  const Point left = right - Point(length * pxPerMetre, 0);
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
