// The few shapes that are made of simpler ones, and text that is safe to draw.
#include "draw/drawing.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact::program {

namespace {

// Mean advance of DejaVu Sans over running English text, in ems; bold is wider.
constexpr double kAdvance = 0.58, kBoldAdvance = 0.66;

// Bytes of the UTF-8 character that starts at `k`; 0 where none does.
std::size_t characterAt(const std::string& text, std::size_t k) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(k);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  // 0xC0, 0xC1 and above 0xF4 never start one; the rarer wrong forms within are refused too.
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (length == 0 || first > 0xF4 || k + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(k + i) & 0xC0) != 0x80) return 0;
  const unsigned char second = byte(k + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool outside = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  // C1 control characters, and the two that XML does not allow.
  const bool control = first == 0xC2 && second < 0xA0;
  const bool noCharacter = first == 0xEF && second == 0xBF && byte(k + 2) >= 0xBE;
  return overlong || outside || control || noCharacter ? 0 : length;
}

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

std::string printable(const std::string& text) {
  std::string clean;
  for (std::size_t k = 0; k < text.size();) {
    const std::size_t length = characterAt(text, k);
    clean += length ? text.substr(k, length) : "?";
    k += std::max<std::size_t>(length, 1);
  }
  return clean;
}

}  // namespace cloudcontact::program
